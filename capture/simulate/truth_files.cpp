#include "capture/simulate/truth_files.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <string>
#include <vector>

#include "capture/image/exr_file.h"
#include "core/base/check.h"
#include "core/base/parallel.h"
#include "core/color/element_color.h"

namespace reseau::simulate {
namespace {

// Process RGB has no colour of its own; readers that want one get that of the default primaries.
ExrOptions truth_options() {
  ExrOptions options;
  const std::string primaries = primary_set_names().front();
  options.chromaticities =
      make_color_model(primaries, Balance::kNeutral, OutputSpace::kProcess).chromaticities;
  options.attributes = {{"reseau.truth", "reseau-truth/1"}, {"reseau.space", "process"}};
  return options;
}

struct Place {
  double x = 0, y = 0;
};

// Where the film has these screen coordinates: the mean lattice first, then corrected by what is
// missing. Displacements of a few pixels converge in as many steps.
Place scan_from_screen(const sim::FilmTruth& truth, double u, double v) {
  const sim::ScreenGradient g = truth.mean_gradient();
  const double determinant = g.u_x * g.v_y - g.u_y * g.v_x;
  CHECK(determinant != 0);
  Place at;
  constexpr int kSteps = 12;
  for (int i = 0; i < kSteps; ++i) {
    const sim::ScreenPoint s = truth.screen_from_scan(at.x, at.y);
    const double du = u - s.u, dv = v - s.v;
    at.x += (g.v_y * du - g.u_y * dv) / determinant;
    at.y += (g.u_x * dv - g.v_x * du) / determinant;
    if (std::abs(du) + std::abs(dv) < 1e-9) break;
  }
  return at;
}

}  // namespace

TruthNames truth_names(const std::filesystem::path& picture) {
  const auto with = [&picture](const char* ending) {
    std::filesystem::path path = picture;
    return path.replace_extension(ending);
  };
  return {picture, with(".json"), with(".elements.exr"), with(".psf.exr")};
}

namespace {

// The layers of one line, side by side as pixels.
class TruthLine {
 public:
  explicit TruthLine(const KnownScan& scan)
      : truth_(scan.truth), width_(static_cast<std::size_t>(scan.format.width_px)) {
    channels_ = {"R", "G", "B", "IR"};
    if (truth_.has_screen()) channels_.insert(channels_.end(), {"u", "v"});
    if (truth_.scene_differs()) {
      channels_.insert(channels_.end(), {"scene.R", "scene.G", "scene.B"});
    }
    if (truth_.has_harm()) channels_.emplace_back("harm");
  }
  [[nodiscard]] const std::vector<std::string>& channels() const { return channels_; }
  [[nodiscard]] std::size_t size() const { return width_ * channels_.size(); }

  void fill(int y, std::span<float> out) const {
    std::vector<std::vector<float>> layers(channels_.size(), std::vector<float>(width_));
    truth_.process_row(y, {layers[0], layers[1], layers[2]});
    truth_.silver_row(y, layers[3]);
    std::size_t next = 4;
    if (truth_.has_screen()) {
      std::vector<sim::ScreenPoint> points(width_);
      truth_.screen_row(y, points);
      for (std::size_t x = 0; x < width_; ++x) {
        layers[next][x] = static_cast<float>(points[x].u);
        layers[next + 1][x] = static_cast<float>(points[x].v);
      }
      next += 2;
    }
    if (truth_.scene_differs()) {
      truth_.scene_row(y, {layers[next], layers[next + 1], layers[next + 2]});
      next += 3;
    }
    if (truth_.has_harm()) truth_.harm_row(y, layers[next]);
    for (std::size_t c = 0; c < layers.size(); ++c) {
      for (std::size_t x = 0; x < width_; ++x) out[x * layers.size() + c] = layers[c][x];
    }
  }

