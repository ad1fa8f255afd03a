#include "capture/cli/calibrate_random.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include <fmt/format.h>

#include "capture/session/json_number.h"
#include "core/base/error.h"

namespace reseau::cli {
namespace {

using Json = nlohmann::ordered_json;

}  // namespace

RandomAsked parse_random(const std::string& text) {
  std::vector<double> numbers;
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t end = std::min(text.find(',', at), text.size());
    double value = 0;
    const auto [stop, error] = std::from_chars(text.data() + at, text.data() + end, value);
    if (error != std::errc() || stop != text.data() + end) {
      throw InputError("--random takes SEED,CELL_PX or SEED,CELL_PX,X,Y in numbers, not '" + text +
                       "'.");
    }
    numbers.push_back(value);
    at = end + 1;
  }
  const bool good = (numbers.size() == 2 || numbers.size() == 4) && numbers[0] >= 0 &&
                    numbers[0] < 9007199254740992.0 && numbers[0] == std::floor(numbers[0]) &&
                    numbers[1] >= 0.2 && numbers[1] <= 8;
  if (!good) {
    throw InputError(
        "--random takes a seed in whole numbers and cells of 0.2 to 8 px, SEED,CELL_PX, with the "
        "place of the picture in the target, X,Y, if it is not 0,0.");
  }
  RandomAsked out;
  out.target = {static_cast<std::uint64_t>(numbers[0]), numbers[1]};
  if (numbers.size() == 4) out.start_px = {numbers[2], numbers[3]};
  return out;
}

bool RandomOfFile::measured() const {
  return std::ranges::any_of(channels, [](const RandomOfChannel& c) { return c.psf.ok; });
}

RandomOfFile measure_random_file(const std::filesystem::path& path, const RandomAsked& asked,
                                 const MeasureChoice& choice, Reporter& reporter) {
  const LinearPicture picture(path, choice.read);
  for (const std::string& note : picture.notes()) reporter.note(note);
  RandomOptions options;
  PixelRect region{0, 0, picture.width_px(), picture.height_px()};
  if (choice.roi) region = *choice.roi;
  const bool inside = region.x >= 0 && region.y >= 0 && region.width > 0 && region.height > 0 &&
                      region.x <= picture.width_px() - region.width &&
                      region.y <= picture.height_px() - region.height;
  if (!inside) throw InputError("The region does not lie within the picture.");
  // Only the middle is looked at.
  const PixelRect middle{region.x + std::max(0, region.width - options.most_px) / 2,
                         region.y + std::max(0, region.height - options.most_px) / 2,
                         std::min(region.width, options.most_px),
                         std::min(region.height, options.most_px)};
  options.start_px = asked.start_px + Vec2{static_cast<double>(middle.x - region.x),
                                           static_cast<double>(middle.y - region.y)};
  RandomOfFile out{path, {}};
  for (std::size_t c = 0; c < picture.channels().size(); ++c) {
    const std::vector<float> samples = picture.plane(c, middle);
    out.channels.push_back(
        {picture.channels()[c],
         measure_random(Span2D<const float>(samples.data(), middle.width, middle.height),
                        asked.target, options)});
    RandomPsf& psf = out.channels.back().psf;
    // Told of the region's first pixel.
    psf.origin_px = psf.origin_px - psf.scale * Vec2{static_cast<double>(middle.x - region.x),
                                                     static_cast<double>(middle.y - region.y)};
  }
  return out;
}

Json random_to_json(const RandomOfFile& file) {
  Json out = {{"schema", "reseau-calibration-random/1"}, {"file", file.path.string()}};
  Json channels = Json::object();
  for (const RandomOfChannel& c : file.channels) {
    const RandomPsf& psf = c.psf;
    Json one = Json::object();
    one["ok"] = psf.ok;
    put_number(one, "smallest_eigenvalue_share", psf.smallest_share);
    if (!psf.ok) {
      one["why"] = psf.why;
      channels[c.channel] = one;
      continue;
    }
    one["side"] = psf.side;
    put_number(one, "step_px", psf.step_px);
    one["psf_per_px2"] = psf.psf;
    one["psf_sd"] = psf.sd;
    put_number(one, "relative_sd", psf.sd_of_all);
    one["origin_px"] = {psf.origin_px.x, psf.origin_px.y};
    one["origin_sd_px"] = {psf.origin_sd_px.x, psf.origin_sd_px.y};
    one["scale"] = {{psf.scale.a, psf.scale.b}, {psf.scale.c, psf.scale.d}};
    put_number(one, "noise", psf.noise);
    Json along = Json::array(), across = Json::array();
    for (int i = 0; i <= 50; ++i) {
      along.push_back({0.01 * i, number_or_null(psf.mtf(0.01 * i, 0))});
      across.push_back({0.01 * i, number_or_null(psf.mtf(0, 0.01 * i))});
    }
    one["mtf_x"] = along;
    one["mtf_y"] = across;
    channels[c.channel] = one;
  }
  out["channels"] = channels;
  return out;
}

std::string describe(const RandomOfFile& file) {
  std::string text = file.path.string() + "\n";
  for (const RandomOfChannel& c : file.channels) {
    const RandomPsf& psf = c.psf;
    if (!psf.ok) {
      text += fmt::format("  {:<9} {}\n", c.channel, psf.why);
      continue;
    }
    text += fmt::format(
        "  {:<9} spread known to {:.2f} %; modulation at 0.25 cycles/pixel {:.3f} along the "
        "sensor, {:.3f} along the motion; lies at {:.4f}, {:.4f} px (± {:.4f}, {:.4f})\n",
        c.channel, 100 * psf.sd_of_all, psf.mtf(0.25, 0), psf.mtf(0, 0.25), psf.origin_px.x,
        psf.origin_px.y, psf.origin_sd_px.x, psf.origin_sd_px.y);
  }
  text.pop_back();
  return text;
}

}  // namespace reseau::cli
