// Small symmetric systems, dense, in double.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace reseau {

// Symmetric n x n, both triangles stored.
class Symmetric {
 public:
  explicit Symmetric(std::size_t n = 0) : n_(n), a_(n * n) {}
  [[nodiscard]] std::size_t size() const { return n_; }
  double& operator()(std::size_t i, std::size_t j) { return a_[i * n_ + j]; }
  double operator()(std::size_t i, std::size_t j) const { return a_[i * n_ + j]; }
  [[nodiscard]] std::span<double> row(std::size_t i) { return {&a_[i * n_], n_}; }
  [[nodiscard]] std::span<const double> row(std::size_t i) const { return {&a_[i * n_], n_}; }
  // The lower triangle is copied to the upper.
  void mirror();

 private:
  std::size_t n_;
  std::vector<double> a_;
};

// L L' of a positive definite matrix, of which the lower triangle is read.
class Cholesky {
 public:
  explicit Cholesky(const Symmetric& a);
  // False when a pivot is not positive (within rounding); nothing else may be called then.
  [[nodiscard]] bool ok() const { return ok_; }
  [[nodiscard]] double log_determinant() const;
  // In place: x = A^-1 x; x = L^-1 x; x = L'^-1 x.
  void solve(std::span<double> x) const;
  void forward(std::span<double> x) const;
  void backward(std::span<double> x) const;

 private:
  std::size_t n_;
  std::vector<double> l_;  // rows of the lower triangle
  bool ok_ = true;
};

[[nodiscard]] double dot(std::span<const double> a, std::span<const double> b);

}  // namespace reseau
