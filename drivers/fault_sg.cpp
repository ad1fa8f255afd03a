#include "drivers/fault_sg.h"

namespace reseau {

std::unique_ptr<SgNode> make_fault_sg(std::unique_ptr<SgNode> inner, Fault fault) {
  return std::make_unique<FaultSg>(std::move(inner), fault);
}

void FaultSg::exchange(SgExchange& e) {
  constexpr int kNoConnect = 1, kTimeOut = 3, kError = 7;
  const long command = n_commands_++;
  const bool struck = command == fault_.transfer;
  e.status = 0;
  e.residual_bytes = e.in.size();
  if (fault_.kind == Fault::Kind::kDisconnect && command >= fault_.transfer) {
    e.host_status = kNoConnect;
  } else if (struck && fault_.kind == Fault::Kind::kTimeout) {
    e.host_status = kTimeOut;
  } else if (struck && fault_.kind == Fault::Kind::kStall) {
    e.host_status = kError;
  } else {
    inner_->exchange(e);
    if (struck && fault_.kind == Fault::Kind::kShort) {
      e.residual_bytes = e.in.size() - (e.in.size() - e.residual_bytes) / 2;
    }
  }
}

}  // namespace reseau
