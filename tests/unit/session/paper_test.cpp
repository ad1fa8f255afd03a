// The paper's figures as a report that fails outside its limits.
#include "capture/color/paper.h"

#include <cmath>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture/color/color_plots.h"
#include "capture/color/paper_tables.h"
#include "capture/color/svg.h"
#include "core/color/set_difference.h"

namespace reseau {
namespace {

using testing::HasSubstr;

const PaperReport& paper() {
  static const PaperReport report = make_paper();
  return report;
}

const PaperFigure& figure(const PaperReport& report, const std::string& part,
                          const std::string& what) {
  for (const PaperFigure& f : report.figures) {
    if (f.part == part && f.what.find(what) != std::string::npos) return f;
  }
  ADD_FAILURE() << "no figure " << part << ": " << what;
  return report.figures.front();
}

TEST(Paper, EveryLimitOnPrintedFiguresHolds) {
  EXPECT_TRUE(paper().held()) << paper_text(paper());
  std::set<std::string> limited;
  for (const PaperFigure& f : paper().figures) {
    EXPECT_TRUE(std::isfinite(f.ours)) << f.what;
    if (!f.limit.empty()) limited.insert(f.part);
  }
  EXPECT_EQ(limited, (std::set<std::string>{"areas", "tab2", "tab3", "tab4"}));
}

TEST(Paper, FiguresThatDoNotRecomputeSayWhy) {
  EXPECT_NEAR(figure(paper(), "tab2", "green about E, locus of 5").ours, 534.52, 0.01);
  EXPECT_THAT(figure(paper(), "tab2", "green about E, locus of 5").remark, HasSubstr("0.33"));
  EXPECT_THAT(figure(paper(), "tab1", "green about E").remark, HasSubstr("does not recompute"));
  EXPECT_THAT(figure(paper(), "tab1", "blue about E").remark, HasSubstr("does not recompute"));
  EXPECT_NEAR(figure(paper(), "tab1", "one white leaves").ours, 9.8, 0.05);
  EXPECT_THAT(figure(paper(), "claims", "largest mean of the three").remark, HasSubstr("1.30"));
  EXPECT_NEAR(figure(paper(), "tab1", "Cornwell-Clyne's green curve").ours, 549.3, 0.05);
}

TEST(Paper, TextAndCsvHoldEveryFigure) {
  const std::string text = paper_text(paper()), csv = paper_csv(paper());
  std::size_t lines = 0;
  for (const char c : csv) lines += c == '\n' ? 1 : 0;
  EXPECT_EQ(lines, paper().figures.size() + 1);
  for (const PaperFigure& f : paper().figures) EXPECT_THAT(text, HasSubstr(f.what));
}

TEST(Paper, ADeviationFailsTheReport) {
  PaperReport report = paper();
  ASSERT_TRUE(report.held());
  report.figures.front().held = false;
  EXPECT_FALSE(report.held());
  EXPECT_THAT(paper_text(report), HasSubstr("NOT HELD"));
  EXPECT_THAT(paper_csv(report), HasSubstr(",no,"));
}

TEST(PaperOfScan, LimitsAreOnTheComparedReconstructionOnly) {
  // The scene that stands for Fig. 6 has about the colours of the crop; doubled saturation has not.
  const std::vector<Vector3> scene = stated_colors("warm");
  std::vector<Vector3> loud = scene;
  for (Vector3& v : loud) {
    const double grey = (v[0] + v[1] + v[2]) / 3;
    for (double& c : v) c = std::max(0.0, grey + 3 * (c - grey));
  }
  const PaperReport far = paper_of_scan(loud, scene, "as said");
  EXPECT_FALSE(far.held());
  EXPECT_THAT(paper_text(far), HasSubstr("as said"));
  for (const PaperFigure& f : far.figures) {
    if (f.part != "scan-own") continue;
    EXPECT_TRUE(f.held && f.limit.empty()) << f.what;
  }
  bool said = false;
  for (const PaperFigure& f : paper_of_scan(scene, loud, "").figures) {
    said |= f.part == "scan-own" && f.remark.find("beyond the 1.5") != std::string::npos;
  }
  EXPECT_TRUE(said);
}

// Tags closed in order, no number that is none: what a viewer needs.
void expect_well_formed(const std::string& svg) {
  EXPECT_THAT(svg, testing::StartsWith("<"));
  EXPECT_EQ(svg.find("nan"), std::string::npos);
  EXPECT_EQ(svg.find("inf"), std::string::npos);
  std::vector<std::string> open;
  for (std::size_t at = svg.find('<'); at != std::string::npos; at = svg.find('<', at + 1)) {
    const std::size_t end = svg.find('>', at);
    ASSERT_NE(end, std::string::npos);
    const std::string tag = svg.substr(at + 1, end - at - 1);
    if (tag[0] == '?' || tag[0] == '!' || tag.back() == '/') continue;
    const std::string name = tag.substr(tag[0] == '/' ? 1 : 0, tag.find(' ') - 0);
    if (tag[0] != '/') {
      open.push_back(name.substr(0, name.find(' ')));
      continue;
    }
    ASSERT_FALSE(open.empty());
    EXPECT_EQ(open.back(), name);
    open.pop_back();
  }
  EXPECT_TRUE(open.empty());
}

TEST(Paper, PlotsAreWellFormedAndComplete) {
  std::set<std::string> names;
  for (const PaperFile& file : paper().files) {
    names.insert(file.name);
    if (file.name.ends_with(".svg")) expect_well_formed(file.text);
  }
  for (const char* name :
       {"chromaticity.svg", "transmittance.svg", "transmittance_harrison-horner-1939.svg",
        "transmittance_cornwell-clyne-1951.svg", "transmittance_collins-giles-1952.svg",
        "transmittance_neblette-1952.svg", "reseau_tab1.svg", "reseau_tab2.svg", "tab1.csv",
        "tab2.csv", "tab3.csv", "tab4.csv"}) {
    EXPECT_TRUE(names.contains(name)) << name;
  }
}

TEST(Svg, TextIsEscaped) {
  EXPECT_EQ(xml_text("a<b>&\"c\"\x01"), "a&lt;b&gt;&amp;&quot;c&quot;");
  SvgPage page(100, 50);
  page.text({1, 2}, "5 < 6 & so on", 10);
  expect_well_formed(page.str());
  EXPECT_THAT(page.str(), HasSubstr("5 &lt; 6 &amp; so on"));
}

// The simulated réseau shows each element in the share of the area it has.
TEST(Reseau, PixelsHaveTheAreasOfTheElements) {
  const Matrix3 pure{1, 0, 0, 0, 1, 0, 0, 0, 1};
  constexpr int kSide = 400;
  const auto pixels = reseau_pixels(pure, 8, kSide);
  ASSERT_EQ(pixels.size(), std::size_t{3} * kSide * kSide);
  Vector3 sum{};
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    sum[i % 3] += pixels[i] > 127 ? 1 : 0;  // of edges, the larger part
  }
  const Vector3 areas = dufaycolor_areas();
  for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(sum[k] / (kSide * kSide), areas[k], 0.02) << k;
}

}  // namespace
}  // namespace reseau
