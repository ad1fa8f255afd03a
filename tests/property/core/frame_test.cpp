// A picture turned, scaled, straightened or cut out shows what the picture of the whole scan shows
// there.
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/line/memory_line_source.h"
#include "core/reconstruct/reconstruct.h"
#include "drivers/sim/simulate.h"
#include "tests/support/picture.h"

namespace reseau {
namespace {

class Frames : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    const sim::SimSpec spec = sim::parse_sim_spec(
        "ls5000?width_px=420&height_px=380&scene=natural&angle=21&bend_px=2&noise=0.001");
    scan_ = new sim::SimulatedScan(sim::simulate_frame(spec));
    source_ = new MemoryLineSource(scan_->format, scan_->samples);
    found_ = new Registration(register_screen(*source_, {}, {}, {}));
    ASSERT_TRUE(found_->found) << found_->reason;
    whole_ = new test::MemorySink(render({}, Quality::kStandard, 0));
  }
  static void TearDownTestSuite() {
    delete whole_;
    delete found_;
    delete source_;
    delete scan_;
  }

  static test::MemorySink render(const FrameChoice& frame, Quality quality, int n_threads,
                                 bool exact = false) {
    ReconstructOptions options;
    options.exact = exact;
    options.frame = frame;
    options.quality = quality;
    options.n_threads = n_threads;
    test::MemorySink sink;
    const ReconstructionReport report = reconstruct(*source_, *found_, options, sink, {}, {});
    EXPECT_TRUE(sink.ended);
    EXPECT_EQ(report.width_px, sink.width);
    for (const float value : sink.rgb) EXPECT_TRUE(std::isfinite(value));
    return sink;
  }

  // rms difference between the picture and the whole one, bilinear, where all of its pixel lies in
  // the scan.
  static double difference(const test::MemorySink& picture, const FrameChoice& choice) {
    const PictureFrame frame(choice, *found_, whole_->width, whole_->height);
    double sum = 0;
    int n = 0;
    for (int y = 0; y < picture.height; ++y) {
      for (int x = 0; x < picture.width; ++x) {
        const Vec2 p = frame.scan_from_picture(found_->map, {double(x), double(y)});
        if (p.x < 4 || p.y < 4 || p.x > whole_->width - 5 || p.y > whole_->height - 5) continue;
        const auto i = static_cast<int>(p.x), j = static_cast<int>(p.y);
        for (std::size_t c = 0; c < 3; ++c) {
          const auto at = [&](int a, int b) {
            return double{whole_->rgb[3 * (static_cast<std::size_t>(b) *
                                               static_cast<std::size_t>(whole_->width) +
                                           static_cast<std::size_t>(a)) +
                                      c]};
          };
          const double fx = p.x - i, fy = p.y - j;
          const double expected = (1 - fy) * ((1 - fx) * at(i, j) + fx * at(i + 1, j)) +
                                  fy * ((1 - fx) * at(i, j + 1) + fx * at(i + 1, j + 1));
          const double e = double{picture.rgb[3 * (static_cast<std::size_t>(y) *
                                                       static_cast<std::size_t>(picture.width) +
                                                   static_cast<std::size_t>(x)) +
                                              c]} -
                           expected;
          sum += e * e;
          ++n;
        }
      }
    }
    EXPECT_GT(n, 3000);
    return std::sqrt(sum / n);
  }

  static sim::SimulatedScan* scan_;
  static MemoryLineSource* source_;
  static Registration* found_;
  static test::MemorySink* whole_;
};

sim::SimulatedScan* Frames::scan_;
MemoryLineSource* Frames::source_;
Registration* Frames::found_;
test::MemorySink* Frames::whole_;

TEST_F(Frames, ShowWhatTheWholeShows) {
  struct Case {
    std::string name;
    FrameChoice choice;
    double bound;
  };
  const PixelBounds region{60, 50, 260, 210};
  for (const Case& c : {Case{"region", {Geometry::kScan, 1, region}, 1e-3},
                        {"half", {Geometry::kScan, 0.5, std::nullopt}, 0.002},
                        {"twice", {Geometry::kScan, 2, region}, 0.003},
                        {"film", {Geometry::kFilm, 1, std::nullopt}, 0.003},
                        {"screen", {Geometry::kScreen, 1, region}, 0.003}}) {
    const double e = difference(render(c.choice, Quality::kStandard, 0), c.choice);
    fmt::print("{}: {:.5f} rms\n", c.name, e);
    EXPECT_LT(e, c.bound) << c.name;
  }
}

TEST_F(Frames, AreTheSameForAnyThreads) {
  for (const Quality quality : {Quality::kDraft, Quality::kBest}) {
    for (const FrameChoice& choice : {FrameChoice{Geometry::kScreen, 0.7, std::nullopt},
                                      FrameChoice{Geometry::kScan, 0.2, std::nullopt}})
      EXPECT_EQ(render(choice, quality, 1).rgb, render(choice, quality, 3).rgb);
  }
}

// A preview is made of fewer pixels than the scan has, and shows what all of them would.
TEST_F(Frames, PreviewsLeaveOutWhatTheyCannotShow) {
  for (const Geometry geometry : {Geometry::kScan, Geometry::kScreen}) {
    for (const double scale : {0.25, 0.1}) {
      const FrameChoice choice{geometry, scale, std::nullopt};
      const test::MemorySink quick = render(choice, Quality::kStandard, 0),
                             exact = render(choice, Quality::kStandard, 0, true);
      ASSERT_EQ(quick.rgb.size(), exact.rgb.size());
      EXPECT_NE(quick.rgb, exact.rgb);
      double sum = 0;
      for (std::size_t i = 0; i < exact.rgb.size(); ++i) {
        const double e = double{quick.rgb[i]} - double{exact.rgb[i]};
        sum += e * e;
      }
      const double rms = std::sqrt(sum / static_cast<double>(exact.rgb.size()));
      fmt::print("{} of the size: {:.5f} rms\n", scale, rms);
      EXPECT_LT(rms, 0.003);
    }
  }
}

// Outside the scan a turned picture is black, and nothing of it is left undone.
TEST_F(Frames, AreBlackOutsideTheScan) {
  const test::MemorySink picture =
      render({Geometry::kScreen, 1, std::nullopt}, Quality::kStandard, 0);
  EXPECT_GT(picture.width, 420);
  EXPECT_EQ(picture.rgb[0], 0.0F);
  EXPECT_EQ(picture.rgb.back(), 0.0F);
}

}  // namespace
}  // namespace reseau
