// A crop of a real transparency, where the files beside the tree are there: no réseau may be left.
#include <array>
#include <cmath>
#include <complex>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <numbers>
#include <span>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "capture/image/scan_reader.h"
#include "core/geometry/vec2.h"
#include "core/line/line_source.h"
#include "core/reconstruct/reconstruct.h"
#include "core/reconstruct/row_sink.h"
#include "core/screen/screen_map.h"

namespace reseau {
namespace {

class InMemory final : public RgbRowSink {
 public:
  void begin(int /*width_px*/, int /*height_px*/) override { rgb.clear(); }
  void rows(int /*first_row*/, int /*n_rows*/, std::span<const float> part) override {
    rgb.insert(rgb.end(), part.begin(), part.end());
  }
  void end() override {}
  std::vector<float> rgb;
};

// Energy of [row][pixel][R G B] at the réseau's first harmonics, each channel over its mean, per
// channel, summed over windows that follow the map.
std::array<double, 3> energy_at_the_lattice(const std::vector<float>& rgb, int width, int height,
                                            const ScreenMap& map) {
  constexpr int kSize = 64, kRim = 16;
  constexpr std::array<Vec2, 6> kHarmonics{{{1, 0}, {0, 1}, {1, 1}, {1, -1}, {2, 0}, {0, 2}}};
  std::array<double, 3> mean{}, energy{};
  for (std::size_t i = 0; i < rgb.size(); ++i) mean[i % 3] += static_cast<double>(rgb[i]);
  for (double& m : mean) m /= static_cast<double>(rgb.size()) / 3;
  for (int y0 = kRim; y0 + kSize <= height - kRim; y0 += kSize / 2) {
    for (int x0 = kRim; x0 + kSize <= width - kRim; x0 += kSize / 2) {
      std::array<double, 3> middle{};
      std::array<std::array<std::complex<double>, 3>, kHarmonics.size()> sum{};
      std::array<std::complex<double>, kHarmonics.size()> of_one{};
      double weights = 0;
      for (int y = 0; y < kSize; ++y) {
        for (int x = 0; x < kSize; ++x) {
          const auto hann = [](int i) {
            return 0.5 - 0.5 * std::cos(2 * std::numbers::pi * (i + 0.5) / kSize);
          };
          const double weight = hann(x) * hann(y);
          const Vec2 s =
              map.screen_from_scan({static_cast<double>(x0 + x), static_cast<double>(y0 + y)});
          const float* p =
              &rgb[(static_cast<std::size_t>(y0 + y) * static_cast<std::size_t>(width) +
                    static_cast<std::size_t>(x0 + x)) *
                   3];
          weights += weight;
          for (std::size_t c = 0; c < 3; ++c) middle[c] += weight * static_cast<double>(p[c]);
          for (std::size_t k = 0; k < kHarmonics.size(); ++k) {
            const auto turn = std::polar(weight, -2 * std::numbers::pi * dot(kHarmonics[k], s));
            of_one[k] += turn;
            for (std::size_t c = 0; c < 3; ++c) sum[k][c] += turn * static_cast<double>(p[c]);
          }
        }
      }
      for (std::size_t k = 0; k < kHarmonics.size(); ++k) {
        for (std::size_t c = 0; c < 3; ++c) {
          energy[c] +=
              std::norm((sum[k][c] - middle[c] / weights * of_one[k]) / (weights * mean[c]));
        }
      }
    }
  }
  return energy;
}

TEST(RealCrop, NoReseauIsLeftInThePicture) {
  const std::filesystem::path path =
      std::filesystem::path(RESEAU_SHARED_DIR) / "data/scans/dufaycolor-ls9000-4000dpi-party.tif";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "no " << path << " here";
  // Linear, whatever its profile says.
  const Scan scan = read_scan(path);
  const LineSource& source = *scan.source;
  const int width = source.format().width_px, height = source.committed();
  const Registration registration = register_screen(source, {}, {}, {});
  ASSERT_TRUE(registration.found) << registration.reason;
  std::vector<std::uint16_t> samples(source.format().samples_per_line());
  std::vector<float> seen;
  for (int y = 0; y < height; ++y) {
    source.read(y, 1, samples);
    for (std::size_t x = 0; x < static_cast<std::size_t>(width); ++x) {
      for (std::size_t c = 0; c < 3; ++c)
        seen.push_back(static_cast<float>(samples[c * static_cast<std::size_t>(width) + x]));
    }
  }
  const auto before = energy_at_the_lattice(seen, width, height, registration.map);
  // Grain and picture have some at any frequency; the promise is 0.01.
  for (const auto& [quality, bound] :
       {std::pair{Quality::kDraft, 0.0005}, std::pair{Quality::kStandard, 0.0005},
        std::pair{Quality::kBest, 0.001}}) {
    ReconstructOptions options;
    options.quality = quality;
    InMemory picture;
    static_cast<void>(reconstruct(source, registration, options, picture, {}, {}));
    const auto after = energy_at_the_lattice(picture.rgb, width, height, registration.map);
    for (std::size_t c = 0; c < 3; ++c) {
      EXPECT_LT(after[c], bound * before[c])
          << "channel " << c << ", quality " << static_cast<int>(quality);
    }
  }
}

}  // namespace
}  // namespace reseau
