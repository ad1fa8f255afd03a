#include "capture/cli/speed_plot.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include <fmt/format.h>

#include "capture/color/svg.h"

namespace reseau::cli {
namespace {

constexpr double kPageWidth = 720, kPageHeight = 480;
constexpr std::array<const char*, 4> kLineColors{"#1b6ca8", "#c1440e", "#4a7c2f", "#6b4c9a"};

}  // namespace

std::string speed_plot(const std::vector<SpeedPoint>& points) {
  SvgPage page(kPageWidth, kPageHeight);
  page.rectangle({0, 0}, kPageWidth, kPageHeight, "#ffffff");
  page.text({70, 28}, "What a picture takes", 16);
  std::map<std::pair<std::string, int>, std::vector<Vec2>> lines;
  Vec2 low{0, 0}, high{1, 1};
  for (const SpeedPoint& point : points) {
    const Vec2 at{std::log10(point.megapixels), std::log10(std::max(point.seconds, 1e-3))};
    lines[{point.quality, point.n_threads}].push_back(at);
    low = {std::min(low.x, std::floor(at.x)), std::min(low.y, std::floor(at.y))};
    high = {std::max(high.x, std::ceil(at.x)), std::max(high.y, std::ceil(at.y))};
  }
  const PlotArea area({70, 50}, kPageWidth - 240, kPageHeight - 120, low, high);
  area.draw_axes(page, {1, 1}, 0, "log10 of megapixels", "log10 of seconds");
  std::size_t color = 0;
  double words_y = 70;
  for (auto& [name, line] : lines) {
    std::ranges::sort(line, {}, &Vec2::x);
    std::vector<Vec2> path;
    path.reserve(line.size());
    for (const Vec2& at : line) path.push_back(area.at(at.x, at.y));
    const char* const stroke = kLineColors[color++ / 2 % kLineColors.size()];
    page.path(path, {stroke, 1.5, name.second == 1 ? "" : "5 3"});
    for (const Vec2& at : path) page.dot(at, 3, stroke);
    page.text({kPageWidth - 160, words_y},
              fmt::format("{}, {}", name.first,
                          name.second == 0   ? std::string("all cores")
                          : name.second == 1 ? std::string("1 thread")
                                             : fmt::format("{} threads, dashed", name.second)),
              12, SvgPage::Anchor::kStart, stroke);
    words_y += 20;
  }
  return page.str();
}

}  // namespace reseau::cli
