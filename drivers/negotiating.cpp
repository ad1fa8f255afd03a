#include "drivers/negotiating.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/base/error.h"

namespace reseau {

void Negotiating::adjust(const std::string& field, const std::string& asked,
                         const std::string& granted, const std::string& why) {
  result_.adjusted.push_back({field, asked, granted, why});
}

void Negotiating::note_end(const char* field, double asked_mm, int granted_px) {
  adjust(field, text_of(asked_mm, "mm"), text_of(granted_px * kMmPerInch / max_dpi_, "mm"),
         "the frame ends there");
}

std::string Negotiating::text_of(double value, const char* unit) {
  char text[48];
  std::snprintf(text, sizeof text, "%.6g %s", value, unit);
  return text;
}

int Negotiating::px_from_mm(double mm, int dpi, const char* field) {
  if (!std::isfinite(mm) || std::abs(mm) > 1e5) {
    throw InputError(std::string("The ") + field + " of the area is not a usable length.");
  }
  return static_cast<int>(std::lround(mm * dpi / kMmPerInch));
}

void Negotiating::settle_depth(const std::vector<int>& offered) {
  if (offered.empty() || offered.back() <= 0) {
    throw InputError("The scanner does not offer any depth to scan with.");
  }
  const int asked = request_.depth_bits.value_or(offered.back());
  const auto enough = std::lower_bound(offered.begin(), offered.end(), asked);
  plan_.depth_bits = enough == offered.end() ? offered.back() : *enough;
  if (plan_.depth_bits != asked) {
    adjust("depth", std::to_string(asked) + " bits", std::to_string(plan_.depth_bits) + " bits",
           plan_.depth_bits < asked
               ? "the scanner converts no deeper; samples are scaled to 16 bits"
               : "the scanner has no shallower depth that is enough");
  }
  plan_.format.significant_bits = plan_.depth_bits;
}

void Negotiating::settle_channels(bool has_infrared) {
  if (request_.infrared && !has_infrared) {
    throw InputError("This scanner has no infrared channel. Ask for a scan without infrared.");
  }
  plan_.infrared = request_.infrared;
  plan_.format.channels = {Channel::kRed, Channel::kGreen, Channel::kBlue};
  if (plan_.infrared) plan_.format.channels.push_back(Channel::kInfrared);
}

void Negotiating::settle_frame(int n_frames, const char* why_one) {
  if (request_.frame < 1 || request_.frame > n_frames) {
    throw InputError("Frame " + std::to_string(request_.frame) + " was asked for, but " +
                     (n_frames == 1
                          ? std::string(why_one)
                          : "the frames here are 1 to " + std::to_string(n_frames) + "."));
  }
  plan_.frame = request_.frame;
}

Negotiating::Span Negotiating::fit(const std::optional<double>& first_mm,
                                   const std::optional<double>& length_mm, int limit_px, Rest rest,
                                   const char* first_name, const char* length_name) {
  const int asked_first = px_from_mm(first_mm.value_or(0), max_dpi_, first_name);
  if (asked_first >= limit_px) {
    throw InputError(std::string("The ") + first_name +
                     " of the area lies beyond the frame, which measures " +
                     text_of(limit_px * kMmPerInch / max_dpi_, "mm") +
                     " in that direction. Give a smaller value.");
  }
  const int first = std::clamp(asked_first, 0, limit_px - plan_.pitch);
  if (first != asked_first) note_end(first_name, *first_mm, first);
  int room = limit_px - first;
  if (rest == Rest::kDropped) room -= room % plan_.pitch;
  if (!length_mm) return {first, room};
  const int asked_length = px_from_mm(*length_mm, max_dpi_, length_name);
  if (asked_length <= 0) {
    throw InputError(std::string("The ") + length_name + " of the area must be above 0 mm.");
  }
  const int whole = (asked_length + plan_.pitch - 1) / plan_.pitch * plan_.pitch;
  const int length = std::min(whole, room);
  if (length < asked_length) note_end(length_name, *length_mm, length);
  return {first, length};
}

void Negotiating::settle_exposure(double low_us, double high_us) {
  plan_.exposure = request_.exposure;
  if (!(plan_.exposure.factor > 0) || !std::isfinite(plan_.exposure.factor)) {
    throw InputError("The exposure factor must be a number above 0.");
  }
  if (plan_.exposure.mode != ExposureRequest::Mode::kFixed) return;
  static constexpr const char* kNames[] = {"red exposure", "green exposure", "blue exposure",
                                           "infrared exposure"};
  for (std::size_t i = 0; i < plan_.exposure.exposure_us.size(); ++i) {
    std::optional<double>& us = plan_.exposure.exposure_us[i];
    if (!us) continue;
    if (!std::isfinite(*us) || *us <= 0) {
      throw InputError(std::string("The ") + kNames[i] + " must be a time above 0 us.");
    }
    const double asked = *us;
    us = std::clamp(asked, low_us, high_us);
    if (*us == asked) continue;
    adjust(kNames[i], text_of(asked, "us"), text_of(*us, "us"),
           "the scanner's exposure range ends there");
  }
}

}  // namespace reseau
