#include "core/color/matrix3.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/SVD>

#include "core/base/check.h"

namespace reseau {
namespace {
using EigenMatrix3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

constexpr std::size_t at(std::size_t row, std::size_t col) { return 3 * row + col; }
}  // namespace

Vector3 multiply(const Matrix3& m, const Vector3& v) {
  Vector3 out{};
  for (std::size_t i = 0; i < 3; ++i) {
    out[i] = m[at(i, 0)] * v[0] + m[at(i, 1)] * v[1] + m[at(i, 2)] * v[2];
  }
  return out;
}

Matrix3 multiply(const Matrix3& a, const Matrix3& b) {
  Matrix3 out{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      out[at(i, j)] =
          a[at(i, 0)] * b[at(0, j)] + a[at(i, 1)] * b[at(1, j)] + a[at(i, 2)] * b[at(2, j)];
    }
  }
  return out;
}

Matrix3 scale_columns(const Matrix3& m, const Vector3& factors) {
  Matrix3 out = m;
  for (std::size_t k = 0; k < 9; ++k) {
    out[k] *= factors[k % 3];
  }
  return out;
}

Matrix3 scale(const Matrix3& m, double factor) {
  return scale_columns(m, {factor, factor, factor});
}

Vector3 column(const Matrix3& m, int index) {
  CHECK(index >= 0 && index < 3);
  const auto j = static_cast<std::size_t>(index);
  return {m[at(0, j)], m[at(1, j)], m[at(2, j)]};
}

Matrix3 from_columns(const Vector3& c0, const Vector3& c1, const Vector3& c2) {
  return {c0[0], c1[0], c2[0], c0[1], c1[1], c2[1], c0[2], c1[2], c2[2]};
}

double determinant(const Matrix3& m) {
  return m[0] * (m[4] * m[8] - m[5] * m[7]) - m[1] * (m[3] * m[8] - m[5] * m[6]) +
         m[2] * (m[3] * m[7] - m[4] * m[6]);
}

Matrix3 inverse(const Matrix3& m) {
  const double d = determinant(m);
  CHECK(std::isfinite(d) && d != 0.0);
  const Matrix3 adjugate{
      m[4] * m[8] - m[5] * m[7], m[2] * m[7] - m[1] * m[8], m[1] * m[5] - m[2] * m[4],
      m[5] * m[6] - m[3] * m[8], m[0] * m[8] - m[2] * m[6], m[2] * m[3] - m[0] * m[5],
      m[3] * m[7] - m[4] * m[6], m[1] * m[6] - m[0] * m[7], m[0] * m[4] - m[1] * m[3]};
  return scale(adjugate, 1.0 / d);
}

double condition_number(const Matrix3& m) {
  if (!std::all_of(m.begin(), m.end(), [](double v) { return std::isfinite(v); })) {
    return std::numeric_limits<double>::infinity();
  }
  const EigenMatrix3 matrix = Eigen::Map<const EigenMatrix3>(m.data());
  const auto singular = Eigen::JacobiSVD<EigenMatrix3>(matrix).singularValues();
  return singular[2] > 0 ? singular[0] / singular[2] : std::numeric_limits<double>::infinity();
}

}  // namespace reseau
