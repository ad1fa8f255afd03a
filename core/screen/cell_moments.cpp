#include "core/screen/cell_moments.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/check.h"
#include "core/base/parallel.h"

namespace reseau {
namespace {

// Four pixels at once: arithmetic of a fixed order that every compiler turns into vectors.
using Quad = float __attribute__((vector_size(16)));
constexpr int kMostLines = 16;

double cycles(const HarmonicIndex& h, const Carriers& f, double x, double y) {
  const Vec2 u = f.harmonic_u();
  const double turns = (h.u * u.x + h.v * f.v.x) * x + (h.u * u.y + h.v * f.v.y) * y;
  return turns - std::floor(turns);
}

float total_of(Quad q) { return (q[0] + q[1]) + (q[2] + q[3]); }

template <int kQuads>
float total_of(const Quad (&values)[kQuads]) {
  Quad sum = values[0];
  for (int i = 1; i < kQuads; ++i) sum += values[i];
  return total_of(sum);
}

}  // namespace

CellGrid::CellGrid(int width_px, int height_px, Carriers carriers, CellSize size, int keep_every)
    : width_px_(width_px),
      height_px_(height_px),
      size_(size),
      keep_every_(keep_every),
      n_columns_((width_px + size.width - 1) / size.width),
      n_rows_((height_px + size.lines - 1) / size.lines),
      n_kept_((n_columns_ + 2 * keep_every - 1) / (2 * keep_every) * 2),
      carriers_(carriers) {
  CHECK(width_px > 0 && height_px > 0 && keep_every > 0);
  CHECK((size.width == 4 || size.width == 8 || size.width == 16) && size.lines > 0 &&
        size.lines <= kMostLines);
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
  fill(cos_x_, sin_x_, static_cast<std::size_t>(n_columns_) * static_cast<std::size_t>(size.width),
       true);
  fill(cos_y_, sin_y_, static_cast<std::size_t>(height_px), false);
  data_.resize(static_cast<std::size_t>(n_kept_) * static_cast<std::size_t>(n_rows_) * kStride);
}

CellGrid::CellGrid(int width_px, int height_px, Carriers carriers, const ScreenMap& along,
                   CellSize size)
    : CellGrid(width_px, height_px, carriers, size) {
  along_.resize(static_cast<std::size_t>(n_columns_) * static_cast<std::size_t>(n_rows_));
  parallel_for(n_rows_, [&](int row) {
    for (int column = 0; column < n_columns_; ++column) {
      const Vec2 p = center(column, row);
      along_[static_cast<std::size_t>(row) * static_cast<std::size_t>(n_columns_) +
             static_cast<std::size_t>(column)] = {along.screen_from_scan(p), along.jacobian(p)};
    }
  });
}

// Tables of one cell whose phase and slopes are its own.
struct CellGrid::LocalWaves {
  static constexpr std::size_t kSide = 16, kN = kDifferences.size();
  std::array<float, kN * kSide> cos_x, sin_x, cos_y, sin_y;

