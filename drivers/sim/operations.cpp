#include "drivers/sim/operations.h"

#include <algorithm>

#include "drivers/sim/unit_model.h"

namespace reseau::sim {
namespace {

bool listed(ByteView groups, std::uint8_t code) {
  if (code < 0x80 || code >= 0xe0) return false;
  const std::size_t group = 2 * (static_cast<std::size_t>(code >> 4) - 8);
  return (groups[group] >> (code & 0x0f) & 1) != 0;
}

}  // namespace

std::optional<std::size_t> operation_min_bytes(ByteView groups, std::uint8_t code) {
  if (!listed(groups, code)) return std::nullopt;
  switch (code) {
    case kOpInitialise:
    case kOpOrigin:
    case kOpShading:
    case kOpUnload:
    case kOpLoad:
      return 0;
    case kOpAutofocus:
    case kOpUnloadTimer:
      return 9;
    case kOpDeviceData:
      return kMaxParameterBytes;
    default:
      return 5;
  }
}

OperationParameters parse_operation(std::uint8_t code, ByteView data) {
  Bytes padded(data.begin(), data.end());
  padded.resize(kMaxParameterBytes, 0);
  return {code, get32(padded, 1), get32(padded, 5)};
}

Sense check_operation(const OperationParameters& p, const UnitModel& model,
                      std::uint32_t max_address) {
  bool allowed = true;
  switch (p.code) {
    case kOpAutofocus:
      allowed = p.first < static_cast<std::uint32_t>(model.sensor_px) && p.second <= max_address;
      break;
    case kOpUnloadTimer:
      allowed = p.first >= 60 && p.first <= 3600 && p.second <= 1;
      break;
    case kOpMoveStage:
    case kOpPosition:
      allowed = p.first <= max_address;
      break;
    case kOpMoveFocus:
      allowed = p.first <= static_cast<std::uint32_t>(model.focus_max);
      break;
    case kOpFocusAtLoad:
    case kOpLock:
      allowed = p.first <= 1;
      break;
    default:
      break;
  }
  return allowed ? kGood : kBadParameter;
}

}  // namespace reseau::sim
