// The steps from a request to a plan that are the same for every family of scanners. A family
// derives from it, adds its own steps and says in which order they come. Pure; nothing here knows a
// device.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "drivers/scan_plan.h"

namespace reseau {

class Negotiating {
 protected:
  // A part of one side of the frame [optical px].
  struct Span {
    int first = 0, length = 0;
  };
  // Whether a length has to be a whole number of delivered pixels even at the end of the frame.
  enum class Rest { kKept, kDropped };

  explicit Negotiating(const ScanRequest& request) : request_(request) {}

  void adjust(const std::string& field, const std::string& asked, const std::string& granted,
              const std::string& why);
  // For a length that was granted otherwise because the frame ends.
  void note_end(const char* field, double asked_mm, int granted_px);
  [[nodiscard]] static std::string text_of(double value, const char* unit);
  // Any finite length a person may type; the result is far inside int. Throws InputError.
  [[nodiscard]] static int px_from_mm(double mm, int dpi, const char* field);

  // The least of the offered depths that is enough, else the deepest. `offered` is sorted.
  void settle_depth(const std::vector<int>& offered);
  void settle_channels(bool has_infrared);
  // Throws InputError; `why_one` completes "Frame 2 was asked for, but ".
  void settle_frame(int n_frames, const char* why_one);
  // Fits one dimension into [0, limit_px) and tells when less than asked is granted. Lengths are
  // whole delivered pixels, rounded up so that all that was asked is covered where there is room.
  [[nodiscard]] Span fit(const std::optional<double>& first_mm,
                         const std::optional<double>& length_mm, int limit_px, Rest rest,
                         const char* first_name, const char* length_name);
  void settle_exposure(double low_us, double high_us);

  const ScanRequest& request_;
  Negotiated result_;
  ScanPlan& plan_ = result_.plan;
  int max_dpi_ = 0;  // what optical pixels are of; set by the family before anything is fitted
};

}  // namespace reseau
