#include "tests/support/edge_renderer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>

namespace reseau::test {
namespace {

using std::numbers::pi;

double box(double f, double width) {
  const double x = pi * f * width;
  return std::abs(x) < 1e-8 ? 1 - x * x / 6 : std::sin(x) / x;
}

// Autocorrelation of a circular pupil with defocus, by the midpoint rule on a square-root grid.
double pupil(double s, double w20) {
  if (s >= 1) return 0;
  if (w20 == 0) return 2 / pi * (std::acos(s) - s * std::sqrt(1 - s * s));
  constexpr int kSteps = 400;
  double sum = 0;
  const double top = 1 - s;
  for (int i = 0; i < kSteps; ++i) {
    // x = top (1 - t^2): the root at the rim of the pupil becomes smooth.
    const double t = (i + 0.5) / kSteps;
    const double x = top * (1 - t * t);
    const double u = x + s;
    sum += std::sqrt(std::max(0.0, 1 - u * u)) * std::cos(8 * pi * w20 * s * x) * 2 * t * top;
  }
  return 4 / pi * sum / kSteps;
}

struct Panel {
  std::array<double, 16> x{}, w{};
};

const Panel& panel() {
  static const Panel nodes = [] {
    // Abramowitz and Stegun, table 25.4.
    constexpr std::array<double, 8> kX = {
        0.0950125098376374, 0.2816035507792589, 0.4580167776572274, 0.6178762444026438,
        0.7554044083550030, 0.8656312023878318, 0.9445750230732326, 0.9894009349916499};
    constexpr std::array<double, 8> kW = {
        0.1894506104550685, 0.1826034150449236, 0.1691565193950025, 0.1495959888165767,
        0.1246289712555339, 0.0951585116824928, 0.0622535239386479, 0.0271524594117541};
    Panel out;
    for (std::size_t i = 0; i < 8; ++i) {
      out.x[2 * i] = 0.5 * (1 - kX[i]);
      out.x[2 * i + 1] = 0.5 * (1 + kX[i]);
      out.w[2 * i] = out.w[2 * i + 1] = 0.5 * kW[i];
    }
    return out;
  }();
  return nodes;
}

// Profile and slope, tabulated every 1/32 px.
class Profile {
 public:
  Profile(const Transfer2D& transfer, double cosine, double sine, double reach) : reach_(reach) {
    const double highest = 12;
    const double step = 1 / (2 * (reach + 2));
    std::vector<double> f, value, slope;
    double quiet = 0;
    for (double a = 0; a < highest; a += step) {
      double most = 0;
      for (std::size_t i = 0; i < 16; ++i) {
        const double at = a + step * panel().x[i];
        const double m = transfer(at * cosine, at * sine);
        most = std::max(most, std::abs(m));
        f.push_back(at);
        value.push_back(step * panel().w[i] * m / (pi * at));
        slope.push_back(2 * step * panel().w[i] * m);
      }
      quiet = most < 1e-11 ? quiet + step : 0;
      if (quiet > 0.2) break;
    }
    const auto n = static_cast<std::size_t>((reach + 1) * 32) + 2;
    e_.resize(n);
    l_.resize(n);
    for (std::size_t i = 0; i < n; ++i) {
      const double d = double(i) / 32;
      double sum = 0.5, spread = 0;
      for (std::size_t k = 0; k < f.size(); ++k) {
        const double phase = 2 * pi * f[k] * d;
        sum += value[k] * std::sin(phase);
        spread += slope[k] * std::cos(phase);
      }
      e_[i] = sum;
      l_[i] = spread;
    }
  }
  [[nodiscard]] double operator()(double d) const {
    const double at = std::min(std::abs(d), reach_) * 32;
    const auto i = static_cast<std::size_t>(at);
    const double t = at - double(i), u = 1 - t;
    const double e = (1 + 2 * t) * u * u * e_[i] + t * t * (3 - 2 * t) * e_[i + 1] +
                     (t * u * u * l_[i] - t * t * u * l_[i + 1]) / 32;
    return d >= 0 ? e : 1 - e;
  }

