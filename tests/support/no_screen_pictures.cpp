#include "tests/support/no_screen_pictures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <vector>

namespace reseau::test {
namespace {

using Color = std::array<double, 3>;
using Paint = std::function<Color(double, double)>;
constexpr double kTurn = 2 * std::numbers::pi;

struct Random {
  std::mt19937_64 engine;
  double operator()(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine);
  }
  Color color() { return {(*this)(0.05, 0.95), (*this)(0.05, 0.95), (*this)(0.05, 0.95)}; }
};

Color mixed(const Color& a, const Color& b, double t) {
  return {a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]), a[2] + t * (b[2] - a[2])};
}

double wave(double x) { return 0.5 + 0.5 * std::sin(kTurn * x); }

// Waves of all sizes with 1/f amplitudes, colours that vary together, and a few objects with edges.
Paint nature(Random& random) {
  struct Wave {
    double fx, fy, phase, size;
    Color tint;
  };
  std::vector<Wave> waves;
  for (int i = 0; i < 60; ++i) {
    const double f = std::pow(10.0, random(-2.6, -0.5)), a = random(0, kTurn);
    waves.push_back({f * std::cos(a), f * std::sin(a), random(0, 1),
                     0.0035 * std::pow(f, -0.75) * random(0.3, 1), random.color()});
  }
  struct Ball {
    double x, y, r;
    Color color;
  };
  std::vector<Ball> balls;
  for (int i = 0; i < 12; ++i)
    balls.push_back({random(0, 400), random(0, 400), random(10, 90), random.color()});
  const Color base = random.color();
  return [=](double x, double y) {
    Color color = base;
    for (const Ball& ball : balls) {
      if (std::hypot(x - ball.x, y - ball.y) < ball.r) color = ball.color;
    }
    for (const Wave& w : waves) {
      const double value = w.size * std::sin(kTurn * (w.fx * x + w.fy * y + w.phase));
      for (std::size_t c = 0; c < 3; ++c) color[c] += value * (0.6 + 0.8 * w.tint[c]);
    }
    return color;
  };
}

// Bricks, checks, waves, rings, a lattice fence: one or two periods, few colours.
Paint texture(Random& random, int number) {
  const double period = random(3.5, 30), a = random(0, kTurn);
  const double cosine = std::cos(a) / period, sine = std::sin(a) / period;
  const Color one = random.color(), two = random.color(), three = random.color();
  return [=](double x, double y) -> Color {
    const double u = cosine * x + sine * y, v = -sine * x + cosine * y;
    switch (number % 5) {
      case 0: {  // bricks
        const double row = std::floor(v), at = u / 2.2 + 0.5 * std::fmod(std::abs(row), 2.0);
        const bool mortar = v - row < 0.15 || at - std::floor(at) < 0.07;
        return mortar ? one : mixed(two, three, wave(17.3 * row + 5.1 * std::floor(at)));
      }
      case 1:
        return (static_cast<long>(std::floor(u)) + static_cast<long>(std::floor(v))) % 2 == 0 ? one
                                                                                              : two;
      case 2:
        return mixed(one, two, wave(u + 0.6 * std::sin(v / 3)));
      case 3:
        return mixed(one, two, wave(std::hypot(x - 150, y - 190) / period));
      default:
        return u - std::floor(u) < 0.25 || v - std::floor(v) < 0.25
                   ? one
                   : mixed(two, three, wave(y / 90));
    }
  };
}

// Cyan, magenta, yellow and black dots, each ink on a screen of its own angle.
Paint halftone(Random& random, int number) {
  const double ruling = random(3.2, 16), turned = random(-10, 10);
  constexpr std::array<double, 4> kUsual{15, 75, 0, 45};
  const bool same_angle = number % 7 == 6;  // a cheap print: all inks on one screen
  const Color where{random(60, 200), random(60, 200), random(60, 200)};
  return [=](double x, double y) {
    Color color{0.93, 0.92, 0.88};
    for (std::size_t ink = 0; ink < 4; ++ink) {
      const double a = ((same_angle ? 45 : kUsual[ink]) + turned) * kTurn / 360;
      const double u = (std::cos(a) * x + std::sin(a) * y) / ruling,
                   v = (-std::sin(a) * x + std::cos(a) * y) / ruling;
      const double tone = ink == 3 ? 0.15 : 0.15 + 0.7 * wave(x / (2 * where[ink]) + y / 310.0);
      const double dot = 0.25 * (2 + std::cos(kTurn * u) + std::cos(kTurn * v));
      const double covered = std::clamp((tone - dot) * 6 + 0.5, 0.0, 1.0);
      for (std::size_t c = 0; c < 3; ++c)
        color[c] *= 1 - covered * (ink == 3 || c == ink ? 0.9 : 0.08);
    }
    return color;
  };
}

