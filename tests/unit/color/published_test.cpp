// Colour differences between sets of primaries, as Tab. 3 and Tab. 4 of Hubicka et al. 2025
// (arXiv:2501.06216) give them for two photographs, on synthetic scenes that stand for these.
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include <gtest/gtest.h>

#include "core/color/delta_e.h"
#include "core/color/element_color.h"
#include "core/color/pixel_matrix.h"
#include "tests/unit/color/reference_tables.h"

namespace reseau {
namespace {

std::vector<Vector3> read_scene(const std::string& name) {
  std::vector<Vector3> scene;
  for (const CsvRow& row : read_reference_table("scene_" + name + ".csv")) {
    scene.push_back({number(row, "r"), number(row, "g"), number(row, "b")});
  }
  return scene;
}

DeltaESummary compare_sets(const std::vector<Vector3>& scene, const std::string& set_a,
                           const std::string& set_b, Balance balance) {
  const Matrix3 a = make_color_model(set_a, balance, OutputSpace::kXyz).xyz_from_process;
  const Matrix3 b = make_color_model(set_b, balance, OutputSpace::kXyz).xyz_from_process;
  const Xyz white = white_of(Illuminant::kD65);
  std::vector<double> differences;
  for (const Vector3& pixel : scene) {
    differences.push_back(delta_e_2000(lab_from_xyz(multiply(a, pixel), white),
                                       lab_from_xyz(multiply(b, pixel), white)));
  }
  return summarize_delta_e(differences, 0.01);
}

// Figures computed independently: they keep the whole chain tied down without any table.
TEST(SetDifference, OfTheClearReseau) {
  const std::vector<Vector3> clear{{1, 1, 1}};
  EXPECT_NEAR(compare_sets(clear, "cornwell-clyne-1951", "neblette-1952", Balance::kNeutral).mean,
              0, 1e-9);
  const Xyz white = white_of(Illuminant::kD65);
  const auto cast = [&white](const char* set) {
    const ColorModel model = make_color_model(set, Balance::kBrightness, OutputSpace::kXyz);
    return delta_e_2000(lab_from_xyz(model.reseau, white), lab_from_xyz(white, white));
  };
  EXPECT_NEAR(cast("cornwell-clyne-1951-tab1"), 21.1, 0.05);
  EXPECT_NEAR(cast("hubicka-2025"), 8.7, 0.05);
  EXPECT_NEAR(cast("harrison-horner-1939"), 19.1, 0.05);
  EXPECT_NEAR(cast("cornwell-clyne-1951"), 20.6, 0.05);
  EXPECT_NEAR(cast("collins-giles-1952"), 18.3, 0.05);
  EXPECT_NEAR(cast("neblette-1952"), 21.6, 0.05);
}

TEST(SetDifference, OfTheScenesAgreesWithTheReferenceTable) {
  const auto rows = read_reference_table("scene_differences.csv");
  const std::map<std::string, std::vector<Vector3>> scenes{{"warm", read_scene("warm")},
                                                           {"green", read_scene("green")}};
  ASSERT_EQ(rows.size(), 84u);
  for (const CsvRow& row : rows) {
    const auto own = compare_sets(scenes.at(row.at("scene")), row.at("set_a"), row.at("set_b"),
                                  parse_balance(row.at("balance")));
    EXPECT_EQ(own.n, 990u);
    EXPECT_NEAR(own.mean, number(row, "dE_avg"), 0.002) << row.at("set_a") << row.at("set_b");
    EXPECT_NEAR(own.max, number(row, "dE_max"), 0.002) << row.at("set_a") << row.at("set_b");
  }
}

// Pixels are floats, and their matrix acts on floats.
TEST(SetDifference, OfPixelsInSinglePrecisionAgreesWithTheReferenceTable) {
  const auto lab_of = [](const std::string& set, const CsvRow& row, const Vector3& intensity) {
    const ColorModel model =
        make_color_model(set, parse_balance(row.at("balance")), OutputSpace::kXyz);
    std::array<float, 3> pixel{};
    for (std::size_t i = 0; i < 3; ++i) pixel[i] = static_cast<float>(intensity[i]);
    transform_pixels(pixel, model.output_from_process);
    return lab_from_xyz({double{pixel[0]}, double{pixel[1]}, double{pixel[2]}},
                        white_of(Illuminant::kD65));
  };
  const std::map<std::string, std::vector<Vector3>> scenes{{"warm", read_scene("warm")},
                                                           {"green", read_scene("green")}};
  const auto rows = read_reference_table("scene_differences.csv");
  for (std::size_t r = 0; r < rows.size(); r += 7) {  // every seventh says as much
    std::vector<double> differences;
    for (const Vector3& pixel : scenes.at(rows[r].at("scene"))) {
      differences.push_back(delta_e_2000(lab_of(rows[r].at("set_a"), rows[r], pixel),
                                         lab_of(rows[r].at("set_b"), rows[r], pixel)));
    }
    const DeltaESummary own = summarize_delta_e(differences, 0.01);
    EXPECT_NEAR(own.mean, number(rows[r], "dE_avg"), 0.01) << r;
    EXPECT_NEAR(own.max, number(rows[r], "dE_max"), 0.01) << r;
  }
}

// Ranks without ties.
double spearman(const std::vector<double>& a, const std::vector<double>& b) {
  const auto ranks = [](const std::vector<double>& v) {
    std::vector<double> rank(v.size());
    for (std::size_t i = 0; i < v.size(); ++i) {
      rank[i] = static_cast<double>(
          std::count_if(v.begin(), v.end(), [&v, i](double other) { return other < v[i]; }));
    }
    return rank;
  };
  const auto ra = ranks(a), rb = ranks(b);
  double squares = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    squares += (ra[i] - rb[i]) * (ra[i] - rb[i]);
  }
  const double n = static_cast<double>(a.size());
  return 1 - 6 * squares / (n * (n * n - 1));
}

struct PublishedCase {
  const char* scene;
  const char* balance;
  const char* photograph;
  double each_within;     // largest relative error of an average
  double mean_within;     // mean relative error of the averages
  double order_at_least;  // Spearman's rank correlation
};

TEST(SetDifference, ReproducesThePublishedTables) {
  const auto published = read_reference_table("published_differences.csv");
  const PublishedCase cases[] = {
      {"warm", "neutral", "fig6", 0.10, 0.05, 0.99},
      {"green", "brightness", "fig3", 0.10, 0.05, 0.99},
      {"green", "neutral", "fig3", 0.20, 0.20, 0.95},
  };
  for (const PublishedCase& each : cases) {
    const auto scene = read_scene(each.scene);
    std::vector<double> ours, theirs;
    double error_sum = 0;
    for (const CsvRow& row : published) {
      if (row.at("photograph") != each.photograph || row.at("balance") != each.balance) {
        continue;
      }
      ours.push_back(
          compare_sets(scene, row.at("set_a"), row.at("set_b"), parse_balance(each.balance)).mean);
      theirs.push_back(number(row, "dE_avg"));
      const double error = std::abs(ours.back() / theirs.back() - 1);
      error_sum += error;
      EXPECT_LE(error, each.each_within) << row.at("set_a") << " " << row.at("set_b");
    }
    ASSERT_EQ(ours.size(), 15u);
    EXPECT_LE(error_sum / 15, each.mean_within) << each.scene << each.balance;
    EXPECT_GE(spearman(ours, theirs), each.order_at_least) << each.scene << each.balance;
  }
}

}  // namespace
}  // namespace reseau
