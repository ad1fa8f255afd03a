#include <cmath>

#include <fmt/format.h>

#include "capture/compare/compare_json.h"

namespace reseau::compare {
namespace {

std::string figures_text(const DifferenceFigures& f) {
  return fmt::format("mean {:.4f}  median {:.4f}  95 % {:.4f}  max {:.4f}", f.mean, f.median, f.p95,
                     f.max);
}

void describe_color(const Comparison& c, const CompareOptions& options,
                    std::vector<std::string>& lines) {
  if (!c.color) {
    lines.push_back("ΔE2000        none: " + c.no_color);
    return;
  }
  lines.push_back("ΔE2000                     " + figures_text(c.color->all));
  lines.push_back("ΔE2000 without worst 1 %   " + figures_text(c.color->without_worst_percent));
  if (options.worst_fraction != 0.01) {
    lines.push_back(fmt::format("ΔE2000 without worst {:g} %   {}", 100 * options.worst_fraction,
                                figures_text(c.color->trimmed)));
  }
  if (c.color->bias.n_blocks > 0) {
    const BiasFigures& bias = c.color->bias;
    lines.push_back(
        fmt::format("B - A, mean   L* {:+.3f} ± {:.3f}  a* {:+.3f} ± {:.3f}  b* {:+.3f} "
                    "± {:.3f}",
                    bias.lab[0], bias.sd[0], bias.lab[1], bias.sd[1], bias.lab[2], bias.sd[2]));
  }
  lines.push_back(fmt::format(
      "Colours       {} CIELAB against {}{}.", c.pairing,
      options.white == LabWhite::kOwn ? "each picture's own white" : word_of(options.white),
      options.clamp_xyz ? ", XYZ clamped to 0..1" : ""));
  lines.push_back(fmt::format("              A: {} ({}), B: {} ({})", c.a.format, c.encoding_a,
                              c.b.format, c.encoding_b));
  if (options.fit == Fit::kGain) {
    lines.push_back(fmt::format("Fit           B was multiplied by {:.5f}", c.color->gain));
  } else if (options.fit == Fit::kWhite) {
    lines.push_back("Fit           the mean colour of B was brought onto that of A");
  }
}

void describe_registration(const Comparison& c, std::vector<std::string>& lines) {
  if (!c.registration) {
    lines.push_back("Registration  none: " + c.no_registration);
    return;
  }
  const MapError& r = *c.registration;
  lines.push_back(
      fmt::format("Registration  rms {:.4f} px  95 % {:.4f}  max {:.4f}  mean ({:+.4f}, {:+.4f})",
                  r.rms_px, r.p95_px, r.max_px, r.mean_x_px, r.mean_y_px));
  const MapEquivalence& e = r.equivalence;
  lines.push_back(fmt::format("              after {}u {}, v {}; {:+g} and {:+g} periods",
                              e.swapped ? "exchanging the axes, " : "",
                              e.sign_u < 0 ? "reversed" : "as it is",
                              e.sign_v < 0 ? "reversed" : "as it is", e.periods_u, e.periods_v));
}

void describe_resolution(const Comparison& c, std::vector<std::string>& lines) {
  if (!c.resolution) {
    lines.push_back("Resolution    none: " + c.no_resolution);
    return;
  }
  const ResolutionFigures& r = *c.resolution;
  const auto mtf50 = [](const EdgeMtf& edge) {
    return edge.mtf50_cy_per_px ? fmt::format("{:.4f}", *edge.mtf50_cy_per_px)
                                : std::string("above 1");
  };
  lines.push_back(fmt::format(
      "Resolution    MTF50 A {}  B {} cycles/px; edge at {:.1f}° in {},{} {} × {} px", mtf50(r.a),
      mtf50(r.b), r.a.angle_deg, r.edge.x_px, r.edge.y_px, r.edge.width_px, r.edge.height_px));
  std::string ratios;
  for (const std::size_t percent : {5U, 10U, 20U, 30U}) {
    if (percent < r.ratio.size() && r.ratio[percent]) {
      ratios += fmt::format("  {:.3f} at {:.2f}", *r.ratio[percent],
                            kMtfStep * static_cast<double>(percent));
    }
  }
  if (!ratios.empty()) lines.push_back("              MTF of B over A" + ratios);
}

void describe_rest(const Comparison& c, std::vector<std::string>& lines) {
  if (c.noise) {
    const NoiseFigures& n = *c.noise;
    lines.push_back(fmt::format(
        "Noise         A L* {:.3f} a* {:.3f} b* {:.3f}  B L* {:.3f} a* {:.3f} b* {:.3f}{}", n.a[0],
        n.a[1], n.a[2], n.b[0], n.b[1], n.b[2],
        n.ratio[0] ? fmt::format("  ratio of L* {:.3f}", *n.ratio[0]) : std::string()));
  } else {
    lines.push_back("Noise         none: " + c.no_noise);
  }
  if (c.shift) {
    lines.push_back(
        fmt::format("Shift         ({:+.4f} ± {:.4f}, {:+.4f} ± {:.4f}) px, B against A",
                    c.shift->x_px, c.shift->sd_x_px, c.shift->y_px, c.shift->sd_y_px));
  }
}

}  // namespace

std::vector<std::string> describe_comparison(const Comparison& c, const CompareOptions& options) {
  std::vector<std::string> lines;
  describe_color(c, options, lines);
  describe_registration(c, lines);
  if (c.color) {
    describe_resolution(c, lines);
    describe_rest(c, lines);
  }
  if (c.identical) lines.emplace_back("The pictures are identical.");
  return lines;
}

}  // namespace reseau::compare
