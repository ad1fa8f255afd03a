#include "capture/session/develop.h"

#include <span>
#include <utility>

#include <fmt/format.h>

#include "capture/color/color_record.h"
#include "capture/session/queued_rows.h"
#include "core/base/error.h"
#include "core/color/white_balance.h"
#include "core/line/corrected_lines.h"
#include "core/line/rgb_lines.h"
#include "core/reconstruct/live_picture.h"

namespace reseau {

namespace {

// A stop request may come when the picture is already whole; only the sink knows.
class EndSeen final : public RgbRowSink {
 public:
  explicit EndSeen(RgbRowSink& to) : to_(to) {}
  void begin(int width_px, int height_px) override { to_.begin(width_px, height_px); }
  void rows(int first_row, int n_rows, std::span<const float> rgb) override {
    to_.rows(first_row, n_rows, rgb);
  }
  void end() override {
    to_.end();
    ended = true;
  }
  bool ended = false;

 private:
  RgbRowSink& to_;
};

ReconstructOptions reconstruct_options_of(const DevelopOptions& options) {
  ReconstructOptions out;
  out.tone = options.tone;
  out.white_level = options.white_level;
  out.black_level = options.black_level;
  out.blur_px = options.blur_px;
  out.unit = options.profile.unit;
  out.silver_from_rgb = options.silver.weights;
  out.n_threads = options.n_threads;
  out.exact = options.exact;
  out.quality = options.quality;
  out.demosaic = options.demosaic;
  out.deconvolution = options.deconvolution;
  return out;
}

// The factors of a recipe, times those that make the area neutral. Nothing on a stop request.
std::optional<Vector3> white_balance_of(const LineSource& source, const Registration& registration,
                                        const DevelopOptions& options,
                                        const std::stop_token& stop) {
  Vector3 factors = options.color.white_balance;
  if (!options.neutral) return factors;
  AreaMean mean(*options.neutral);
  EndSeen sink(mean);
  static_cast<void>(
      reconstruct(source, registration, reconstruct_options_of(options), sink, {}, stop));
  if (!sink.ended) return std::nullopt;
  const Vector3 neutral =
      neutral_white_balance(mean.mean(), make_color_model(options.color).xyz_from_process);
  for (std::size_t i = 0; i < 3; ++i) factors[i] *= neutral[i];
  return factors;
}

// How a scan is seen: levels taken from it, infrared left out, as the options say.
class SeenScan {
 public:
  SeenScan(const LineSource& scanned, const DevelopOptions& options)
      : corrected_(scanned, options.profile.levels),
        // Levels are linear in light in a master; in a file that is encoded nobody knows them.
        whole_(options.tone.is_linear() && !options.profile.levels.empty()
                   ? static_cast<const LineSource&>(corrected_)
                   : scanned),
        rgb_(whole_),
        infrared_(whole_.format().plane_of(Channel::kInfrared) >= 0),
        source_(infrared_ && options.silver.ignore_infrared ? static_cast<const LineSource&>(rgb_)
                                                            : whole_) {}
  [[nodiscard]] const LineSource& source() const { return source_; }
  // With its infrared, though that is not used.
  [[nodiscard]] const LineSource& whole() const { return whole_; }
  [[nodiscard]] bool infrared() const { return infrared_; }

 private:
  CorrectedLines corrected_;
  const LineSource& whole_;
  RgbLines rgb_;
  bool infrared_;
  const LineSource& source_;
};

// The provisional picture, where one is wanted, goes on with `live` until all lines are registered.
Development finish_picture(const SeenScan& scan, const DevelopOptions& options, LivePicture* live,
                           const DevelopProgress& progress, const std::stop_token& stop) {
  const LineSource& source = scan.source();
  Development result;
  const auto report = [&progress](DevelopPhase phase) {
    return [&progress, phase](double fraction) {
      if (progress) progress(phase, fraction);
    };
  };

  RegisterOptions register_options;
  register_options.tone = options.tone;
  register_options.n_threads = options.n_threads;
  if (live != nullptr) {
    register_options.on_snapshot = [live](auto snapshot) { live->take(std::move(snapshot)); };
  }
  result.registration =
      register_screen(source, register_options, report(DevelopPhase::kRegister), stop);
  if (live != nullptr) live->stop();
  if (stop.stop_requested()) {
    result.stopped = true;
    result.why_not = "The reconstruction was stopped.";
    return result;
  }
  const int n_lines = source.format().n_lines;
  const int committed = source.committed();
  if (committed < n_lines) {
    result.why_not = fmt::format("Only {} of {} lines are there.", committed, n_lines);
    return result;
  }
  if (!result.registration.found) {
    result.why_not =
        result.registration.reason.empty() ? "No réseau was found." : result.registration.reason;
    return result;
  }
  try {
    (void)printed_screen(result.registration.screen);
  } catch (const InputError& error) {
    result.why_not = error.what();
    return result;
  }

  const auto stopped = [&result] {
    result.report.reset();
    result.stopped = true;
    result.why_not = "The reconstruction was stopped.";
    return result;
  };
  ColorRecipe recipe = options.color;
  const auto factors = white_balance_of(source, result.registration, options, stop);
  if (!factors) return stopped();
  recipe.white_balance = result.white_balance = *factors;

  PictureOptions picture;
  picture.exr = options.exr;
  picture.tiff = options.tiff;
  picture.png = options.png;
  picture.dpi = options.dpi * options.frame.scale;
  picture.gamut = options.view_gamut;
  picture.srgb_from_picture = srgb_from_output(recipe);
  picture.exr_options.attributes = options.attributes;
  declare_color(recipe, picture.exr_options);
  PictureWriter writer(picture);
  EndSeen ending(writer);
  QueuedRows sink(ending);

  ReconstructOptions reconstruct_options = reconstruct_options_of(options);
  reconstruct_options.frame = options.frame;
  reconstruct_options.output_from_process = make_color_model(recipe).output_from_process;
  result.report = reconstruct(source, result.registration, reconstruct_options, sink,
                              report(DevelopPhase::kReconstruct), stop);
  if (!ending.ended) return stopped();
  result.rendered_at = sink.made_at();
  result.picture = writer.result();
  // For other scans: this picture does not wait for it.
  if (scan.infrared()) result.learned = learn_silver_from_rgb(scan.whole(), options.tone, stop);
  result.written = true;
  return result;
}

}  // namespace

Development develop(const LineSource& scanned, const DevelopOptions& options,
                    const DevelopProgress& progress, const std::stop_token& stop) {
  // Before any work: colours that cannot be made must not cost a scan's time.
  const ColorModel color = make_color_model(options.color);
  const SeenScan scan(scanned, options);
  if (options.live == nullptr) return finish_picture(scan, options, nullptr, progress, stop);
  ReconstructOptions draft = reconstruct_options_of(options);
  draft.output_from_process = color.output_from_process;
  LivePicture live(scan.source(), draft, *options.live);
  Development result = finish_picture(scan, options, &live, progress, stop);
  result.live = live.report();
  return result;
}

}  // namespace reseau
