#include "calibration/edge/dense.h"

#include <cmath>

#include "core/base/check.h"

namespace reseau {

double dot(std::span<const double> a, std::span<const double> b) {
  DCHECK(a.size() == b.size());
  // Four sums, in an order that does not depend on anything.
  double s0 = 0, s1 = 0, s2 = 0, s3 = 0;
  std::size_t i = 0;
  const std::size_t n = a.size();
  for (; i + 4 <= n; i += 4) {
    s0 += a[i] * b[i];
    s1 += a[i + 1] * b[i + 1];
    s2 += a[i + 2] * b[i + 2];
    s3 += a[i + 3] * b[i + 3];
  }
  for (; i < n; ++i) s0 += a[i] * b[i];
  return (s0 + s1) + (s2 + s3);
}

void Symmetric::mirror() {
  for (std::size_t i = 0; i < n_; ++i) {
    for (std::size_t j = 0; j < i; ++j) a_[j * n_ + i] = a_[i * n_ + j];
  }
}

Cholesky::Cholesky(const Symmetric& a) : n_(a.size()), l_(n_ * n_) {
  for (std::size_t i = 0; i < n_; ++i) {
    double* li = &l_[i * n_];
    for (std::size_t j = 0; j <= i; ++j) {
      const double* lj = &l_[j * n_];
      const double rest = a(i, j) - dot({li, j}, {lj, j});
      if (j < i) {
        li[j] = rest / lj[j];
      } else {
        if (!(rest > 1e-14 * a(i, i)) || !std::isfinite(rest)) {
          ok_ = false;
          return;
        }
        li[i] = std::sqrt(rest);
      }
    }
  }
}

double Cholesky::log_determinant() const {
  double sum = 0;
  for (std::size_t i = 0; i < n_; ++i) sum += std::log(l_[i * n_ + i]);
  return 2 * sum;
}

void Cholesky::forward(std::span<double> x) const {
  for (std::size_t i = 0; i < n_; ++i) {
    const double* li = &l_[i * n_];
    x[i] = (x[i] - dot({li, i}, x.first(i))) / li[i];
  }
}

void Cholesky::backward(std::span<double> x) const {
  for (std::size_t i = n_; i-- > 0;) {
    const double* li = &l_[i * n_];
    x[i] /= li[i];
    for (std::size_t j = 0; j < i; ++j) x[j] -= li[j] * x[i];
  }
}

void Cholesky::solve(std::span<double> x) const {
  forward(x);
  backward(x);
}

}  // namespace reseau
