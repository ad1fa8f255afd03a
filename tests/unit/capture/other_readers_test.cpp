// Masters and view copies as OpenImageIO sees them: a reader whose mistakes are not libtiff's.
#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include "capture/image/picture_writer.h"
#include "capture/store/master_writer.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/capture/scan_fixture.h"

namespace reseau {
namespace {

using test::TempDir;

void expect_same_pixels(const std::filesystem::path& path, const LineFormat& format, int n_lines) {
  const auto input = OIIO::ImageInput::open(path.string());
  ASSERT_NE(input, nullptr) << OIIO::geterror();
  const OIIO::ImageSpec& spec = input->spec();
  ASSERT_EQ(spec.width, format.width_px);
  ASSERT_EQ(spec.height, n_lines);
  ASSERT_EQ(spec.nchannels, format.n_channels());
  EXPECT_EQ(spec.format, OIIO::TypeDesc::UINT16);
  std::vector<std::uint16_t> pixels(format.samples_per_line() * static_cast<std::size_t>(n_lines));
  ASSERT_TRUE(input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::UINT16, pixels.data()));
  int n_wrong = 0;
  std::size_t i = 0;
  for (int y = 0; y < n_lines; ++y) {
    for (int x = 0; x < format.width_px; ++x) {
      for (int c = 0; c < format.n_channels(); ++c)
        n_wrong += pixels[i++] != test::sample_at(y, c, x);
    }
  }
  EXPECT_EQ(n_wrong, 0);
}

TEST(OtherReaders, OpenImageIoReadsWholePartialAndGrowingMasters) {
  const TempDir dir;
  for (const bool big : {false, true}) {
    const auto format = test::small_format(9000, 40);
    MasterOptions options;
    options.path = dir / (big ? "big.tif" : "classic.tif");
    if (big) options.bigtiff_above_bytes = 1000;
    MasterWriter writer(options);
    writer.begin(format, test::small_context());
    writer.lines(test::block_of(format, 0, 17));
    // OpenImageIO knows files by their extension.
    const auto copy = dir / (big ? "big-growing.tif" : "growing.tif");
    std::filesystem::copy_file(part_path_of(options.path), copy);
    expect_same_pixels(copy, format, 17);
    writer.lines(test::block_of(format, 17, 23));
    writer.end(ScanEnd::kComplete);
    expect_same_pixels(options.path, format, 40);
  }
}

TEST(OtherReaders, OpenImageIoReadsThePicture) {
  const TempDir dir;
  PictureOptions options;
  options.exr = dir / "a.exr";
  options.exr_options.chromaticities =
      Chromaticities{{{{0.64, 0.33}, {0.3, 0.6}, {0.15, 0.06}, {0.3127, 0.329}}}};
  options.tiff = dir / "a.tif";
  options.png = dir / "a.png";
  options.exposure = 1;
  PictureWriter writer(options);
  writer.begin(8, 8);
  writer.rows(0, 8, std::vector<float>(8 * 8 * 3, 0.214F));
  writer.end();
  for (const auto& [path, expected] :
       {std::pair{options.exr, 0.214F}, {options.tiff, 0.5F}, {options.png, 0.5F}}) {
    const auto input = OIIO::ImageInput::open(path.string());
    ASSERT_NE(input, nullptr) << OIIO::geterror();
    EXPECT_EQ(input->spec().channelnames, (std::vector<std::string>{"R", "G", "B"}));
    std::vector<float> pixels(8 * 8 * 3);
    ASSERT_TRUE(input->read_image(0, 0, 0, 3, OIIO::TypeDesc::FLOAT, pixels.data()));
    EXPECT_NEAR(pixels[100], expected, 0.003);
  }
}

}  // namespace
}  // namespace reseau
