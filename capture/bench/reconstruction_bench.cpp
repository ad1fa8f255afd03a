#include "capture/bench/reconstruction_bench.h"

#include <chrono>
#include <utility>

#include "capture/bench/cpu_time.h"
#include "capture/bench/drifting_blur.h"
#include "core/base/parallel.h"

namespace reseau {
namespace {

constexpr const char* kMegapixel = "ls5000?width_px=1000&height_px=1000&";

}  // namespace

std::vector<ReconstructionCase> reconstruction_cases() {
  return {
      {"chart, blur 0.6 px", "scene=chart&blur_px=0.6&ir_blur_px=0.6&noise=0.0005"},
      {"natural, blur 0.6 px, noise 0.6 %", "scene=natural&blur_px=0.6&ir_blur_px=0.6&noise=0.006"},
      {"chart, blur 1.0 px", "scene=chart&blur_px=1&ir_blur_px=1&noise=0.0005"},
      {"natural, blur 1.0 px", "scene=natural&blur_px=1&ir_blur_px=1&noise=0.002"},
      {"chart, blur 1.5 px", "scene=chart&blur_px=1.5&ir_blur_px=1.5&noise=0.0005"},
      {"natural, blur 1.5 px", "scene=natural&blur_px=1.5&ir_blur_px=1.5&noise=0.002"},
      // Defocus that spreads as a Gaussian of 1.34 px does, from one end of the field to the other.
      {"chart, focus drifting",
       "scene=chart&blur_px=0.4&ir_blur_px=0.4&noise=0.0005&f_number=4&"
       "focus_um=68&focus_tilt_um=68"},
      {"natural, focus drifting",
       "scene=natural&blur_px=0.4&ir_blur_px=0.4&noise=0.002&f_number=4&"
       "focus_um=68&focus_tilt_um=68"},
      // The same spread, Gaussian everywhere.
      {"chart, Gaussian blur drifting", "scene=chart&blur_px=0.4&ir_blur_px=0.4&noise=0",
       BlurDrift{0.4, 1.4, 0.0005}},
      {"natural, Gaussian blur drifting", "scene=natural&blur_px=0.4&ir_blur_px=0.4&noise=0",
       BlurDrift{0.4, 1.4, 0.002}},
      {"chart, bend 6 px and lens",
       "scene=chart&blur_px=0.6&ir_blur_px=0.6&noise=0.0005&bend_px=6&radial=0.003"},
      {"chart, stage 0.6 px", "scene=chart&blur_px=0.6&ir_blur_px=0.6&noise=0.0005&wobble_px=0.6"},
      {"chart, 67 degrees", "scene=chart&blur_px=0.6&ir_blur_px=0.6&noise=0.0005&angle=67"},
      {"chart, a Dioptichrome", "scene=chart&noise=0.0005&screen=dioptichrome-b"},
      {"chart, a Finlay", "scene=chart&noise=0.0005&screen=finlay"},
      {"chart, mirrored", "scene=chart&blur_px=0.6&ir_blur_px=0.6&noise=0.0005&mirrored=1"},
  };
}

ReconstructionFilm::ReconstructionFilm(const ReconstructionCase& test, int n_threads)
    : n_threads_(n_threads),
      spec_(sim::parse_sim_spec(kMegapixel + test.film)),
      scan_(sim::simulate_frame(spec_)) {
  if (test.drift) {
    with_threads(n_threads, [&] {
      blur_across(scan_.format, test.drift->first_px, test.drift->last_px, test.drift->noise,
                  scan_.samples);
    });
  }
  source_.emplace(scan_.format, std::move(scan_.samples));
  RegisterOptions options;
  options.n_threads = n_threads;
  const double begin = cpu_seconds();
  registration_ = register_screen(*source_, options, {}, {});
  register_cpu_s_ = cpu_seconds() - begin;
}

ReconstructionRun ReconstructionFilm::run(Quality quality, std::optional<Demosaic> demosaic,
                                          bool exact,
                                          std::optional<Deconvolution> deconvolution) const {
  ReconstructionRun run;
  run.register_cpu_s = register_cpu_s_;
  run.found = registration_.found;
  run.reason = registration_.reason;
  if (!run.found) return run;
  ReconstructOptions options;
  options.quality = quality;
  options.demosaic = demosaic;
  options.deconvolution = deconvolution;
  options.exact = exact;
  options.n_threads = n_threads_;
  options.white_level = spec_.sensor.clear_level;
  PictureInMemory picture;
  const double middle = cpu_seconds();
  const auto wall = std::chrono::steady_clock::now();
  run.report = reconstruct(*source_, registration_, options, picture, {}, {});
  run.reconstruct_wall_s =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - wall).count();
  run.reconstruct_cpu_s = cpu_seconds() - middle;
  run.score =
      score_picture(scan_.truth, 0.5 * (registration_.period_px[0] + registration_.period_px[1]),
                    picture, n_threads_);
  return run;
}

ReconstructionRun run_reconstruction_case(const ReconstructionCase& test, Quality quality,
                                          bool exact, int n_threads) {
  return ReconstructionFilm(test, n_threads).run(quality, std::nullopt, exact);
}

}  // namespace reseau
