// The XMP packet of a master: roles of the channels and settings of the capture, in a namespace of
// our own, and reading them back.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "core/line/capture_context.h"
#include "core/line/line_format.h"

namespace reseau {

struct MasterXmp {
  CaptureContext context;
  std::string film;
};

// UTF-8, the same text for the same arguments.
[[nodiscard]] std::string make_master_xmp(const LineFormat& format, const CaptureContext& context,
                                          const std::string& film);

// Nothing when the packet is not one of ours. Damaged values are left out; never throws.
[[nodiscard]] std::optional<MasterXmp> read_master_xmp(std::string_view packet);

}  // namespace reseau
