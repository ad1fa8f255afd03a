#include "core/reconstruct/local_estimator.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Dense>

namespace reseau {
namespace {

constexpr double kAnywhere = std::numeric_limits<double>::infinity();
// The mean is unknown; around it a picture varies by so much over such distances. Only the ratios
// to each other and to the noise matter.
constexpr std::array<CovarianceTerm, 2> kBrightness{{{4.0, kAnywhere}, {0.06, 24}}};
constexpr std::array<CovarianceTerm, 2> kColor{{{1.0, kAnywhere}, {0.02, 24}}};
// Light of one colour in a blurred pixel comes from a place of its own, the part of the blur that
// the element cuts out; what remains is narrower than the blur.
constexpr double kRemainingBlur = 0.7;
constexpr double kLeastShare = 0.02;

// What a pixel of the square holds.
struct Mixture {
  std::array<double, 3> share{};
  std::array<Vec2, 3> from_px{};  // where each colour's light comes from
  double alternation = 0;         // of the line's colour along it, in deviations
};

double square_distance(Vec2 a, Vec2 b) {
  const Vec2 d = a - b;
  return dot(d, d);
}

}  // namespace

LocalEstimator::LocalEstimator(const BlurredCell& cell, const EstimatorSettings& settings)
    : cell_(cell),
      settings_(settings),
      brightness_(kBrightness, std::numbers::sqrt2 * settings.sigma_px),
      brightness_seen_(kBrightness, settings.sigma_px),
      color_(kColor, std::numbers::sqrt2 * kRemainingBlur * settings.sigma_px),
      color_seen_(kColor, kRemainingBlur * settings.sigma_px) {}

std::vector<double> LocalEstimator::weights(Vec2 middle,
                                            std::span<const EstimatorTarget> targets) const {
  const auto line = static_cast<std::size_t>(settings_.line_color);
  const int side = side_px(), radius = settings_.radius_px, n = side * side;
  const double variance = settings_.sigma_px * settings_.sigma_px;
  // Of pixel i of the square, from its middle.
  const auto place = [side, radius](int i) {
    const int column = i % side, row = i / side;
    return Vec2{static_cast<double>(column - radius), static_cast<double>(row - radius)};
  };
  std::vector<Mixture> pixels(static_cast<std::size_t>(n));
  for (int i = 0; i < n; ++i) {
    Mixture& pixel = pixels[static_cast<std::size_t>(i)];
    const Vec2 p = place(i);
    const auto shares = [&](Vec2 q) {
      const Vec2 s = middle + settings_.screen_from_scan * q;
      return cell_.shares(static_cast<float>(s.x), static_cast<float>(s.y));
    };
    const double u = middle.x + (settings_.screen_from_scan * p).x;
    constexpr double kStepPx = 0.25;
    const auto here = shares(p), left = shares(p - Vec2{kStepPx, 0}),
               right = shares(p + Vec2{kStepPx, 0}), above = shares(p - Vec2{0, kStepPx}),
               below = shares(p + Vec2{0, kStepPx});
    for (std::size_t c = 0; c < 3; ++c) {
      pixel.share[c] = static_cast<double>(here[c]);
      // The centroid of the light of a colour under a Gaussian: variance times the gradient of the
      // logarithm of its share.
      const double scale = variance / (2 * kStepPx) / std::max(pixel.share[c], kLeastShare);
      Vec2 shift{scale * (1 + settings_.stretch) * static_cast<double>(right[c] - left[c]),
                 scale * (1 - settings_.stretch) * static_cast<double>(below[c] - above[c])};
      const double most = 2 * settings_.sigma_px, length = norm(shift);
      if (length > most) shift = (most / length) * shift;
      pixel.from_px[c] = p + shift;
    }
    pixel.alternation =
        settings_.line_alternation_sd * pixel.share[line] * std::cos(2 * std::numbers::pi * u);
  }
  Eigen::MatrixXd w(n, n);
  for (int j = 0; j < n; ++j) {
    const Mixture& b = pixels[static_cast<std::size_t>(j)];
    for (int i = j; i < n; ++i) {
      const Mixture& a = pixels[static_cast<std::size_t>(i)];
      double sum = brightness_.at_square(square_distance(place(i), place(j))) +
                   a.alternation * b.alternation;
      for (std::size_t c = 0; c < 3; ++c)
        sum +=
            a.share[c] * b.share[c] * color_.at_square(square_distance(a.from_px[c], b.from_px[c]));
      w(i, j) = sum;
    }
    w(j, j) += settings_.noise_sd * settings_.noise_sd;
  }
  Eigen::MatrixXd right(n, static_cast<Eigen::Index>(targets.size()));
  for (std::size_t t = 0; t < targets.size(); ++t) {
    const auto c = static_cast<std::size_t>(targets[t].color);
    for (int i = 0; i < n; ++i) {
      const Mixture& a = pixels[static_cast<std::size_t>(i)];
      const Vec2 p = place(i);
      right(i, static_cast<Eigen::Index>(t)) =
          brightness_seen_.at_square(square_distance(p, targets[t].offset_px)) +
          a.share[c] * color_seen_.at_square(square_distance(a.from_px[c], targets[t].offset_px));
    }
  }
  // What is left of the model's own inconsistency may take more than the noise to keep positive.
  for (double more = settings_.noise_sd * settings_.noise_sd;; more *= 8) {
    const Eigen::LLT<Eigen::MatrixXd> solver(w);
    if (solver.info() == Eigen::Success) {
      solver.solveInPlace(right);
      break;
    }
    w.diagonal().array() += more;
  }
  return {right.data(), right.data() + right.size()};
}

}  // namespace reseau
