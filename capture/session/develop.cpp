#include "capture/session/develop.h"

#include <span>

#include <fmt/format.h>

#include "capture/color/color_record.h"

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

}  // namespace

Development develop(const LineSource& source, const DevelopOptions& options,
                    const DevelopProgress& progress, const std::stop_token& stop) {
  // Before any work: colours that cannot be made must not cost a scan's time.
  const ColorModel color = make_color_model(options.color);
  Development result;
  const auto report = [&progress](DevelopPhase phase) {
    return [&progress, phase](double fraction) {
      if (progress) progress(phase, fraction);
    };
  };

  RegisterOptions register_options;
  register_options.tone = options.tone;
  register_options.n_threads = options.n_threads;
  result.registration =
      register_screen(source, register_options, report(DevelopPhase::kRegister), stop);
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

  PictureOptions picture;
  picture.exr = options.exr;
  picture.tiff = options.tiff;
  picture.png = options.png;
  picture.dpi = options.dpi;
  picture.gamut = options.view_gamut;
  picture.srgb_from_picture = srgb_from_output(options.color);
  picture.exr_options.attributes = options.attributes;
  declare_color(options.color, picture.exr_options);
  PictureWriter writer(picture);
  EndSeen sink(writer);

  ReconstructOptions reconstruct_options;
  reconstruct_options.tone = options.tone;
  reconstruct_options.output_from_process = color.output_from_process;
  reconstruct_options.white_level = options.white_level;
  reconstruct_options.n_threads = options.n_threads;
  reconstruct_options.exact = options.exact;
  reconstruct_options.quality = options.quality;
  result.report = reconstruct(source, result.registration, reconstruct_options, sink,
                              report(DevelopPhase::kReconstruct), stop);
  if (!sink.ended) {
    result.report.reset();
    result.stopped = true;
    result.why_not = "The reconstruction was stopped.";
    return result;
  }
  result.picture = writer.result();
  result.written = true;
  return result;
}

}  // namespace reseau
