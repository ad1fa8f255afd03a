#include "core/reconstruct/silver_from_rgb.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Dense>

namespace reseau {
namespace {

constexpr double kMostPixels = 2.5e5;
constexpr std::size_t kFewestPixels = 100;
constexpr std::uint16_t kFullScale = 65535;
// Pixels darker than this share of the mean weigh no more: there infrared is noise.
constexpr double kDarkest = 0.05;
// Of the normalised normal equations: beyond it the channels carry the same picture.
constexpr double kWorstCondition = 1e8;

using Row4 = Eigen::Vector4d;  // 1, red, green, blue

struct Sample {
  Row4 x;
  double infrared = 0;
};

std::vector<Sample> take_samples(const LineSource& source, const ToneCurves& tone,
                                 const std::array<std::size_t, 4>& plane,
                                 const std::stop_token& stop) {
  const LineFormat& format = source.format();
  const auto width = static_cast<std::size_t>(format.width_px);
  const double n_pixels = static_cast<double>(width) * format.n_lines;
  const auto step = std::max<std::size_t>(
      1, static_cast<std::size_t>(std::ceil(std::sqrt(n_pixels / kMostPixels))));
  std::vector<std::uint16_t> line(format.samples_per_line());
  std::vector<Sample> samples;
  for (std::size_t y = step / 2; y < static_cast<std::size_t>(format.n_lines); y += step) {
    if (stop.stop_requested()) return {};
    source.read(static_cast<int>(y), 1, line);
    for (std::size_t x = step / 2; x < width; x += step) {
      std::array<double, 4> v{};
      bool clipped = false;
      for (std::size_t c = 0; c < 4; ++c) {
        const std::uint16_t raw = line[plane[c] * width + x];
        clipped |= raw == kFullScale;
        v[c] = double{tone.table(static_cast<int>(c))[raw]};
      }
      if (!clipped) samples.push_back({{1, v[0], v[1], v[2]}, v[3]});
    }
  }
  return samples;
}

}  // namespace

std::optional<LearnedSilver> learn_silver_from_rgb(const LineSource& source, const ToneCurves& tone,
                                                   const std::stop_token& stop) {
  constexpr std::array kOrder{Channel::kRed, Channel::kGreen, Channel::kBlue, Channel::kInfrared};
  std::array<std::size_t, 4> plane{};
  for (std::size_t c = 0; c < 4; ++c) {
    const int index = source.format().plane_of(kOrder[c]);
    if (index < 0) return std::nullopt;
    plane[c] = static_cast<std::size_t>(index);
  }
  const std::vector<Sample> samples = take_samples(source, tone, plane, stop);
  if (samples.size() < kFewestPixels) return std::nullopt;
  double mean = 0;
  for (const Sample& s : samples) mean += s.infrared;
  mean /= static_cast<double>(samples.size());
  if (!(mean > 0)) return std::nullopt;

  Eigen::Matrix4d a = Eigen::Matrix4d::Zero();
  Row4 b = Row4::Zero();
  for (const Sample& s : samples) {
    const double weight = 1 / std::max(s.infrared, kDarkest * mean);
    a += weight * s.x * s.x.transpose();
    b += weight * s.infrared * s.x;
  }
  const Row4 scale = a.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::Matrix4d normal = scale.asDiagonal() * a * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> eigen(normal);
  if (!(eigen.eigenvalues()(3) < kWorstCondition * eigen.eigenvalues()(0))) return std::nullopt;
  const Row4 w = scale.asDiagonal() * normal.ldlt().solve(scale.asDiagonal() * b);
  if (!w.allFinite()) return std::nullopt;

  LearnedSilver learned;
  learned.silver = {{w(1), w(2), w(3)}, w(0)};
  learned.n_pixels = samples.size();
  double sum_p = 0, sum_pp = 0, sum_tt = 0, sum_pt = 0, squares = 0;
  for (const Sample& s : samples) {
    const double p = w.dot(s.x), t = s.infrared - mean;
    sum_p += p;
    sum_pp += p * p;
    sum_tt += t * t;
    sum_pt += p * t;
    squares += (p - s.infrared) * (p - s.infrared);
  }
  const auto n = static_cast<double>(samples.size());
  const double variances = (sum_pp - sum_p * sum_p / n) * sum_tt;
  learned.correlation = variances > 0 ? sum_pt / std::sqrt(variances) : 0;
  learned.rms_relative = std::sqrt(squares / n) / mean;
  return learned;
}

}  // namespace reseau
