#include "capture/cli/calibrate_random.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <utility>

#include <fmt/format.h>

#include "capture/cli/failure.h"
#include "capture/image/linear_picture.h"
#include "capture/session/json_number.h"
#include "core/base/error.h"

namespace reseau::cli {
namespace {

using Json = nlohmann::ordered_json;

Json pair_of(double a, double b) { return {number_or_null(a), number_or_null(b)}; }

Json random_curve(const RandomPsf& psf, double x, double y) {
  Json out = Json::array();
  for (int i = 0; i <= 50; ++i) {
    const double f = 0.02 * i;
    const RandomPsf::Point point = psf.mtf_of_all(f * x, f * y);
    out.push_back(
        {{"f", f}, {"value", number_or_null(point.value)}, {"sd", number_or_null(point.sd)}});
  }
  return out;
}

Json random_channel_json(const RandomPsf& psf) {
  Json out = Json::object();
  out["status"] = code(psf.status);
  out["reasons"] = Json::array();
  put_number(out, "left_out", psf.left_out);
  if (!psf.ok()) {
    out["reasons"].push_back({{"code", code(psf.status)}, {"sentence", sentence(psf.status)}});
    return out;
  }
  out["side"] = psf.side;
  put_number(out, "step_px", psf.step_px);
  Json values = Json::array(), deviations = Json::array();
  for (const double v : psf.psf) values.push_back(number_or_null(v));
  for (const double v : psf.sd) deviations.push_back(number_or_null(v));
  out["psf_per_px2"] = values;
  out["psf_sd"] = deviations;
  put_number(out, "relative_sd", psf.relative_sd);
  put_number(out, "weakest_share", psf.weakest_share);
  out["used_px"] = psf.side_used_px;
  out["middle_px"] = pair_of(psf.middle_px.x, psf.middle_px.y);
  out["target_px"] = pair_of(psf.origin_px.x, psf.origin_px.y);
  out["target_sd_px"] = pair_of(psf.origin_sd_px.x, psf.origin_sd_px.y);
  out["target_from_scan"] =
      Json::array({pair_of(psf.scale.a, psf.scale.b), pair_of(psf.scale.c, psf.scale.d)});
  put_number(out, "turn_deg", psf.turn_deg);
  out["mirrored"] = psf.mirrored;
  put_number(out, "bend_px", psf.bend_px);
  put_number(out, "noise", psf.noise);
  const std::pair<const char*, RandomPsf::Point> halves[] = {
      {"mtf50_x", psf.mtf50(0)}, {"mtf50_y", psf.mtf50(std::acos(0.0))}};
  for (const auto& [name, at] : halves) {
    if (at.value > 0) {
      put_number(out, name, at.value);
      put_number(out, std::string(name) + "_sd", at.sd);
    } else {
      put_missing(out, name, "not reached below 1 cycle per pixel");
    }
  }
  put_number(out, "light_outside", psf.outside);
  put_number(out, "light_outside_sd", psf.outside_sd);
  put_number(out, "diffraction_px", psf.diffraction_px);
  put_number(out, "diffraction_px_sd", psf.diffraction_sd);
  out["mtf_x"] = random_curve(psf, 1, 0);
  out["mtf_y"] = random_curve(psf, 0, 1);
  Json plane = Json::array();
  for (int j = -10; j <= 10; ++j) {
    Json row = Json::array();
    for (int i = 0; i <= 10; ++i)
      row.push_back(number_or_null(psf.mtf_of_all(0.05 * i, 0.05 * j).value));
    plane.push_back(row);
  }
  out["mtf_plane"] = {{"fx", {0, 0.05, 0.5}}, {"fy", {-0.5, 0.05, 0.5}}, {"rows_of_fy", plane}};
  return out;
}

}  // namespace

TargetName parse_target(const std::string& text) {
  TargetName out;
  const char* const end = text.data() + text.size();
  const auto [comma, bad_seed] = std::from_chars(text.data(), end, out.seed);
  bool good = bad_seed == std::errc();
  if (good && comma != end) {
    const auto [stop, bad_cell] = std::from_chars(comma + 1, end, out.cell_um);
    good = *comma == ',' && bad_cell == std::errc() && stop == end;
  }
  if (!good || !(out.cell_um >= 0.5) || !(out.cell_um <= 100)) {
    throw InputError("--target takes SEED or SEED,CELL_UM, cells of 0.5 to 100 µm, not '" + text +
                     "'.");
  }
  return out;
}

bool RandomOfFile::measured() const {
  return std::ranges::any_of(channels, [](const RandomOfChannel& c) { return c.psf.ok(); });
}

RandomOfFile measure_random_file(const std::filesystem::path& path, const TargetName& target,
                                 double dpi, const MeasureChoice& choice, Reporter& reporter) {
  const LinearPicture picture(path, choice.read);
  for (const std::string& note : picture.notes()) reporter.note(note);
  RandomOfFile out{path, target, dpi > 0 ? dpi : picture.dpi(), {}, picture.context(), {}};
  if (!(out.dpi > 0)) {
    throw InputError("'" + path.string() + "' does not say its resolution; give --dpi.");
  }
  const double cell_px = target.cell_um * out.dpi / 25400;
  if (!(cell_px >= 0.2) || !(cell_px <= 1.5)) {
    throw InputError(
        fmt::format("Cells of {} µm are {:.2f} px at {:.0f} dpi; a spread can be told "
                    "from cells of 0.2 to 1.5 px.",
                    target.cell_um, cell_px, out.dpi));
  }
  out.region = choice.roi.value_or(PixelRect{0, 0, picture.width_px(), picture.height_px()});
  const PixelRect& r = out.region;
  if (r.x < 0 || r.y < 0 || r.width <= 0 || r.height <= 0 || r.x > picture.width_px() - r.width ||
      r.y > picture.height_px() - r.height) {
    throw Failure(kExitUsage, "The region does not lie within the picture of the random target.",
                  "Give --roi x,y,width,height in whole pixels.");
  }
  RandomOptions options;
  options.lowest = picture.lowest();
  options.highest = picture.highest();
  // Only the middle is looked at.
  const PixelRect middle{r.x + std::max(0, r.width - options.most_px) / 2,
                         r.y + std::max(0, r.height - options.most_px) / 2,
                         std::min(r.width, options.most_px), std::min(r.height, options.most_px)};
  const RandomCells cells({target.seed, cell_px});
  // Green first: where it lies spares the others the search.
  std::vector<std::size_t> order;
  for (std::size_t c = 0; c < picture.channels().size(); ++c) {
    out.channels.push_back({picture.channels()[c], {}});
    const bool green = picture.channels()[c] == "green";
    order.insert(green ? order.begin() : order.end(), c);
  }
  const RandomPsf* start = nullptr;
  for (const std::size_t c : order) {
    const std::vector<float> samples = picture.plane(c, middle);
    RandomPsf& psf = out.channels[c].psf;
    psf = measure_random(Span2D<const float>(samples.data(), middle.width, middle.height), cells,
                         options, start);
    psf.middle_px =
        psf.middle_px + Vec2{static_cast<double>(middle.x), static_cast<double>(middle.y)};
    if (start == nullptr && psf.ok()) start = &psf;
  }
  return out;
}

std::vector<RandomAgainstEdge> against_edges(const std::vector<RandomOfFile>& random,
                                             const std::vector<MeasuredFile>& edges) {
  std::vector<RandomAgainstEdge> out;
  for (const RandomOfFile& file : random) {
    for (const RandomOfChannel& target : file.channels) {
      if (!target.psf.ok()) continue;
      for (const MeasuredFile& of : edges) {
        for (const MeasuredEdge& edge : of.edges) {
          for (const ChannelEdge& c : edge.channels) {
            const EdgeMeasurement& m = c.measured;
            if (c.channel != target.channel || m.status == EdgeStatus::kRefused ||
                !m.mtf.all.mtf50) {
              continue;
            }
            const RandomPsf::Point at = target.psf.mtf50(m.line.normal_rad);
            if (!(at.value > 0)) continue;
            out.push_back(
                {c.channel, m.angle_deg, at, {m.mtf.all.mtf50->f_cy_per_px, m.mtf.all.mtf50->sd}});
          }
        }
      }
    }
  }
  return out;
}

void put_random(const RandomOfFile& file, Profile& profile) {
  for (const RandomOfChannel& c : file.channels) {
    const auto at = profile_channel(c.channel);
    if (!at || !c.psf.ok()) continue;
    const RandomPsf& psf = c.psf;
    RandomRecord record;
    record.seed = static_cast<double>(file.target.seed);
    record.cell_um = file.target.cell_um;
    record.side = psf.side;
    record.step_px = psf.step_px;
    record.psf = psf.psf;
    record.sd = psf.sd;
    record.relative_sd = psf.relative_sd;
    record.light_outside = {psf.outside, psf.outside_sd};
    const RandomPsf::Point x = psf.mtf50(0), y = psf.mtf50(std::acos(0.0));
    if (x.value > 0) record.mtf50_x = Measured{x.value, x.sd};
    if (y.value > 0) record.mtf50_y = Measured{y.value, y.sd};
    constexpr int kPoints = 36;
    constexpr double kStep = 0.02;
    std::vector<TransferPoint> mean;
    for (int i = 0; i < kPoints; ++i) {
      const double f = kStep * i;
      const RandomPsf::Point along_x = psf.mtf_of_all(f, 0), along_y = psf.mtf_of_all(0, f);
      record.along_x.push_back({f, along_x.value, along_x.sd});
      record.along_y.push_back({f, along_y.value, along_y.sd});
      mean.push_back({f, 0.5 * (along_x.value + along_y.value),
                      std::hypot(0.5 * (along_x.value - along_y.value),
                                 0.5 * std::hypot(along_x.sd, along_y.sd))});
    }
    if (profile.transfer[*at].empty()) profile.transfer[*at] = mean;
    profile.random[*at] = std::move(record);
  }
}

Json random_to_json(const RandomOfFile& file) {
  Json out = {{"file", file.path.string()},
              {"target", {{"seed", file.target.seed}, {"cell_um", file.target.cell_um}}},
              {"region", {file.region.x, file.region.y, file.region.width, file.region.height}}};
  put_number(out, "dpi", file.dpi);
  Json channels = Json::object();
  for (const RandomOfChannel& c : file.channels) channels[c.channel] = random_channel_json(c.psf);
  out["channels"] = channels;
  return out;
}

Json against_to_json(const std::vector<RandomAgainstEdge>& pairs) {
  Json out = Json::array();
  for (const RandomAgainstEdge& p : pairs) {
    out.push_back({{"channel", p.channel},
                   {"edge_angle_deg", number_or_null(p.angle_deg)},
                   {"mtf50_random", number_or_null(p.random.value)},
                   {"mtf50_random_sd", number_or_null(p.random.sd)},
                   {"mtf50_edge", number_or_null(p.edge.value)},
                   {"mtf50_edge_sd", number_or_null(p.edge.sd)}});
  }
  return out;
}

std::string describe(const RandomOfFile& file) {
  std::string text = fmt::format("{}\n  random target {}, cells of {} µm\n", file.path.string(),
                                 file.target.seed, file.target.cell_um);
  for (const RandomOfChannel& c : file.channels) {
    const RandomPsf& psf = c.psf;
    if (!psf.ok()) {
      text += fmt::format("    {:<9} no figure: {}\n", c.channel, sentence(psf.status));
      continue;
    }
    const RandomPsf::Point along = psf.mtf50(0), across = psf.mtf50(std::acos(0.0));
    text += fmt::format(
        "    {:<9} spread known to {:.2f} %; MTF50 {:.4f} ± {:.4f} along the sensor, {:.4f} ± "
        "{:.4f} along the motion; {:.2f} ± {:.2f} % of the light beyond; target turned by {:.2f}°, "
        "placed to {:.4f}, {:.4f} px\n",
        c.channel, 100 * psf.relative_sd, along.value, along.sd, across.value, across.sd,
        100 * psf.outside, 100 * psf.outside_sd, psf.turn_deg, psf.origin_sd_px.x,
        psf.origin_sd_px.y);
  }
  text.pop_back();
  return text;
}

std::string describe(const std::vector<RandomAgainstEdge>& pairs) {
  std::string text = "Random target against edges\n";
  for (const RandomAgainstEdge& p : pairs) {
    text += fmt::format(
        "  {:<9} edge at {:+.2f}°: MTF50 {:.4f} ± {:.4f} from the target, {:.4f} ± {:.4f} from the "
        "edge ({:+.2f} %)\n",
        p.channel, p.angle_deg, p.random.value, p.random.sd, p.edge.value, p.edge.sd,
        100 * (p.random.value / p.edge.value - 1));
  }
  text.pop_back();
  return text;
}

}  // namespace reseau::cli