 private:
  const sim::FilmTruth& truth_;
  std::size_t width_;
  std::vector<std::string> channels_;
};

}  // namespace

bool write_truth_picture(const KnownScan& scan, const std::filesystem::path& path,
                         const std::function<bool(double)>& keep_going) {
  constexpr int kLinesAtOnce = 32;
  const TruthLine line(scan);
  const int height = scan.format.n_lines;
  FloatImageWriter writer(path, scan.format.width_px, height, line.channels(), truth_options());
  std::vector<float> rows(line.size() * kLinesAtOnce);
  for (int first = 0; first < height; first += kLinesAtOnce) {
    const int n = std::min(kLinesAtOnce, height - first);
    parallel_for(n, [&](int k) {
      line.fill(first + k,
                std::span(rows).subspan(line.size() * static_cast<std::size_t>(k), line.size()));
    });
    writer.rows(first, n, std::span(rows).first(line.size() * static_cast<std::size_t>(n)));
    if (!keep_going(double(first + n) / height)) return false;
  }
  writer.finish();
  return true;
}

FirstPeriod write_element_samples(const KnownScan& scan, const std::filesystem::path& path) {
  const sim::FilmTruth& truth = scan.truth;
  const double right = scan.format.width_px - 1, bottom = scan.format.n_lines - 1;
  double low_u = HUGE_VAL, low_v = HUGE_VAL, high_u = -HUGE_VAL, high_v = -HUGE_VAL;
  // Along the edges: a bent lattice need not be extreme in the corners.
  constexpr int kSteps = 64;
  for (int i = 0; i <= kSteps; ++i) {
    const double x = right * i / kSteps, y = bottom * i / kSteps;
    const std::array<Place, 4> edge{{{x, 0}, {x, bottom}, {0, y}, {right, y}}};
    for (const Place& p : edge) {
      const sim::ScreenPoint s = truth.screen_from_scan(p.x, p.y);
      low_u = std::min(low_u, s.u);
      high_u = std::max(high_u, s.u);
      low_v = std::min(low_v, s.v);
      high_v = std::max(high_v, s.v);
    }
  }
  const FirstPeriod first{static_cast<int>(std::floor(low_u)) - 1,
                          static_cast<int>(std::floor(low_v)) - 1};
  const int columns = static_cast<int>(std::ceil(high_u)) + 2 - first.u;
  const int rows = static_cast<int>(std::ceil(high_v)) + 2 - first.v;
  FloatImageWriter writer(path, columns, rows, {"R", "G", "B", "x", "y"}, truth_options());
  const std::array<sim::ScreenPoint, 3> middles = truth.element_middles();
  std::vector<float> row;
  for (int j = 0; j < rows; ++j) {
    row.clear();
    for (int i = 0; i < columns; ++i) {
      Place green;
      for (std::size_t k = 0; k < 3; ++k) {
        const Place at =
            scan_from_screen(truth, first.u + i + middles[k].u, first.v + j + middles[k].v);
        const bool inside =
            at.x >= -0.5 && at.y >= -0.5 && at.x <= right + 0.5 && at.y <= bottom + 0.5;
        row.push_back(inside ? static_cast<float>(truth.process_rgb(at.x, at.y)[k]) : NAN);
        if (k == 1) green = inside ? at : Place{NAN, NAN};
      }
      row.push_back(static_cast<float>(green.x));
      row.push_back(static_cast<float>(green.y));
    }
    writer.rows(j, 1, row);
  }
  writer.finish();
  return first;
}

void write_psf_grid(const sim::SimSpec& spec, const std::filesystem::path& path) {
  const sim::FrameSpec& frame = spec.film.frame;
  const sim::ScanWindow window{
      .x_px = 0, .y_px = 0, .width_px = frame.width_px, .n_lines = frame.height_px, .pitch = 1};
  constexpr int kSide = 2 * kPsfRadiusPx * kPsfSamplesPerPx + 1;
  FloatImageWriter writer(path, kPsfPlaces * kSide, kPsfPlaces * kSide, {"R", "G", "B", "IR"});
  std::vector<float> rows;
  for (int j = 0; j < kPsfPlaces; ++j) {
    rows.assign(std::size_t{kSide} * kPsfPlaces * kSide * 4, 0.0F);
    for (int i = 0; i < kPsfPlaces; ++i) {
      const double x = (i + 0.5) * frame.width_px / kPsfPlaces - 0.5;
      const double y = (j + 0.5) * frame.height_px / kPsfPlaces - 0.5;
      for (int channel = 0; channel < 4; ++channel) {
        const sim::PsfGrid psf =
            sim::psf_at(spec, window, channel, x, y, kPsfSamplesPerPx, kPsfRadiusPx);
        CHECK(psf.side == kSide);
        for (int q = 0; q < kSide; ++q) {
          for (int p = 0; p < kSide; ++p) {
            const auto to = (static_cast<std::size_t>(q) * kPsfPlaces * kSide +
                             static_cast<std::size_t>(i * kSide + p)) *
                                4 +
                            static_cast<std::size_t>(channel);
            rows[to] = static_cast<float>(
                psf.values[static_cast<std::size_t>(q) * kSide + static_cast<std::size_t>(p)]);
          }
        }
      }
    }
    writer.rows(j * kSide, kSide, rows);
  }
  writer.finish();
}

}  // namespace reseau::simulate
