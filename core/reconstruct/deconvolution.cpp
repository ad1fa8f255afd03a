#include "core/reconstruct/deconvolution.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <string>

#include "core/base/check.h"
#include "core/base/error.h"

namespace reseau {
namespace {

constexpr int kGrid = 32;              // frequencies along an axis
constexpr double kLeastWeight = 1e-3;  // of the blur, over that in its middle
constexpr double kContrast = 0.15;  // of the réseau in silver, over the light: what noise drowns

// Weights of the filter that multiplies frequencies by `transfer`, cut off softly.
std::vector<float> kernel_of(const std::function<double(Vec2)>& transfer, bool positive) {
  constexpr int kRadius = SharpeningKernel::kRadius, kSide = SharpeningKernel::kSide;
  constexpr double kPi = std::numbers::pi;
  std::vector<double> weights(static_cast<std::size_t>(kSide) * kSide);
  for (int j = -kGrid / 2; j < kGrid / 2; ++j) {
    for (int i = -kGrid / 2; i < kGrid / 2; ++i) {
      const Vec2 f{(i + 0.5) / kGrid, (j + 0.5) / kGrid};
      const double t = transfer(f);
      for (int y = -kRadius; y <= kRadius; ++y) {
        for (int x = -kRadius; x <= kRadius; ++x) {
          weights[static_cast<std::size_t>(y + kRadius) * kSide +
                  static_cast<std::size_t>(x + kRadius)] +=
              t * std::cos(2 * kPi * f.x * x) * std::cos(2 * kPi * f.y * y);
        }
      }
    }
  }
  const double middle = weights[weights.size() / 2];
  double sum = 0;
  for (int y = -kRadius; y <= kRadius; ++y) {
    for (int x = -kRadius; x <= kRadius; ++x) {
      double& w = weights[static_cast<std::size_t>(y + kRadius) * kSide +
                          static_cast<std::size_t>(x + kRadius)];
      const double reach = kRadius + 1;
      w *= std::cos(kPi / 2 * x / reach) * std::cos(kPi / 2 * y / reach);
      if (positive && w < kLeastWeight * middle) w = 0;
      sum += w;
    }
  }
  std::vector<float> out;
  out.reserve(weights.size());
  for (const double w : weights) out.push_back(static_cast<float>(w / sum));
  return out;
}

}  // namespace

Deconvolution parse_deconvolution(std::string_view name) {
  for (const Deconvolution method :
       {Deconvolution::kNone, Deconvolution::kWiener, Deconvolution::kRichardsonLucy}) {
    if (deconvolution_name(method) == name) return method;
  }
  throw InputError("A deconvolution is none, wiener or richardson-lucy, not '" + std::string(name) +
                   "'.");
}

std::string_view deconvolution_name(Deconvolution method) {
  switch (method) {
    case Deconvolution::kWiener:
      return "wiener";
    case Deconvolution::kRichardsonLucy:
      return "richardson-lucy";
    case Deconvolution::kNone:
      break;
  }
  return "none";
}

SharpeningKernel::SharpeningKernel(Deconvolution method, const BlurShape& shape, double sigma_px,
                                   double noise_sd, int most_iterations)
    : method_(method) {
  CHECK(method != Deconvolution::kNone);
  // Light that goes far is an even haze: the rest of the program takes it off.
  BlurShape near = shape;
  near.far_share = 0;
  const auto blur = [&](Vec2 f) { return near.transfer(f, sigma_px); };
  if (method == Deconvolution::kWiener) {
    // The gain is largest where the transfer is the root of this.
    const double power = std::max(std::pow(noise_sd / kContrast, 2), std::pow(2 * kMostGain, -2));
    weights_ = kernel_of(
        [&](Vec2 f) {
          const double h = blur(f);
          return h * (1 + power) / (h * h + power);
        },
        false);
  } else {
    weights_ = kernel_of(blur, true);
  }
  const auto mean_gain = [this] {
    double squares = 0;
    for (int j = 0; j < kGrid / 2; ++j) {
      for (int i = 0; i < kGrid / 2; ++i)
        squares += std::pow(gain({(i + 0.5) / kGrid, (j + 0.5) / kGrid}), 2);
    }
    return std::sqrt(4 * squares) / kGrid;
  };
  if (method == Deconvolution::kRichardsonLucy) {
    do {
      ++iterations_;
      noise_gain_ = mean_gain();
    } while (iterations_ < most_iterations && noise_gain_ < kMostMeanGain);
  } else {
    noise_gain_ = mean_gain();
  }
}

double SharpeningKernel::transform(Vec2 f) const {
  constexpr double kPi = std::numbers::pi;
  double sum = 0;
  for (int y = -kRadius; y <= kRadius; ++y) {
    for (int x = -kRadius; x <= kRadius; ++x) {
      sum += static_cast<double>(weights_[static_cast<std::size_t>(y + kRadius) * kSide +
                                          static_cast<std::size_t>(x + kRadius)]) *
             std::cos(2 * kPi * f.x * x) * std::cos(2 * kPi * f.y * y);
    }
  }
  return sum;
}

double SharpeningKernel::gain(Vec2 f) const {
  const double t = transform(f);
  if (method_ == Deconvolution::kWiener) return t;
  // Each iteration adds the blurred rest of a small variation to what is there.
  double gain = 1;
  for (int i = 0; i < iterations_; ++i) gain += t * (1 - t * gain);
  return gain;
}

}  // namespace reseau
