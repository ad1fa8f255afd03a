#pragma once

#include <memory>

#include "drivers/scsi/sg_node.h"
#include "drivers/usb/fault_transport.h"

namespace reseau {

// Fails one command of a SCSI node as FaultTransport fails one transfer: a stall and a timeout
// before the unit sees it, a short one loses the second half of its data, a disconnection is for
// good. Commands are counted from 0.
[[nodiscard]] std::unique_ptr<SgNode> make_fault_sg(std::unique_ptr<SgNode> inner, Fault fault);

// The same, and tells how many commands were sent so far; for sweeps.
class FaultSg final : public SgNode {
 public:
  FaultSg(std::unique_ptr<SgNode> inner, Fault fault) : inner_(std::move(inner)), fault_(fault) {}
  void exchange(SgExchange& exchange) override;
  [[nodiscard]] long n_commands() const { return n_commands_; }

 private:
  std::unique_ptr<SgNode> inner_;
  Fault fault_;
  long n_commands_ = 0;
};

}  // namespace reseau
