#include "capture/session/offsets_json.h"

#include <array>
#include <cstddef>
#include <string>
#include <utility>

#include "capture/session/json_number.h"
#include "core/geometry/vec2.h"

namespace reseau {

using nlohmann::ordered_json;

ordered_json channel_offsets_to_json(const ChannelOffsets& offsets) {
  const auto pair = [](Vec2 v) {
    return ordered_json::array({number_or_null(v.x), number_or_null(v.y)});
  };
  ordered_json out = ordered_json::object();
  constexpr std::array<std::pair<std::size_t, const char*>, 3> kOthers{
      {{0, "red"}, {2, "blue"}, {3, "infrared"}}};
  for (const auto& [c, name] : kOthers) {
    ordered_json one = ordered_json::object();
    if (const auto& at = offsets.from_green[c]) {
      one["px"] = pair(at->at_px);
      one["sd_px"] = pair(at->sd_px);
      if (at->growth) {
        one["growth_to_right_px"] = pair(at->growth->along_x_px);
        one["growth_to_right_sd_px"] = pair(at->growth->along_x_sd_px);
        one["growth_to_last_line_px"] = pair(at->growth->along_y_px);
        one["growth_to_last_line_sd_px"] = pair(at->growth->along_y_sd_px);
      }
    } else {
      const std::string& why = offsets.reason[c];
      put_missing(one, "px", why.empty() ? "the réseau was not looked at" : why);
    }
    out[name] = one;
  }
  out["tiles"] = offsets.tiles;
  return out;
}

}  // namespace reseau
