#include "capture/compare/parts.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include <fmt/format.h>

#include "capture/compare/edge_search.h"
#include "capture/compare/sides.h"
#include "core/base/error.h"

namespace reseau::compare {
namespace {

constexpr double kLeastMtf = 0.1;  // to divide by

ResolutionFigures resolution_in(const Rect& edge, const std::vector<float>& xyz_a,
                                const std::vector<float>& xyz_b) {
  ResolutionFigures figures;
  figures.edge = edge;
  const auto measure = [&edge](const std::vector<float>& xyz,
                               const std::optional<EdgeGeometry>& start) {
    const auto signal = EdgeSignal::of(xyz);
    if (signal) return measure_edge(signal->apply(xyz), edge.width_px, edge.height_px, start);
    EdgeMtf none;
    none.status = "no-contrast";
    none.reason = "The region is of one colour.";
    return none;
  };
  figures.a = measure(xyz_a, {});
  if (!figures.a.ok()) return figures;
  figures.b = measure(xyz_b, figures.a.geometry);
  if (!figures.b.ok()) return figures;
  figures.shift_px = figures.b.geometry.offset_px - figures.a.geometry.offset_px;
  for (std::size_t i = 0; i < figures.a.mtf.size(); ++i) {
    const bool usable = figures.a.mtf[i] >= kLeastMtf;
    figures.ratio.push_back(usable ? std::optional(figures.b.mtf[i] / figures.a.mtf[i])
                                   : std::nullopt);
  }
  return figures;
}

MapRows rows_of(Picture& picture, const Rect& area) {
  auto buffer = std::make_shared<std::vector<float>>();
  return [&picture, area, buffer](int first, int n, std::span<float> out) {
    const auto row = 2 * static_cast<std::size_t>(picture.header().width_px);
    const auto inner = 2 * static_cast<std::size_t>(area.width_px);
    buffer->resize(row * static_cast<std::size_t>(n));
    picture.read_map(area.y_px + first, n, *buffer);
    for (std::size_t y = 0; y < static_cast<std::size_t>(n); ++y) {
      std::copy_n(buffer->begin() + static_cast<std::ptrdiff_t>(
                                        y * row + 2 * static_cast<std::size_t>(area.x_px)),
                  inner, out.begin() + static_cast<std::ptrdiff_t>(y * inner));
    }
  };
}

// The map that stands for one side: its own, or that of a file given apart.
std::unique_ptr<Picture> open_map(const PictureHeader& picture,
                                  const std::filesystem::path& apart) {
  if (apart.empty()) {
    if (!picture.has_map) return nullptr;
    return open_picture(picture);
  }
  const PictureHeader header = read_picture_header(apart);
  if (!header.has_map) {
    throw InputError(
        fmt::format("'{}' holds no map: it needs the channels u and v.", apart.string()));
  }
  if (header.width_px != picture.width_px || header.height_px != picture.height_px) {
    throw InputError(fmt::format("The map '{}' has {} pixels and its picture '{}' has {}.",
                                 apart.string(), size_text(header), picture.path.string(),
                                 size_text(picture)));
  }
  return open_picture(header);
}

}  // namespace

void compare_resolution(const Side& a, const Side& b, const ColorPass& pass,
                        const CompareOptions& options, Comparison& result) {
  const auto part = [](const Side& side) {
    return [&side](const Rect& r) {
      return read_xyz(*side.picture,
                      {side.area.x_px + r.x_px, side.area.y_px + r.y_px, r.width_px, r.height_px});
    };
  };
  Rect edge;
  if (options.edge) {
    edge = *options.edge;
    edge.x_px -= a.area.x_px;
    edge.y_px -= a.area.y_px;
    if (edge.x_px < 0 || edge.y_px < 0 || edge.width_px < 1 || edge.height_px < 1 ||
        edge.width_px > a.area.width_px - edge.x_px ||
        edge.height_px > a.area.height_px - edge.y_px) {
      throw InputError("The region of the edge (--roi) does not lie inside the compared area.");
    }
  } else {
    const auto found = find_edge(pass.blocks, pass.blocks_across, part(a));
    if (!found) {
      result.no_resolution =
          "No slanted edge between two flat areas was found in A; --roi says where one is.";
      return;
    }
    edge = found->area;
  }
  ResolutionFigures figures = resolution_in(edge, part(a)(edge), part(b)(edge));
  if (!figures.a.ok() || !figures.b.ok()) {
    result.no_resolution =
        figures.a.ok() ? "In B: " + figures.b.reason : "In A: " + figures.a.reason;
    return;
  }
  figures.edge.x_px += a.area.x_px;
  figures.edge.y_px += a.area.y_px;
  result.resolution = std::move(figures);
}

void compare_registration(const CompareOptions& options, Comparison& result) {
  const auto a = open_map(result.a, options.map_a);
  const auto b = open_map(result.b, options.map_b);
  if (!a || !b) {
    result.no_registration = fmt::format(
        "{} no map of the réseau (channels u and v); 'reseau register --map' writes one.",
        a ? "B has" : (b ? "A has" : "The pictures have"));
    return;
  }
  Rect area_b = result.area;
  area_b.x_px += options.offset_x_px;
  area_b.y_px += options.offset_y_px;
  const MapError error = compare_maps(result.area.width_px, result.area.height_px, 0,
                                      rows_of(*a, result.area), rows_of(*b, area_b));
  if (error.n == 0) {
    result.no_registration = "The maps have no pixel that is finite and regular in both.";
    return;
  }
  result.registration = error;
}

}  // namespace reseau::compare
