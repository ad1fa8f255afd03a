#include "drivers/pieusb/shading.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/base/check.h"
#include "core/base/error.h"
#include "drivers/pieusb/line_sorter.h"

namespace reseau::pieusb {
namespace {

// Dark lines lie near 170, light ones near 47000; a line below this share of the brightest of its
// colour is dark.
constexpr double kDarkShare = 0.25;
// Fraction of full scale that light lines have to reach.
constexpr double kLeastLight = 0.02;
// A column with less than this share of the mean light cannot be evened out.
constexpr double kWeakShare = 0.05;

// Sample i of a line after its tag.
int sample_at(ByteView line, std::size_t i) {
  const std::byte* const at = line.data() + kTagBytes + 2 * i;
  return std::to_integer<int>(at[0]) | std::to_integer<int>(at[1]) << 8;
}

double mean_of(const std::vector<float>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

std::vector<float> average(const std::vector<ByteView>& lines, std::size_t width) {
  std::vector<double> sum(width);
  for (const ByteView line : lines) {
    for (std::size_t i = 0; i < width; ++i) {
      sum[i] += sample_at(line, i);
    }
  }
  std::vector<float> mean(width);
  for (std::size_t i = 0; i < width; ++i) {
    mean[i] = static_cast<float>(sum[i] / static_cast<double>(lines.size()));
  }
  return mean;
}

double level_of(ByteView line, std::size_t width) {
  std::uint64_t sum = 0;
  for (std::size_t i = 0; i < width; ++i) sum += static_cast<std::uint64_t>(sample_at(line, i));
  return static_cast<double>(sum) / static_cast<double>(width);
}

// Values of weak columns on the line between their neighbours.
int mend(std::vector<float>& gain, const std::vector<bool>& weak) {
  const auto n = static_cast<std::ptrdiff_t>(gain.size());
  int n_weak = 0;
  for (std::ptrdiff_t i = 0; i < n; ++i) {
    if (!weak[static_cast<std::size_t>(i)]) continue;
    ++n_weak;
    std::ptrdiff_t before = i - 1, after = i + 1;
    while (before >= 0 && weak[static_cast<std::size_t>(before)]) --before;
    while (after < n && weak[static_cast<std::size_t>(after)]) ++after;
    if (before < 0 && after >= n) continue;
    const float left = gain[static_cast<std::size_t>(before >= 0 ? before : after)];
    const float right = gain[static_cast<std::size_t>(after < n ? after : before)];
    const auto share = before >= 0 && after < n
                           ? static_cast<float>(i - before) / static_cast<float>(after - before)
                           : 0.0F;
    gain[static_cast<std::size_t>(i)] = left + (right - left) * share;
  }
  return n_weak;
}

}  // namespace

ShadingReference reference_of(ByteView lines, int width_px) {
  CHECK(width_px > 0);
  const auto width = static_cast<std::size_t>(width_px);
  const std::size_t stride = kTagBytes + 2 * width;
  std::array<std::vector<ByteView>, 4> of_colour;
  for (std::size_t at = 0; at + stride <= lines.size(); at += stride) {
    const ByteView line = lines.subspan(at, stride);
    const int channel = channel_of_tag(line);
    if (channel >= 0) of_colour[static_cast<std::size_t>(channel)].push_back(line);
  }
  ShadingReference reference;
  reference.width_px = width_px;
  for (std::size_t c = 0; c < of_colour.size(); ++c) {
    std::vector<double> levels;
    for (const ByteView line : of_colour[c]) levels.push_back(level_of(line, width));
    const double brightest = levels.empty() ? 0 : *std::max_element(levels.begin(), levels.end());
    std::vector<ByteView> dark, light;
    for (std::size_t i = 0; i < levels.size(); ++i) {
      (levels[i] < kDarkShare * brightest ? dark : light).push_back(of_colour[c][i]);
    }
    const bool lit = brightest >= kLeastLight * 65535;
    if (c < 3 && !lit) {
      throw DeviceError(DeviceError::Kind::kHardware,
                        "The scanner's calibration saw no light. Close its cover and switch it off "
                        "and on; if it happens again, its lamp needs service.",
                        "calibration lines of colour " + std::to_string(c) + ", brightest " +
                            std::to_string(brightest));
    }
    if (!lit) continue;
    if (!dark.empty()) reference.dark[c] = average(dark, width);
    reference.light[c] = average(light, width);
    reference.n_dark[c] = static_cast<int>(dark.size());
    reference.n_light[c] = static_cast<int>(light.size());
  }
  return reference;
}

Shading::Shading(const ShadingReference& reference, const std::vector<int>& used, int width_px) {
  CHECK(width_px > 0);
  std::vector<std::size_t> pixels;
  for (const int pixel : used) {
    if (pixel >= 0 && pixel < reference.width_px) pixels.push_back(static_cast<std::size_t>(pixel));
  }
  if (pixels.empty()) {
    // A mask without a used pixel: the whole sensor is the best guess.
    pixels.resize(static_cast<std::size_t>(reference.width_px));
    std::iota(pixels.begin(), pixels.end(), std::size_t{0});
  }
  const auto width = static_cast<std::size_t>(width_px);
  for (std::size_t c = 0; c < gain_.size(); ++c) {
    if (reference.light[c].empty()) continue;
    std::vector<float> dark(width), light(width);
    for (std::size_t j = 0; j < width; ++j) {
      const std::size_t at = pixels.size() == width ? j : (2 * j + 1) * pixels.size() / (2 * width);
      const std::size_t pixel = pixels[at];
      light[j] = reference.light[c][pixel];
      dark[j] = reference.dark[c].empty() ? 0.0F : reference.dark[c][pixel];
    }
    const double span = mean_of(light) - mean_of(dark);
    std::vector<float> gain(width, 1.0F);
    std::vector<bool> weak(width);
    for (std::size_t j = 0; j < width; ++j) {
      const double own = static_cast<double>(light[j]) - static_cast<double>(dark[j]);
      weak[j] = !(own > kWeakShare * span);
      if (!weak[j]) gain[j] = static_cast<float>(span / own);
    }
    n_weak_ += mend(gain, weak);
    dark_[c] = std::move(dark);
    gain_[c] = std::move(gain);
  }
}

void Shading::apply(std::span<std::uint16_t> row, int n_channels) const {
  const std::size_t width = row.size() / static_cast<std::size_t>(n_channels);
  for (std::size_t c = 0; c < static_cast<std::size_t>(n_channels); ++c) {
    if (gain_[c].empty()) continue;
    CHECK(gain_[c].size() == width);
    std::uint16_t* const samples = row.data() + c * width;
    for (std::size_t i = 0; i < width; ++i) {
      // What was cut off stays visible as such.
      if (samples[i] == 65535) continue;
      const float even = (static_cast<float>(samples[i]) - dark_[c][i]) * gain_[c][i];
      constexpr float kHalf = 0.5F;  // nothing is negative: this rounds
      samples[i] = static_cast<std::uint16_t>(std::clamp(even, 0.0F, 65535.0F) + kHalf);
    }
  }
}

}  // namespace reseau::pieusb