// Plain weave, twill and tartan of coloured threads, light and shade on every thread.
Paint fabric(Random& random, int number) {
  const double thread = random(1.6, 7), a = random(0, kTurn);
  std::vector<Color> warp, weft;
  const int n = 1 + number % 4 * 2;
  for (int i = 0; i < n; ++i) {
    warp.push_back(random.color());
    weft.push_back(number % 3 == 0 ? warp.back() : random.color());
  }
  const int float_over = 1 + number % 3;
  return [=](double x, double y) {
    const double u = (std::cos(a) * x + std::sin(a) * y) / thread + 1000,
                 v = (-std::sin(a) * x + std::cos(a) * y) / thread + 1000;
    const auto i = static_cast<std::size_t>(std::floor(u)),
               j = static_cast<std::size_t>(std::floor(v));
    const bool over = (i + j) % static_cast<std::size_t>(1 + float_over) == 0;
    const Color& color = over ? warp[i / 4 % warp.size()] : weft[j / 4 % weft.size()];
    const double across = over ? u - std::floor(u) : v - std::floor(v);
    const double light = 0.55 + 0.45 * std::sin(std::numbers::pi * across);
    return Color{light * color[0], light * color[1], light * color[2]};
  };
}

}  // namespace

NoScreenPicture no_screen_picture(NoScreen kind, int number, int side_px) {
  Random random{std::mt19937_64(static_cast<std::uint64_t>(number) * 4 +
                                static_cast<std::uint64_t>(kind) + 1)};
  Paint paint;
  std::string name;
  switch (kind) {
    case NoScreen::kNature:
      paint = nature(random);
      name = "nature";
      break;
    case NoScreen::kTexture:
      paint = texture(random, number);
      name = "texture";
      break;
    case NoScreen::kHalftone:
      paint = halftone(random, number);
      name = "halftone";
      break;
    case NoScreen::kFabric:
      paint = fabric(random, number);
      name = "fabric";
      break;
  }
  const bool infrared = number % 3 != 2;
  LineFormat format;
  format.width_px = format.n_lines = side_px;
  format.x_dpi = format.y_dpi = 4000;
  format.channels = {Channel::kRed, Channel::kGreen, Channel::kBlue};
  if (infrared) format.channels.push_back(Channel::kInfrared);
  const auto side = static_cast<std::size_t>(side_px), planes = format.channels.size();
  std::vector<std::uint16_t> samples(side * side * planes);
  std::normal_distribution<double> noise(0, 0.004);
  for (std::size_t y = 0; y < side; ++y) {
    for (std::size_t x = 0; x < side; ++x) {
      Color sum{};
      for (int s = 0; s < 4; ++s) {
        const Color c = paint(static_cast<double>(x) + 0.5 * (s % 2) - 0.25,
                              static_cast<double>(y) + (s < 2 ? -0.25 : 0.25));
        for (std::size_t k = 0; k < 3; ++k) sum[k] += 0.25 * std::clamp(c[k], 0.0, 1.0);
      }
      for (std::size_t k = 0; k < planes; ++k) {
        // Dyes let infrared pass.
        const double value = (k < 3 ? 0.02 + 0.85 * sum[k] : 0.85) + noise(random.engine);
        samples[(y * planes + k) * side + x] =
            static_cast<std::uint16_t>(std::lround(65535 * std::clamp(value, 0.0, 1.0)));
      }
    }
  }
  return {name + " " + std::to_string(number), MemoryLineSource(format, std::move(samples))};
}

}  // namespace reseau::test
