#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "capture/color/color_record.h"
#include "capture/compare/color_decode.h"
#include "capture/compare/picture_files.h"
#include "capture/image/exr_file.h"
#include "core/base/error.h"
#include "core/color/adaptation.h"

namespace reseau::compare {
namespace {

bool holds(const std::vector<std::string>& names, std::initializer_list<const char*> wanted) {
  return std::all_of(wanted.begin(), wanted.end(), [&](const char* name) {
    return std::find(names.begin(), names.end(), name) != names.end();
  });
}

bool same_points(const Chromaticities& a, const Chromaticities& b, double tolerance) {
  for (std::size_t i = 0; i < a.xy.size(); ++i) {
    for (std::size_t k = 0; k < 2; ++k) {
      if (std::abs(a.xy[i][k] - b.xy[i][k]) > tolerance) return false;
    }
  }
  return true;
}

// The axes of XYZ with equal energy as white: numbers are XYZ relative to D65.
bool is_xyz_axes(const Chromaticities& declared) {
  return same_points(declared, {{{{1, 0}, {0, 1}, {0, 0}, {1.0 / 3, 1.0 / 3}}}}, 1e-5);
}

class ExrPicture final : public Picture {
 public:
  ExrPicture(PictureHeader header, const PictureChoice& choice) : Picture(std::move(header)) {
    if (header_.has_color) open_color(choice);
    if (header_.has_map) {
      map_ = std::make_unique<ExrReader>(header_.path, std::vector<std::string>{"u", "v"});
    }
  }

  void read(int first_row, int n_rows, std::span<float> out) override {
    if (n_channels_ == 3) return color_->read(first_row, n_rows, out);
    raw_.resize(out.size() / 3 * n_channels_);
    color_->read(first_row, n_rows, raw_);
    for (std::size_t i = 0; i < out.size() / 3; ++i) {
      const float* const from = &raw_[i * n_channels_];
      const bool clear = n_channels_ == 4 && from[3] == 0.0F;
      for (std::size_t k = 0; k < 3; ++k) {
        out[3 * i + k] = clear ? NAN : from[n_channels_ == 1 ? 0 : k];
      }
    }
  }
  void to_xyz(std::span<const float> samples, std::span<float> xyz) const override {
    decode_->to_xyz(samples, xyz);
  }
  void read_map(int first_row, int n_rows, std::span<float> out) override {
    map_->read(first_row, n_rows, out);
  }

 private:
  void open_color(const PictureChoice& choice) {
    const std::vector<std::string> all = read_exr_header(header_.path).channels;
    std::vector<std::string> channels{"R", "G", "B"};
    if (choice.scene_layer) {
      channels = {"scene.R", "scene.G", "scene.B"};
    } else if (!holds(all, {"R", "G", "B"})) {
      channels = {"Y"};
    } else if (holds(all, {"A"})) {
      channels.emplace_back("A");
      notes_.emplace_back("Pixels with alpha 0 are left out; others count as they are stored.");
    }
    n_channels_ = channels.size();
    color_ = std::make_unique<ExrReader>(header_.path, channels);
    Matrix3 xyz = xyz_from_linear_srgb();
    if (choice.xyz_from_samples) {
      xyz = *choice.xyz_from_samples;
      encoding_ = "given";
    } else if (choice.scene_layer || !header_.chromaticities) {
      encoding_ = "linear sRGB assumed";
      notes_.emplace_back("It declares no chromaticities; those of sRGB are assumed.");
    } else {
      encoding_ = header_.space == "process" ? "process RGB, chromaticities" : "chromaticities";
      xyz = *declared_xyz(header_);
    }
    decode_ = linear_decode(xyz);
    const bool axes = header_.chromaticities && is_xyz_axes(*header_.chromaticities);
    own_white_ = axes ? white_of(Illuminant::kD65) : multiply(xyz, Vector3{1, 1, 1});
  }

  std::unique_ptr<ExrReader> color_, map_;
  std::unique_ptr<ColorDecode> decode_;
  std::size_t n_channels_ = 3;
  std::vector<float> raw_;
};

}  // namespace

std::optional<Matrix3> declared_xyz(const PictureHeader& header) {
  if (!header.chromaticities) return std::nullopt;
  const Matrix3 xyz = xyz_from_rgb(*header.chromaticities);
  const Xyz d65 = white_of(Illuminant::kD65);
  const Chromaticity exact = chromaticity_of(d65);
  // A white that is D65 to the digits of a file counts as the D65 of this project.
  constexpr double kRounding = 1e-4;
  const Chromaticity& white = header.chromaticities->xy[3];
  const bool is_d65 =
      std::abs(white[0] - exact[0]) <= kRounding && std::abs(white[1] - exact[1]) <= kRounding;
  if (is_d65) {
    return multiply(bradford_target_from_source(xyz_from_chromaticity(white, 1.0), d65), xyz);
  }
  if (!header.adopted_neutral) return xyz;
  const Chromaticity& neutral = *header.adopted_neutral;
  if (std::abs(neutral[0] - exact[0]) <= kRounding &&
      std::abs(neutral[1] - exact[1]) <= kRounding) {
    return xyz;
  }
  return multiply(bradford_target_from_source(xyz_from_chromaticity(neutral, 1.0), d65), xyz);
}

PictureHeader read_exr_picture_header(const std::filesystem::path& path) {
  const ExrHeader exr = read_exr_header(path);
  PictureHeader header;
  header.path = path;
  header.format = "OpenEXR";
  header.width_px = exr.width_px;
  header.height_px = exr.height_px;
  header.chromaticities = exr.chromaticities;
  const ExrReader reader(path, {});
  header.adopted_neutral = reader.adopted_neutral();
  try {
    header.output_from_process = output_from_process_of(reader, path.string());
  } catch (const InputError&) {
    // Most pictures do not hold it.
  }
  header.has_color = holds(exr.channels, {"R", "G", "B"}) || holds(exr.channels, {"Y"});
  header.has_scene = holds(exr.channels, {"scene.R", "scene.G", "scene.B"});
  header.has_map = holds(exr.channels, {"u", "v"});
  for (const auto& [name, value] : exr.attributes) {
    if (name == "reseau.space") header.space = value;
    if (name == "reseau.primaries") header.primaries = value;
    if (name == "reseau.balance") header.balance = value;
    if (name == "reseau.truth") header.has_process = header.has_color;
  }
  return header;
}

std::unique_ptr<Picture> open_exr_picture(const PictureHeader& header,
                                          const PictureChoice& choice) {
  if (!header.has_color && !header.has_map) {
    std::string there;
    for (const std::string& name : read_exr_header(header.path).channels) {
      there += there.empty() ? name : ", " + name;
    }
    throw InputError(fmt::format(
        "The picture '{}' has neither colours (R, G, B or Y) nor a map (u, v); it has: {}.",
        header.path.string(), there));
  }
  return std::make_unique<ExrPicture>(header, choice);
}

}  // namespace reseau::compare
