// A film scanner. One class per family implements it; capture knows nothing else of devices.
//
//   closed --open_scanner()--> idle --start()--> scanning --read()…--> idle
//                               ^                    |
//                               +------ stop() ------+
//
// Thread-bound: one thread calls it at a time.
#pragma once

#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "core/base/clock.h"
#include "core/line/capture_context.h"
#include "core/line/line_block.h"
#include "drivers/scan_plan.h"

namespace reseau {

// Where one frame lies on the film or in the holder.
struct FramePlace {
  double top_mm = 0, height_mm = 0;  // from where an overview begins
  bool found = false;                // on the film itself; otherwise the adapter's raster
};

struct Capabilities {
  std::string make, model, firmware, serial, adapter, link;
  bool film_present = false;
  int optical_dpi = 0;
  std::vector<int> resolutions_dpi;         // descending
  int max_width_px = 0, max_height_px = 0;  // optical px
  std::vector<int> depths_bits;             // ascending
  bool infrared = false;
  int focus_min = 0, focus_max = 0;
  int n_frames = 1;
  double exposure_min_us = 0, exposure_max_us = 0;
  int max_samples = 1;             // readings of a line
  int sensor_lines = 1;            // that one pass can use
  std::vector<FramePlace> frames;  // n_frames of them, or none where the unit does not say
  bool can_overview = false, can_eject = false, can_load = false, can_move_frames = false;
};

enum class ScanPhase { kWarmUp, kLoad, kFocus, kMeter, kScan };

// Told what start() is doing; called on the thread that called start().
class ScanObserver {
 public:
  virtual ~ScanObserver() = default;
  // A phase began. `detail` is a short phrase for people, e.g. "exposure pass 2".
  virtual void phase(ScanPhase phase, const std::string& detail) = 0;
  // A sentence worth keeping in the log and the receipt, e.g. "resolution rounded to 1333 dpi".
  virtual void note(const std::string& sentence) = 0;
};

enum class ReadStatus { kLines, kNotReady, kEndOfScan };

class Scanner {
 public:
  virtual ~Scanner() = default;
  [[nodiscard]] virtual const Capabilities& capabilities() const = 0;
  // Pure: no I/O. Throws InputError when nothing near the request is possible.
  [[nodiscard]] virtual Negotiated negotiate(const ScanRequest& request) const = 0;
  // Focuses, meters, positions and starts the scan. Blocks; a stop request ends it at the next safe
  // point with the unit idle, and start() then returns false. Throws DeviceError.
  [[nodiscard]] virtual bool start(const ScanPlan& plan, ScanObserver& observer,
                                   const std::stop_token& stop) = 0;
  // What start() settled: focus position, exposures. Valid after start() returned true.
  [[nodiscard]] virtual const CaptureContext& context() const = 0;
  // Fills block with the next lines (at least one, a READ's worth at most). kNotReady: nothing came
  // before the deadline, ask again. Throws DeviceError; lines delivered before stay valid.
  [[nodiscard]] virtual ReadStatus read(LineBlock& block, Duration timeout) = 0;
  // A sentence for a person who is about to wait because stop() now takes long; empty when it does
  // not.
  [[nodiscard]] virtual std::string stop_notice() const { return {}; }
  // Ends a scan wherever it stands and leaves the unit usable. Idempotent; never throws.
  virtual void stop() noexcept = 0;
  // Film out, film in. Block until it is done. Throw DeviceError, or InputError where the adapter
  // has no such motion. Never while a scan is open.
  virtual void eject(ScanObserver& observer);
  virtual void load(ScanObserver& observer);
};

}  // namespace reseau
