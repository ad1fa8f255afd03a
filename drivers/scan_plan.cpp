#include "drivers/scan_plan.h"

#include <cstdio>

#include "core/line/channel_name.h"

namespace reseau {
namespace {

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

std::string focus_text(const ScanPlan& plan) {
  switch (plan.focus.mode) {
    case FocusRequest::Mode::kAuto:
      return "auto at x " + std::to_string(plan.focus_x_px) + " y " +
             std::to_string(plan.focus_y_px) + " px";
    case FocusRequest::Mode::kKeep:
      return "keep";
    case FocusRequest::Mode::kPosition:
      return "position " + std::to_string(plan.focus.position);
  }
  return {};
}

std::string exposure_text(const ExposureRequest& exposure) {
  if (exposure.mode == ExposureRequest::Mode::kMeter) {
    return "meter, times " + number(exposure.factor) + (exposure.lock ? "" : ", not locked");
  }
  std::string text = "fixed";
  for (const auto& us : exposure.exposure_us)
    text += us ? " " + number(*us) + " us" : " unit's own";
  return text;
}

std::string channels_text(const LineFormat& format) {
  std::string text;
  for (const Channel channel : format.channels) {
    if (!text.empty()) text += ' ';
    text += channel_name(channel);
  }
  return text;
}

}  // namespace

std::string ScanPlan::describe() const {
  const auto n = [](int value) { return std::to_string(value); };
  std::string special;
  if (frame_offset_px != 0) special += "frame moved by: " + n(frame_offset_px) + " optical px\n";
  if (crop_top_lines != 0) special += "crop: top " + n(crop_top_lines) + " lines\n";
  if (samples != 1) special += "samples: " + n(samples) + " per line\n";
  if (sensor_lines != 1) special += "sensor lines: " + n(sensor_lines) + "\n";
  if (overview) special += "overview: yes\n";
  return "resolution: " + n(resolution_dpi) + " dpi, pitch " + n(pitch) + "\n" + "window: x " +
         n(x_origin_px) + " y " + n(y_origin_px) + " width " + n(window_width_px) + " height " +
         n(window_height_px) + " optical px, frame " + n(frame) + "\n" + "crop: left " +
         n(crop_left_px) + " px\n" + "depth: " + n(depth_bits) + " bits\n" +
         "infrared: " + (infrared ? "yes" : "no") + "\n" + "focus: " + focus_text(*this) + "\n" +
         "exposure: " + exposure_text(exposure) + "\n" + special + "lines: " + n(format.n_lines) +
         " of " + n(format.width_px) + " px, " + channels_text(format) + ", " +
         n(format.significant_bits) + " significant bits, " + number(format.x_dpi) + " x " +
         number(format.y_dpi) + " dpi\n";
}

}  // namespace reseau
