#include "core/screen/cell_moments.h"

#include <cmath>
#include <numbers>

#include "core/base/check.h"

namespace reseau {
namespace {

double cycles(const HarmonicIndex& h, const Carriers& f, double x, double y) {
  const double turns = (h.u * f.u.x + h.v * f.v.x) * x + (h.u * f.u.y + h.v * f.v.y) * y;
  return turns - std::floor(turns);
}

}  // namespace

CellGrid::CellGrid(int width_px, int height_px, Carriers carriers)
    : width_px_(width_px),
      height_px_(height_px),
      n_columns_((width_px + kCellPx - 1) / kCellPx),
      n_rows_((height_px + kCellPx - 1) / kCellPx),
      carriers_(carriers) {
  CHECK(width_px > 0 && height_px > 0);
  const auto fill = [&](std::vector<float>& cosines, std::vector<float>& sines, std::size_t n,
                        bool along_x) {
    cosines.resize(kDifferences.size() * n);
    sines.resize(kDifferences.size() * n);
    for (std::size_t h = 0; h < kDifferences.size(); ++h) {
      for (std::size_t i = 0; i < n; ++i) {
        const auto at = static_cast<double>(i);
        const double angle = 2 * std::numbers::pi *
                             cycles(kDifferences[h], carriers, along_x ? at : 0, along_x ? 0 : at);
        cosines[h * n + i] = static_cast<float>(std::cos(angle));
        sines[h * n + i] = static_cast<float>(std::sin(angle));
      }
    }
  };
  fill(cos_x_, sin_x_, static_cast<std::size_t>(n_columns_) * kCellPx, true);
  fill(cos_y_, sin_y_, static_cast<std::size_t>(height_px), false);
  data_.resize(static_cast<std::size_t>(n_columns_) * static_cast<std::size_t>(n_rows_) * kStride);
}

void CellGrid::accumulate(const LinearRows& rows) {
  CHECK(rows.first % kCellPx == 0 && rows.width_px == width_px_);
  for (int y = 0; y < rows.n; y += kCellPx) {
    const int n_lines = std::min(kCellPx, rows.n - y);
    const int row = (rows.first + y) / kCellPx;
    CHECK(n_lines == kCellPx || rows.first + rows.n == height_px_);
    for (int column = 0; column < n_columns_; ++column) {
      accumulate_cell(rows, column, row, y, n_lines);
    }
  }
}

// Along y each harmonic is one complex number per line, along x a table: the inner loops multiply
// 16 pixels by a scalar, which compilers turn into vectors without reordering any sum.
void CellGrid::accumulate_cell(const LinearRows& rows, int column, int row, int y0, int n_lines) {
  constexpr std::size_t kN = kDifferences.size();
  constexpr std::size_t kSums = kN + 3 * kSeries;
  alignas(64) float re[kSums][kCellPx] = {};
  alignas(64) float im[kSums][kCellPx] = {};
  alignas(64) float plain[8][kCellPx] = {};  // S^2, S X_c, X_c^2, count
  const int x0 = column * kCellPx;
  const int n_pixels = std::min(kCellPx, width_px_ - x0);
  for (int line = 0; line < n_lines; ++line) {
    alignas(64) float product[4][kCellPx] = {};  // S^2, S X_c
    const float* s = rows.row(3, y0 + line) + x0;
    for (int x = 0; x < n_pixels; ++x) {
      product[0][x] = s[x] * s[x];
      plain[7][x] += s[x] > 0 ? 1.0F : 0.0F;
    }
    for (int c = 0; c < 3; ++c) {
      const float* value = rows.row(c, y0 + line) + x0;
      for (int x = 0; x < n_pixels; ++x) {
        product[c + 1][x] = s[x] * value[x];
        plain[c + 4][x] += s[x] > 0 ? value[x] * value[x] : 0.0F;
      }
    }
    for (int k = 0; k < 4; ++k) {
      for (int x = 0; x < kCellPx; ++x) plain[k][x] += product[k][x];
    }
    const int y_px = rows.first + y0 + line;
    const auto y = static_cast<std::size_t>(y_px);
    for (std::size_t h = 0; h < kN; ++h) {
      const float cosine = cos_y_[h * static_cast<std::size_t>(height_px_) + y];
      const float sine = sin_y_[h * static_cast<std::size_t>(height_px_) + y];
      for (int x = 0; x < kCellPx; ++x) {
        re[h][x] += product[0][x] * cosine;
        im[h][x] += product[0][x] * sine;
      }
      if (h >= kSeries) continue;
      for (std::size_t c = 0; c < 3; ++c) {
        for (int x = 0; x < kCellPx; ++x) {
          re[kN + c * kSeries + h][x] += product[c + 1][x] * cosine;
          im[kN + c * kSeries + h][x] -= product[c + 1][x] * sine;
        }
      }
    }
  }
  const auto total = [](const float* values) {
    float sum = 0;
    for (int x = 0; x < kCellPx; ++x) sum += values[x];
    return sum;
  };
  const std::size_t padded = static_cast<std::size_t>(n_columns_) * kCellPx;
  float* out = &data_[(static_cast<std::size_t>(row) * static_cast<std::size_t>(n_columns_) +
                       static_cast<std::size_t>(column)) *
                      kStride];
  *out++ = total(plain[0]);
  for (std::size_t i = 0; i < kSums; ++i) {
    if (i == kN) {
      for (int c = 0; c < 3; ++c) *out++ = total(plain[c + 1]);
    }
    const std::size_t h = i < kN ? i : (i - kN) % kSeries;
    const float* cosine = &cos_x_[h * padded + static_cast<std::size_t>(x0)];
    const float* sine = &sin_x_[h * padded + static_cast<std::size_t>(x0)];
    const float sign = i < kN ? 1.0F : -1.0F;  // r holds the conjugate of E
    float sum_re = 0, sum_im = 0;
    for (int x = 0; x < kCellPx; ++x) {
      sum_re += re[i][x] * cosine[x] - sign * im[i][x] * sine[x];
      sum_im += im[i][x] * cosine[x] + sign * re[i][x] * sine[x];
    }
    *out++ = sum_re;
    *out++ = sum_im;
  }
  for (int c = 0; c < 3; ++c) *out++ = total(plain[c + 4]);
  *out = total(plain[7]);
}

Moments CellGrid::cell(int column, int row) const {
  const float* in = &data_[(static_cast<std::size_t>(row) * static_cast<std::size_t>(n_columns_) +
                            static_cast<std::size_t>(column)) *
                           kStride];
  Moments m;
  const auto next = [&in] { return static_cast<double>(*in++); };
  const auto next_complex = [&next] {
    const double real = next();
    return std::complex<double>(real, next());
  };
  m.n0 = next();
  for (auto& value : m.n) value = next_complex();
  for (auto& value : m.r0) value = next();
  for (auto& channel : m.r) {
    for (auto& value : channel) value = next_complex();
  }
  for (auto& value : m.q) value = next();
  m.pixels = next();
  return m;
}

double CellGrid::light(int column, int row) const {
  return static_cast<double>(
      data_[(static_cast<std::size_t>(row) * static_cast<std::size_t>(n_columns_) +
             static_cast<std::size_t>(column)) *
            kStride]);
}

}  // namespace reseau