 private:
  double reach_;
  std::vector<double> e_, l_;
};

}  // namespace

Transfer2D gaussian_transfer(double mtf50) {
  const double k = std::numbers::ln2 / (mtf50 * mtf50);
  return [k](double x, double y) { return std::exp(-k * (x * x + y * y)); };
}

Transfer2D airy_box_transfer(double f_number, double w20) {
  const double cut_off = 4.73 / (0.55 * f_number);
  return [=](double x, double y) {
    return pupil(std::hypot(x, y) / cut_off, w20) * box(x, 1) * box(y, 1);
  };
}

Transfer2D smeared(const Transfer2D& inner, double length) {
  return [=](double x, double y) { return inner(x, y) * box(x, length); };
}

Transfer2D with_halo(const Transfer2D& inner, double share, double sigma) {
  return [=](double x, double y) {
    return (1 - share) * inner(x, y) +
           share * std::exp(-2 * pi * pi * sigma * sigma * (x * x + y * y)) * box(x, 1) * box(y, 1);
  };
}

Transfer2D sharpened(const Transfer2D& inner, double amount, double sigma) {
  return [=](double x, double y) {
    const double low = std::exp(-2 * pi * pi * sigma * sigma * (x * x + y * y));
    return inner(x, y) * (1 + amount * (1 - low));
  };
}

Transfer2D exponential_transfer(double a, double sigma) {
  return [=](double x, double y) {
    const double f2 = x * x + y * y;
    return std::exp(-2 * pi * pi * sigma * sigma * f2) / (1 + 4 * pi * pi * a * a * f2);
  };
}

void set_usual_region(EdgePicture& p, double length) {
  const double turned = std::abs(std::remainder(p.normal_deg, 90.0));
  const int across = static_cast<int>(length * std::tan(turned * pi / 180) + 72);
  const double c = std::abs(std::cos(p.normal_deg * pi / 180));
  const bool upright = c >= std::sqrt(0.5) - 1e-12;
  p.width_px = upright ? across : static_cast<int>(length);
  p.height_px = upright ? static_cast<int>(length) : across;
}

std::vector<float> render(const EdgePicture& p, const Transfer2D& transfer) {
  const double a = p.normal_deg * pi / 180;
  const double c = std::cos(a), s = std::sin(a);
  const double reach = std::hypot(p.width_px, p.height_px) / 2 + 2 + std::abs(p.bow_px);
  const Profile profile(transfer, c, s, reach);
  std::mt19937 random(p.seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform;
  const double mx = (p.width_px - 1) / 2.0, my = (p.height_px - 1) / 2.0;
  const double contrast = p.bright - p.dark;
  const double half = 0.5 * (std::abs(c) >= std::abs(s) ? p.height_px : p.width_px);
  const auto w = static_cast<std::size_t>(p.width_px), h = static_cast<std::size_t>(p.height_px);
  std::vector<double> noise(w * h);
  if (p.noise > 0) {
    for (double& v : noise) v = normal(random);
    if (p.noise_correlation > 0) {
      const double r = p.noise_correlation, keep = std::sqrt(1 - r * r);
      for (std::size_t i = 0; i < noise.size(); ++i) {
        if (i % w > 0) noise[i] = r * noise[i - 1] + keep * noise[i];
      }
      for (std::size_t i = w; i < noise.size(); ++i) noise[i] = r * noise[i - w] + keep * noise[i];
    }
  }
  std::vector<double> light(w * h);
  for (std::size_t i = 0; i < light.size(); ++i) {
    const double x = double(i % w) - mx, y = double(i / w) - my;
    const double across = c * x + s * y - p.offset_px, along = -s * x + c * y;
    double d = across;
    if (p.bow_px != 0) {
      // Nearest point of the parabola across = bow (along / half)^2.
      double u = along;
      for (int k = 0; k < 30; ++k) {
        const double q = across - p.bow_px * u * u / (half * half);
        const double slope = 2 * p.bow_px * u / (half * half);
        u = 0.5 * u + 0.5 * (along + q * slope);
      }
      const double q = across - p.bow_px * u * u / (half * half);
      d = std::copysign(std::hypot(q, along - u), q);
    }
    double v = p.dark + contrast * profile(d);
    v *= 1 + p.shade_across * across / (0.5 * p.width_px) + p.shade_along * along / half;
    light[i] = v;
  }
  for (int k = 0; k < static_cast<int>(p.dust_spots); ++k) {
    const double x0 = uniform(random) * p.width_px, y0 = uniform(random) * p.height_px;
    const double r = 1 + 2 * uniform(random), depth = 0.2 + 0.7 * uniform(random);
    for (std::size_t i = 0; i < light.size(); ++i) {
      const double d = std::hypot(double(i % w) - x0, double(i / w) - y0);
      light[i] *= 1 - depth / (1 + std::exp((d - r) / 0.4));
    }
  }
  std::vector<float> out(w * h);
  const double top = p.bright - p.clip_high * contrast;
  const double scale = std::pow(2.0, p.bits) - 1;
  for (std::size_t i = 0; i < light.size(); ++i) {
    double v = light[i] + p.noise * contrast * noise[i];
    if (p.hot_share > 0 && uniform(random) < p.hot_share) v = uniform(random);
    if (p.clip_high > 0) v = std::min(v, top);
    if (p.bits > 0) v = std::round(std::clamp(v, 0.0, 1.0) * scale) / scale;
    out[i] = static_cast<float>(v);
  }
  return out;
}

double true_transfer(const EdgePicture& p, const Transfer2D& transfer, double f) {
  const double a = p.normal_deg * pi / 180;
  return std::abs(transfer(f * std::cos(a), f * std::sin(a)));
}

double true_crossing(const EdgePicture& p, const Transfer2D& transfer, double level) {
  double f = 0;
  while (f < 2 && true_transfer(p, transfer, f + 0.002) >= level) f += 0.002;
  double low = f, high = f + 0.002;
  for (int i = 0; i < 50; ++i) {
    const double middle = 0.5 * (low + high);
    (true_transfer(p, transfer, middle) >= level ? low : high) = middle;
  }
  return low;
}

}  // namespace reseau::test
