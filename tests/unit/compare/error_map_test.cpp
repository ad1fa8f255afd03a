#include "capture/compare/error_map.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture/compare/color_pass.h"
#include "capture/compare/picture.h"
#include "core/base/error.h"
#include "tests/support/temp_dir.h"

namespace reseau::compare {
namespace {

using reseau::test::file_bytes;
using reseau::test::TempDir;
using ::testing::HasSubstr;

Comparison example(int width, int height) {
  std::vector<float> delta(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  for (std::size_t i = 0; i < delta.size(); ++i) delta[i] = static_cast<float>(i % 7);
  delta[0] = NAN;
  Comparison c;
  c.area = {0, 0, width, height};
  c.raster = raster_of(delta, width, height, 1200);
  c.color.emplace();
  return c;
}

TEST(Raster, IsTheMeanOfSquares) {
  const std::vector<float> delta{1, 3, 5, 7, NAN, NAN, 2, 2, 9, NAN, NAN, NAN};
  const ErrorRaster raster = raster_of(delta, 4, 3, 2);
  EXPECT_EQ(raster.cell_px, 2);
  EXPECT_EQ(raster.width, 2);
  EXPECT_EQ(raster.height, 2);
  EXPECT_EQ(raster.mean_delta_e[0], 2);
  EXPECT_EQ(raster.mean_delta_e[1], 4);
  EXPECT_EQ(raster.mean_delta_e[2], 9);
  EXPECT_TRUE(std::isnan(raster.mean_delta_e[3]));
}

TEST(ErrorMap, SvgHasScaleAndBar) {
  const TempDir dir;
  Comparison c = example(300, 200);
  c.registration.emplace();
  c.registration->field_columns = c.registration->field_rows = 1;
  c.registration->field = {{150, 100, 0.25, 0, 0.25, 10}};
  write_error_map(c, 6, dir / "m.svg");
  const std::string svg = file_bytes(dir / "m.svg");
  EXPECT_THAT(svg, HasSubstr("<svg xmlns"));
  EXPECT_THAT(svg, HasSubstr(">6</text>"));
  EXPECT_THAT(svg, HasSubstr("50 px</text>"));
  EXPECT_THAT(svg, HasSubstr("longest 0.250 px"));
  EXPECT_EQ(svg.find("nan"), std::string::npos);
  write_error_map(c, 6, dir / "again.svg");
  EXPECT_TRUE(svg == file_bytes(dir / "again.svg"));
  EXPECT_THROW(write_error_map(c, 6, dir / "m.svg"), InputError) << "it exists";
}

TEST(ErrorMap, PngShowsEverySquare) {
  const TempDir dir;
  const Comparison c = example(1, 1);
  write_error_map(c, 0, dir / "one.png");
  EXPECT_EQ(read_picture_header(dir / "one.png").height_px, 480 + 64);
  write_error_map(example(2500, 10), 0, dir / "wide.PNG");
  EXPECT_EQ(read_picture_header(dir / "wide.PNG").width_px, 834);
  EXPECT_THROW(write_error_map(c, 0, dir / "map.jpg"), InputError);
}

}  // namespace
}  // namespace reseau::compare
