#include "capture/cli/quality_plot.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "capture/color/svg.h"

namespace reseau::cli {
namespace {

constexpr double kWidth = 720, kHeight = 480;
constexpr std::array<const char*, 4> kColors{"#1b6ca8", "#c1440e", "#4a7c2f", "#6b4c9a"};

// 1, 2 or 5 times a power of ten, about a sixth of the range.
double step_of(double range) {
  const double least = range / 6, power = std::pow(10.0, std::floor(std::log10(least)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= least) return factor * power;
  }
  return 10 * power;
}

}  // namespace

std::vector<QualityMean> quality_means(const std::vector<QualityPoint>& points) {
  std::vector<QualityMean> means;
  std::vector<int> n;
  for (const QualityPoint& point : points) {
    const auto at = std::ranges::find(means, point.quality, &QualityMean::quality);
    const auto i = static_cast<std::size_t>(at - means.begin());
    if (at == means.end()) {
      means.push_back({point.quality, 0, 0, false});
      n.push_back(0);
    }
    means[i].seconds += point.seconds;
    means[i].delta_e += point.delta_e;
    ++n[i];
  }
  for (std::size_t i = 0; i < means.size(); ++i) {
    means[i].seconds /= n[i];
    means[i].delta_e /= n[i];
  }
  for (QualityMean& mean : means) {
    mean.on_front = std::ranges::none_of(means, [&](const QualityMean& other) {
      return other.seconds <= mean.seconds && other.delta_e <= mean.delta_e &&
             (other.seconds < mean.seconds || other.delta_e < mean.delta_e);
    });
  }
  return means;
}

std::string quality_plot(const std::vector<QualityPoint>& points) {
  SvgPage page(kWidth, kHeight);
  page.rectangle({0, 0}, kWidth, kHeight, "#ffffff");
  page.text({70, 28}, "Time against error of one megapixel", 16);
  double most_s = 0.01, most_e = 0.1;
  for (const QualityPoint& point : points) {
    most_s = std::max(most_s, point.seconds);
    most_e = std::max(most_e, point.delta_e);
  }
  const double step_s = step_of(most_s), step_e = step_of(most_e);
  const double top_s = step_s * std::ceil(1.05 * most_s / step_s),
               top_e = step_e * std::ceil(1.05 * most_e / step_e);
  const PlotArea area({70, 50}, kWidth - 110, kHeight - 120, {0, 0}, {top_s, top_e});
  const auto decimals = [](double step) {
    return std::max(0, static_cast<int>(std::ceil(-std::log10(step) - 1e-9)));
  };
  area.draw_axes(page, {step_s, step_e}, std::max(decimals(step_s), decimals(step_e)),
                 "processor time [s], registration included", "CIEDE2000 at the scale of elements");
  std::vector<QualityMean> means = quality_means(points);
  for (std::size_t q = 0; q < means.size(); ++q) {
    const char* const color = kColors[q % kColors.size()];
    for (const QualityPoint& point : points) {
      if (point.quality == means[q].quality)
        page.dot(area.at(point.seconds, point.delta_e), 2.5, color);
    }
    const Vec2 at = area.at(means[q].seconds, means[q].delta_e);
    page.dot(at, 6, color);
    page.text(at + Vec2{10, -8},
              fmt::format("{}{}", means[q].quality, means[q].on_front ? "" : " (not on the front)"),
              13, SvgPage::Anchor::kStart, color);
  }
  std::erase_if(means, [](const QualityMean& mean) { return !mean.on_front; });
  std::ranges::sort(means, {}, &QualityMean::seconds);
  std::vector<Vec2> front;
  front.reserve(means.size());
  for (const QualityMean& mean : means) front.push_back(area.at(mean.seconds, mean.delta_e));
  if (front.size() > 1) page.path(front, {"#333333", 1.5, "5 3"});
  return page.str();
}

}  // namespace reseau::cli