  LocalWaves(const Local& local, CellSize size, bool lines) {
    for (std::size_t h = 0; h < kN; ++h) {
      const double u = kDifferences[h].u, v = kDifferences[h].v;
      const auto fill = [&](std::array<float, kN * kSide>& cosines,
                            std::array<float, kN * kSide>& sines, int n, double slope,
                            double start) {
        for (int i = 0; i < n; ++i) {
          const double angle =
              2 * std::numbers::pi * std::remainder(start + slope * (i - 0.5 * (n - 1)), 1.0);
          cosines[h * kSide + static_cast<std::size_t>(i)] = static_cast<float>(std::cos(angle));
          sines[h * kSide + static_cast<std::size_t>(i)] = static_cast<float>(std::sin(angle));
        }
      };
      Mat2 j = local.jacobian;
      Vec2 screen = local.screen;
      if (lines) {
        j = {2 * j.c, 2 * j.d, j.c, j.d};
        screen = {2 * screen.y, screen.y};
      }
      fill(cos_x, sin_x, size.width, u * j.a + v * j.c, u * screen.x + v * screen.y);
      fill(cos_y, sin_y, size.lines, u * j.b + v * j.d, 0);
    }
  }
  [[nodiscard]] Waves waves() const {
    return {cos_x.data(), sin_x.data(), cos_y.data(), sin_y.data(), kSide, kSide};
  }
};

void CellGrid::accumulate(const LinearRows& rows) {
  CHECK(rows.first % size_.lines == 0 && rows.width_px == width_px_);
  for (int y = 0; y < rows.n; y += size_.lines) {
    const int n_lines = std::min(size_.lines, rows.n - y);
    const int row = (rows.first + y) / size_.lines;
    CHECK(n_lines == size_.lines || rows.first + rows.n == height_px_);
    for (int column = 0; column < n_columns_; ++column) {
      if (!kept(column)) continue;
      const auto fill = [&](const Waves& waves) {
        if (size_.width == 16) {
          accumulate_cell<4>(rows, waves, column, row, y, n_lines);
        } else if (size_.width == 8) {
          accumulate_cell<2>(rows, waves, column, row, y, n_lines);
        } else {
          accumulate_cell<1>(rows, waves, column, row, y, n_lines);
        }
      };
      if (!along_.empty()) {
        fill(LocalWaves(local(column, row), size_, carriers_.lines).waves());
        continue;
      }
      const auto x0 = static_cast<std::size_t>(column) * static_cast<std::size_t>(size_.width);
      const auto first = static_cast<std::size_t>(rows.first) + static_cast<std::size_t>(y);
      fill({&cos_x_[x0], &sin_x_[x0], &cos_y_[first], &sin_y_[first],
            static_cast<std::size_t>(n_columns_) * static_cast<std::size_t>(size_.width),
            static_cast<std::size_t>(height_px_)});
    }
  }
}

// Along y each harmonic is one complex number per line, along x a table: first the lines of a cell
// are summed pixel column by pixel column, then the columns.
template <int kQuads>
void CellGrid::accumulate_cell(const LinearRows& rows, const Waves& waves, int column, int row,
                               int y0, int n_lines) {
  constexpr int kWidth = 4 * kQuads;
  constexpr std::size_t kN = kDifferences.size();
  // S^2, S R, S G, S B of every pixel.
  alignas(16) float product[4][kMostLines][kWidth];
  alignas(16) float square[3][kWidth] = {};
  alignas(16) float count[kWidth] = {};
  const int x0 = column * kWidth;
  const int n_pixels = std::min(kWidth, width_px_ - x0);
  for (int line = 0; line < n_lines; ++line) {
    const float* s = rows.row(3, y0 + line) + x0;
    float* s2 = product[0][line];
    if (n_pixels < kWidth) {
      for (auto& plane : product) std::fill_n(plane[line], kWidth, 0.0F);
    }
    for (int x = 0; x < n_pixels; ++x) {
      s2[x] = s[x] * s[x];
      count[x] += s[x] > 0 ? 1.0F : 0.0F;
    }
    for (int c = 0; c < 3; ++c) {
      const float* value = rows.row(c, y0 + line) + x0;
      for (int x = 0; x < n_pixels; ++x) {
        product[c + 1][line][x] = s[x] * value[x];
        square[c][x] += s[x] > 0 ? value[x] * value[x] : 0.0F;
      }
    }
  }
  const auto quads_of = [](const float* values) { return reinterpret_cast<const Quad*>(values); };
  // The sum of one plane under one harmonic; `sign` turns the table into its conjugate.
  const auto plain = [&](int k) {
    Quad sum[kQuads] = {};
    for (int line = 0; line < n_lines; ++line) {
      const Quad* p = quads_of(product[k][line]);
      for (int i = 0; i < kQuads; ++i) sum[i] += p[i];
    }
    return total_of<kQuads>(sum);
  };
  float* out = &data_[index(column, row)];
  const auto under = [&](int k, std::size_t h, float sign) {
    Quad re[kQuads] = {}, im[kQuads] = {};
    const float* cos_y = waves.cos_y + h * waves.stride_y;
    const float* sin_y = waves.sin_y + h * waves.stride_y;
    for (int line = 0; line < n_lines; ++line) {
      const Quad* p = quads_of(product[k][line]);
      const float cosine = cos_y[line], sine = sin_y[line];
      for (int i = 0; i < kQuads; ++i) {
        re[i] += p[i] * cosine;
        im[i] += p[i] * sine;
      }
    }
    const float* cos_x = waves.cos_x + h * waves.stride_x;
    const float* sin_x = waves.sin_x + h * waves.stride_x;
    Quad sum_re = {}, sum_im = {};
    for (int i = 0; i < kQuads; ++i) {
      Quad c, s;
      for (int j = 0; j < 4; ++j) {
        c[j] = cos_x[4 * i + j];
        s[j] = sin_x[4 * i + j];
      }
      sum_re += re[i] * c - im[i] * s;
      sum_im += im[i] * c + re[i] * s;
    }
    *out++ = total_of(sum_re);
    *out++ = sign * total_of(sum_im);
  };
  *out++ = plain(0);
  for (std::size_t h = 0; h < kN; ++h) under(0, h, 1.0F);
  for (int c = 0; c < 3; ++c) *out++ = plain(c + 1);
  for (int c = 0; c < 3; ++c) {
    for (std::size_t h = 0; h < kSeries; ++h) under(c + 1, h, -1.0F);  // r holds conj(E)
  }
  const auto sum_of = [](const float* values) {
    float sum = 0;
    for (int x = 0; x < kWidth; ++x) sum += values[x];
    return sum;
  };
  for (const auto& values : square) *out++ = sum_of(values);
  *out = sum_of(count);
}

Moments CellGrid::cell(int column, int row) const {
  CHECK(kept(column));
  const float* in = &data_[index(column, row)];
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

std::array<double, 3> CellGrid::color_light(int column, int row) const {
  const float* in = &data_[index(column, row)] + 1 + 2 * kDifferences.size();
  return {static_cast<double>(in[0]), static_cast<double>(in[1]), static_cast<double>(in[2])};
}

double CellGrid::filled(int column, int row) const {
  if (!kept(column)) return 0;
  const int width = std::min(size_.width, width_px_ - column * size_.width);
  const int lines = std::min(size_.lines, height_px_ - row * size_.lines);
  return static_cast<double>(data_[index(column, row) + kStride - 1]) / (width * lines);
}

}  // namespace reseau
