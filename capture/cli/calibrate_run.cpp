#include "capture/cli/calibrate_run.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <fmt/format.h>

#include "calibration/edge/find_edges.h"
#include "capture/cli/failure.h"
#include "core/base/error.h"

namespace reseau::cli {
namespace {

MeasuredEdge measure_roi(const LinearPicture& picture, const PixelRect& roi, double window_px) {
  MeasuredEdge out;
  out.roi = roi;
  EdgeOptions options;
  options.window_px = window_px;
  options.lowest = picture.lowest();
  options.highest = picture.highest();
  options.quantum = picture.quantum();
  options.with_profile = true;
  for (std::size_t c = 0; c < picture.channels().size(); ++c) {
    const std::vector<float> samples = picture.plane(c, roi);
    ChannelEdge edge{picture.channels()[c], {}};
    edge.measured =
        measure_edge(Span2D<const float>(samples.data(), roi.width, roi.height), options);
    out.channels.push_back(std::move(edge));
  }
  return out;
}

void check_roi(const PixelRect& roi, const LinearPicture& picture) {
  const bool inside = roi.x >= 0 && roi.y >= 0 && roi.width > 0 && roi.height > 0 &&
                      roi.x < picture.width_px() && roi.y < picture.height_px() &&
                      roi.width <= picture.width_px() - roi.x &&
                      roi.height <= picture.height_px() - roi.y;
  if (inside) return;
  throw Failure(
      kExitUsage,
      fmt::format("The region {},{},{},{} does not lie within the picture of {} x {} "
                  "pixels.",
                  roi.x, roi.y, roi.width, roi.height, picture.width_px(), picture.height_px()),
      "Give --roi x,y,width,height in whole pixels.");
}

}  // namespace

bool MeasuredEdge::measured() const {
  return std::any_of(channels.begin(), channels.end(), [](const ChannelEdge& c) {
    return c.measured.status != EdgeStatus::kRefused && c.measured.mtf.all.mtf50;
  });
}

double MeasuredEdge::relative_sd() const {
  double best = std::numeric_limits<double>::infinity();
  for (const ChannelEdge& c : channels) {
    if (c.measured.status == EdgeStatus::kRefused || !c.measured.mtf.all.mtf50) continue;
    const double penalty = c.measured.status == EdgeStatus::kOk ? 1 : 10;
    best = std::min(best,
                    penalty * c.measured.mtf.all.mtf50->sd / c.measured.mtf.all.mtf50->f_cy_per_px);
  }
  return best;
}

MeasuredFile measure_file(const std::filesystem::path& path, const MeasureChoice& choice,
                          Reporter& reporter) {
  MeasuredFile out;
  out.path = path;
  const LinearPicture picture(path, choice.read);
  for (const std::string& note : picture.notes()) reporter.note(note);
  out.width_px = picture.width_px();
  out.height_px = picture.height_px();
  out.dpi = picture.dpi();
  out.context = picture.context();
  if (choice.roi) {
    check_roi(*choice.roi, picture);
    out.edges.push_back(measure_roi(picture, *choice.roi, choice.window_px));
    return out;
  }
  // Edges are sought in green, or in the only channel there is.
  const auto& names = picture.channels();
  const auto green = std::find(names.begin(), names.end(), "green");
  const auto channel = static_cast<std::size_t>(green == names.end() ? 0 : green - names.begin());
  std::vector<EdgePlace> places;
  {
    const std::vector<float> samples =
        picture.plane(channel, {0, 0, picture.width_px(), picture.height_px()});
    places =
        find_edges(Span2D<const float>(samples.data(), picture.width_px(), picture.height_px()),
                   choice.most_edges);
  }
  if (places.empty()) places.push_back({0, 0, out.width_px, out.height_px, 0});
  for (const EdgePlace& place : places) {
    out.edges.push_back(
        measure_roi(picture, {place.x, place.y, place.width, place.height}, choice.window_px));
  }
  std::stable_sort(out.edges.begin(), out.edges.end(),
                   [](const MeasuredEdge& a, const MeasuredEdge& b) {
                     return a.relative_sd() < b.relative_sd();
                   });
  // Places that turned out to hold no edge are of no interest beside one that does.
  if (out.edges.front().measured()) {
    std::erase_if(out.edges, [](const MeasuredEdge& e) { return !e.measured(); });
  } else {
    out.edges.resize(1);
  }
  return out;
}

std::string describe(const MeasuredFile& file) {
  std::string text = fmt::format("{}\n", file.path.string());
  for (const MeasuredEdge& edge : file.edges) {
    text += fmt::format("  region {},{} {} x {}\n", edge.roi.x, edge.roi.y, edge.roi.width,
                        edge.roi.height);
    for (const ChannelEdge& c : edge.channels) {
      const EdgeMeasurement& m = c.measured;
      text += fmt::format("    {:<9} ", c.channel);
      if (m.status == EdgeStatus::kRefused || !m.mtf.all.mtf50) {
        text += "no figure:";
        for (const EdgeReason reason : m.reasons) text += fmt::format(" {}", sentence(reason));
      } else {
        text += fmt::format("MTF50 {:.4f} ± {:.4f} cycles/pixel", m.mtf.all.mtf50->f_cy_per_px,
                            m.mtf.all.mtf50->sd);
        if (file.dpi > 0) {
          text += fmt::format(" ({:.1f} lp/mm)", m.mtf.all.mtf50->f_cy_per_px * file.dpi / 25.4);
        }
        if (m.mtf.window.mtf50) {
          text += fmt::format(", within ±{:.0f} px {:.4f}", m.mtf.window_px,
                              m.mtf.window.mtf50->f_cy_per_px);
        }
        if (m.mtf.all.mtf10) text += fmt::format(", MTF10 {:.3f}", m.mtf.all.mtf10->f_cy_per_px);
        text += fmt::format("; angle {:.2f}°, noise {:.2f} %", m.angle_deg, 100 * m.noise);
        for (const EdgeReason reason : m.reasons) text += fmt::format(" [{}]", code(reason));
      }
      text += "\n";
    }
  }
  if (!text.empty()) text.pop_back();
  return text;
}

std::optional<std::size_t> profile_channel(const std::string& name) {
  for (std::size_t c = 0; c < kProfileChannels; ++c) {
    if (name == kProfileChannelNames[c]) return c;
  }
  if (name == "grey") return std::size_t{1};
  return std::nullopt;
}

namespace {

struct Width {
  double weight = 0, sum = 0, squares = 0;
  int n = 0;
};

// A point of the mean curve of several edges.
struct CurvePoint {
  double weight = 0, sum = 0, squares = 0;
  int n = 0;
};
constexpr int kCurveStep = 2, kCurvePoints = 36;  // of kMtfStepCyPerPx, up to 0.7 cycles/px
using Curve = std::array<CurvePoint, kCurvePoints>;

// Inverse variances as weights. Edges that disagree by more than they claim make the mean as
// uncertain as they are apart.
struct WeightedMean {
  double value = 0, sd = 0;
};
WeightedMean mean_of(double weight, double sum, double squares, int n) {
  const double mean = sum / weight;
  double variance = 1 / weight;
  if (n > 1) variance *= std::max(1.0, std::max(0.0, squares - sum * mean) / (n - 1));
  return {mean, std::sqrt(variance)};
}

// Normal equations for where a channel lies against green, from edges of several directions; how
// the edges are spread over directions, and how white what they scatter along themselves is.
struct Offset {
  double xx = 0, xy = 0, yy = 0, x = 0, y = 0, squares = 0;
  double turn_xx = 0, turn_xy = 0, turn_yy = 0;
  double chi2 = 0, freedom = 0;
  int n = 0;
};

void add_curve(const MtfCurve& mtf, Curve& curve) {
  for (std::size_t i = 0; i < curve.size(); ++i) {
    const std::size_t at = i * kCurveStep;
    if (at >= mtf.points.size()) return;
    const MtfPoint& point = mtf.points[at];
    const double sd = std::max(point.sd, 1e-4), weight = 1 / (sd * sd);
    curve[i].weight += weight;
    curve[i].sum += weight * point.value;
    curve[i].squares += weight * point.value * point.value;
    ++curve[i].n;
  }
}

void add_edge(const MeasuredEdge& edge, std::array<Width, kProfileChannels>& widths,
              std::array<Curve, kProfileChannels>& curves,
              std::array<Offset, kProfileChannels>& offsets) {
  const EdgeMeasurement* green = nullptr;
  for (const ChannelEdge& c : edge.channels) {
    if (c.channel == "green" && c.measured.status != EdgeStatus::kRefused) green = &c.measured;
  }
  for (const ChannelEdge& c : edge.channels) {
    const EdgeMeasurement& m = c.measured;
    const auto channel = profile_channel(c.channel);
    if (!channel || m.status == EdgeStatus::kRefused || !m.mtf.all.mtf50) continue;
    // The Gaussian that falls to one half at the same frequency.
    const double f = m.mtf.all.mtf50->f_cy_per_px;
    const double sigma = std::sqrt(std::numbers::ln2 / 2) / (std::numbers::pi * f);
    const double sd = std::max(1e-6, sigma * m.mtf.all.mtf50->sd / f);
    Width& w = widths[*channel];
    w.weight += 1 / (sd * sd);
    w.sum += sigma / (sd * sd);
    w.squares += sigma * sigma / (sd * sd);
    ++w.n;
    add_curve(m.mtf.all, curves[*channel]);
    if (green == nullptr || &m == green) continue;
    const double a = green->line.normal_rad;
    const double nx = std::cos(a), ny = std::sin(a);
    const PlaceDifference apart = place_difference(green->places, m.places, a);
    if (!(apart.variance > 0)) continue;
    constexpr double kSurest_px = 1e-5;
    const double weight = 1 / std::max(kSurest_px * kSurest_px, apart.variance + apart.common);
    Offset& o = offsets[*channel];
    o.xx += weight * nx * nx;
    o.xy += weight * nx * ny;
    o.yy += weight * ny * ny;
    o.x += weight * nx * apart.value;
    o.y += weight * ny * apart.value;
    o.squares += weight * apart.value * apart.value;
    o.turn_xx += nx * nx;
    o.turn_xy += nx * ny;
    o.turn_yy += ny * ny;
    o.chi2 += apart.chi2;
    o.freedom += apart.freedom;
    ++o.n;
  }
}

}  // namespace

Profile profile_of(const std::vector<MeasuredFile>& files) {
  std::array<Width, kProfileChannels> widths{};
  std::array<Offset, kProfileChannels> offsets{};
  std::array<Curve, kProfileChannels> curves{};
  Profile out;
  int n_edges = 0;
  for (const MeasuredFile& file : files) {
    if (out.model.empty()) {
      out.make = file.context.make;
      out.model = file.context.model;
      out.serial = file.context.serial;
      out.firmware = file.context.firmware;
      out.holder = file.context.holder;
      out.focus_position = file.context.focus_position;
    }
    if (out.resolution_dpi == 0) out.resolution_dpi = file.dpi;
    for (const MeasuredEdge& edge : file.edges) {
      if (!edge.measured()) continue;
      add_edge(edge, widths, curves, offsets);
      ++n_edges;
    }
  }
  if (n_edges == 0) throw InputError("None of the files holds an edge that could be measured.");
  for (std::size_t c = 0; c < kProfileChannels; ++c) {
    const Width& w = widths[c];
    if (w.n == 0) continue;
    const WeightedMean width = mean_of(w.weight, w.sum, w.squares, w.n);
    out.psf[c] = PsfWidth{width.value, width.sd};
    for (std::size_t i = 0; i < curves[c].size(); ++i) {
      const CurvePoint& point = curves[c][i];
      if (point.n == 0) break;
      const WeightedMean mean = mean_of(point.weight, point.sum, point.squares, point.n);
      out.transfer[c].push_back(
          {kMtfStepCyPerPx * kCurveStep * static_cast<double>(i), mean.value, mean.sd});
    }
    const Offset& o = offsets[c];
    const double determinant = o.xx * o.yy - o.xy * o.xy;
    const double trace = o.turn_xx + o.turn_yy;
    const double turned = o.turn_xx * o.turn_yy - o.turn_xy * o.turn_xy;
    if (determinant > 0 && turned > 0.015 * trace * trace) {
      const Vec2 at{(o.yy * o.x - o.xy * o.y) / determinant,
                    (o.xx * o.y - o.xy * o.x) / determinant};
      out.offset_from_green_px[c] = at;
      // Edges that scatter by more than white noise, along themselves or against each other, make
      // it as unsure as that.
      const double chi2 = std::max(0.0, o.squares - at.x * o.x - at.y * o.y);
      const double along = o.freedom > 0 ? std::max(1.0, o.chi2 / o.freedom) : 1.0;
      const double scatter = o.n > 2 ? std::max(along, chi2 / (o.n - 2)) : along;
      out.offset_sd_px[c] = OffsetSd{std::sqrt(scatter * o.yy / determinant),
                                     std::sqrt(scatter * o.xx / determinant)};
    }
  }
  out.source_file = files.front().path.filename().string();
  out.tool_version = RESEAU_VERSION;
  out.method = fmt::format("slanted edge, {} region{} in {} file{}", n_edges,
                           n_edges == 1 ? "" : "s", files.size(), files.size() == 1 ? "" : "s");
  return out;
}

}  // namespace reseau::cli
