#include "capture/bench/picture_score.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/check.h"
#include "core/base/parallel.h"
#include "core/color/delta_e.h"

namespace reseau {
namespace {

// IEC 61966-2-1.
constexpr std::array<double, 9> kXyzFromSrgb{0.4123908, 0.3575843, 0.1804808, 0.2126390, 0.7151687,
                                             0.0721923, 0.0193308, 0.1191948, 0.9505322};

Lab lab_of(const float* rgb) {
  Xyz xyz{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j)
      xyz[i] += kXyzFromSrgb[3 * i + j] * static_cast<double>(rgb[j]);
  }
  return lab_from_xyz(xyz, {0.9505, 1.0, 1.0890});
}

// [row][pixel][3], mirrored at the borders.
std::vector<float> blurred(const std::vector<float>& rgb, int width, int height, double sigma_px) {
  const int reach = static_cast<int>(std::ceil(4 * sigma_px));
  std::vector<float> weight(static_cast<std::size_t>(2 * reach) + 1);
  float* const middle = weight.data() + reach;
  float total = 0;
  for (int i = -reach; i <= reach; ++i) {
    const double x = i / sigma_px;
    total += middle[i] = static_cast<float>(std::exp(-0.5 * x * x));
  }
  for (float& w : weight) w /= total;
  const auto pass = [&](const std::vector<float>& from, bool along_x) {
    std::vector<float> to(from.size());
    const int n = along_x ? width : height;
    parallel_for(height, [&](int y) {
      for (int x = 0; x < width; ++x) {
        std::array<float, 3> sum{};
        for (int i = -reach; i <= reach; ++i) {
          int at = (along_x ? x : y) + i;
          at = std::clamp(at < 0 ? -at : at >= n ? 2 * n - 2 - at : at, 0, n - 1);
          const float* p =
              &from[(static_cast<std::size_t>(along_x ? y : at) * static_cast<std::size_t>(width) +
                     static_cast<std::size_t>(along_x ? at : x)) *
                    3];
          for (std::size_t c = 0; c < 3; ++c) sum[c] += middle[i] * p[c];
        }
        std::copy_n(sum.begin(), 3, to.begin() + (static_cast<std::ptrdiff_t>(y) * width + x) * 3);
      }
    });
    return to;
  };
  return pass(pass(rgb, true), false);
}

std::vector<double> differences(const std::vector<float>& a, const std::vector<float>& b) {
  std::vector<double> result(a.size() / 3);
  constexpr int kPieces = 64;
  parallel_for(kPieces, [&](int piece) {
    const std::size_t first = result.size() * static_cast<std::size_t>(piece) / kPieces,
                      end = result.size() * (static_cast<std::size_t>(piece) + 1) / kPieces;
    for (std::size_t i = first; i < end; ++i)
      result[i] = delta_e_2000(lab_of(&a[3 * i]), lab_of(&b[3 * i]));
  });
  return result;
}

double quantile(std::vector<double>& values, double q) {
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(q * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

double mean_of(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v;
  return sum / static_cast<double>(std::max<std::size_t>(values.size(), 1));
}

void score_patches(const sim::FilmTruth& truth, double period_px, const std::vector<float>& rgb,
                   int width, int height, PictureScore& score) {
  // What blurs across a border of a field is no colour of the field.
  constexpr double kMarginPeriods = 1.5;
  const double margin = kMarginPeriods * period_px;
  double sum = 0;
  for (const sim::Patch& patch : truth.patches()) {
    if (std::min(patch.x1 - patch.x0, patch.y1 - patch.y0) < 12 * period_px) continue;
    const int x0 = std::max(0, static_cast<int>(std::ceil(patch.x0 + margin)));
    const int y0 = std::max(0, static_cast<int>(std::ceil(patch.y0 + margin)));
    const int x1 = std::min(width - 1, static_cast<int>(std::floor(patch.x1 - margin)));
    const int y1 = std::min(height - 1, static_cast<int>(std::floor(patch.y1 - margin)));
    if (x1 < x0 || y1 < y0) continue;
    std::array<double, 3> mean{};
    for (int y = y0; y <= y1; ++y) {
      const float* p = &rgb[(static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                             static_cast<std::size_t>(x0)) *
                            3];
      for (int x = x0; x <= x1; ++x, p += 3) {
        for (std::size_t c = 0; c < 3; ++c) mean[c] += static_cast<double>(p[c]);
      }
    }
    std::array<float, 3> found{}, wanted{};
    const double n = static_cast<double>(x1 - x0 + 1) * (y1 - y0 + 1);
    for (std::size_t c = 0; c < 3; ++c) {
      found[c] = static_cast<float>(mean[c] / n);
      wanted[c] = static_cast<float>(patch.rgb[c]);
    }
    const double e = delta_e_2000(lab_of(found.data()), lab_of(wanted.data()));
    sum += e;
    score.patch_max = std::max(score.patch_max, e);
    ++score.n_patches;
  }
  score.patch_mean = sum / std::max(score.n_patches, 1);
}

}  // namespace

void PictureInMemory::begin(int width_px, int height_px) {
  width_px_ = width_px;
  height_px_ = height_px;
  rgb_.assign(static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px) * 3, 0.0F);
}

void PictureInMemory::rows(int first_row, int n_rows, std::span<const float> rgb) {
  const std::size_t row = static_cast<std::size_t>(width_px_) * 3;
  CHECK(first_row >= 0 && first_row + n_rows <= height_px_);
  std::copy_n(rgb.begin(), row * static_cast<std::size_t>(n_rows),
              rgb_.begin() + static_cast<std::ptrdiff_t>(row) * first_row);
}

PictureScore score_picture(const sim::FilmTruth& truth, double period_px,
                           const PictureInMemory& picture, int n_threads) {
  const int width = picture.width_px(), height = picture.height_px();
  CHECK(width > 0 && height > 0);
  PictureScore score;
  with_threads(n_threads, [&] {
    std::vector<float> wanted(picture.rgb().size());
    parallel_for(height, [&](int y) {
      std::vector<float> r(static_cast<std::size_t>(width)), g(r.size()), b(r.size());
      truth.process_row(y, {r, g, b});
      float* to = &wanted[static_cast<std::size_t>(y) * r.size() * 3];
      for (std::size_t x = 0; x < r.size(); ++x) {
        *to++ = r[x];
        *to++ = g[x];
        *to++ = b[x];
      }
    });
    std::vector<double> full = differences(picture.rgb(), wanted);
    score.full_mean = mean_of(full);
    score.full_p99 = quantile(full, 0.99);
    double squares = 0;
    for (std::size_t i = 0; i < wanted.size(); ++i) {
      const double d = static_cast<double>(picture.rgb()[i] - wanted[i]);
      squares += d * d;
    }
    score.psnr_db = -10 * std::log10(std::max(squares / static_cast<double>(wanted.size()), 1e-20));
    const double sigma = 0.45 * period_px;
    std::vector<double> element = differences(blurred(picture.rgb(), width, height, sigma),
                                              blurred(wanted, width, height, sigma));
    score.element_mean = mean_of(element);
    score.element_p95 = quantile(element, 0.95);
  });
  score_patches(truth, period_px, picture.rgb(), width, height, score);
  return score;
}

}  // namespace reseau
