// SET PARAMETER / EXECUTE / GET PARAMETER: which operations exist, how long their parameters are
// and what they may be. Source: LS-5000 interface specification, operations; LS-50 firmware 1.02.
#pragma once

#include <cstdint>
#include <optional>

#include "drivers/sim/sense.h"
#include "drivers/sim/unit_model.h"
#include "drivers/sim/wire_bytes.h"

namespace reseau::sim {

inline constexpr std::uint8_t kOpInitialise = 0x80;
inline constexpr std::uint8_t kOpOrigin = 0x81;
inline constexpr std::uint8_t kOpFocusAtLoad = 0x91;
inline constexpr std::uint8_t kOpAutofocus = 0xa0;
inline constexpr std::uint8_t kOpShading = 0xb0;
inline constexpr std::uint8_t kOpDeviceData = 0xb3;
inline constexpr std::uint8_t kOpUnloadTimer = 0xb4;
inline constexpr std::uint8_t kOpMoveStage = 0xc0;
inline constexpr std::uint8_t kOpMoveFocus = 0xc1;
inline constexpr std::uint8_t kOpUnload = 0xd0;
inline constexpr std::uint8_t kOpLoad = 0xd1;
inline constexpr std::uint8_t kOpPosition = 0xd2;
inline constexpr std::uint8_t kOpLock = 0xd6;
inline constexpr std::size_t kMaxParameterBytes = 0x0d;

struct OperationParameters {
  std::uint8_t code = 0;
  std::uint32_t first = 0, second = 0;
};

// Fewest bytes of parameters, or empty when the unit does not list the operation. groups: as
// operation_groups() gives them.
[[nodiscard]] std::optional<std::size_t> operation_min_bytes(ByteView groups, std::uint8_t code);
// Missing bytes count as zero. kBadParameter outside the ranges; max_address: last film address.
[[nodiscard]] Sense check_operation(const OperationParameters& parameters, const UnitModel& model,
                                    std::uint32_t max_address);
[[nodiscard]] OperationParameters parse_operation(std::uint8_t code, ByteView data);

}  // namespace reseau::sim
