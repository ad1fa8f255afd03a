#include "capture/image/exr_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <limits>

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfOutputFile.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture/store/sha256.h"
#include "core/base/error.h"
#include "tests/support/temp_dir.h"

namespace reseau {
namespace {

using test::file_bytes;
using test::names_in;
using test::TempDir;
using test::write_bytes;

// Values that only an exact round trip keeps: denormal, infinite, negative, not a number.
std::vector<float> awkward(std::size_t n) {
  std::vector<float> samples(n);
  for (std::size_t i = 0; i < n; ++i) {
    samples[i] = std::sin(static_cast<float>(i)) * std::pow(10.0F, static_cast<float>(i % 60) - 30);
  }
  samples[0] = std::numeric_limits<float>::denorm_min();
  samples[1] = std::numeric_limits<float>::infinity();
  samples[2] = -0.0F;
  samples[n - 1] = std::numeric_limits<float>::quiet_NaN();
  return samples;
}

bool same_bits(const std::vector<float>& a, const std::vector<float>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}

void write(const std::filesystem::path& path, int width, int height,
           const std::vector<std::string>& channels, const std::vector<float>& samples,
           int rows_at_once, const ExrOptions& options = {}) {
  FloatImageWriter writer(path, width, height, channels, options);
  const auto row = static_cast<std::size_t>(width) * channels.size();
  for (int y = 0; y < height; y += rows_at_once) {
    const int n = std::min(rows_at_once, height - y);
    writer.rows(y, n,
                std::span(samples).subspan(static_cast<std::size_t>(y) * row,
                                           static_cast<std::size_t>(n) * row));
  }
  writer.finish();
}

std::string input_error(const std::filesystem::path& path,
                        const std::vector<std::string>& channels = {"R", "G", "B"}) {
  try {
    (void)read_exr(path, channels);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(ExrFile, RoundTripIsExactWithAnyChannelsAndCompression) {
  const TempDir dir;
  for (const auto compression : {ExrCompression::kNone, ExrCompression::kSmall}) {
    for (const std::vector<std::string>& channels :
         {std::vector<std::string>{"R", "G", "B"}, {"u", "v"}, {"screen.confidence"}}) {
      const auto samples = awkward(41 * 150 * channels.size());
      ExrOptions options;
      options.existing = Existing::kReplace;
      options.compression = compression;
      write(dir / "x.exr", 41, 150, channels, samples, 7, options);
      const auto back = read_exr(dir / "x.exr", channels);
      EXPECT_EQ(back.width_px, 41);
      EXPECT_EQ(back.height_px, 150);
      EXPECT_TRUE(same_bits(back.samples, samples));
    }
  }
  EXPECT_EQ(names_in(dir.path()), std::vector<std::string>{"x.exr"});
}

TEST(ExrFile, SamePictureSameBytesHoweverRowsCome) {
  const TempDir dir;
  const auto samples = awkward(33 * 200 * 3);
  for (const auto compression : {ExrCompression::kNone, ExrCompression::kSmall}) {
    ExrOptions options;
    options.compression = compression;
    options.existing = Existing::kReplace;
    write(dir / "a.exr", 33, 200, {"R", "G", "B"}, samples, 1, options);
    write(dir / "b.exr", 33, 200, {"R", "G", "B"}, samples, 200, options);
    EXPECT_EQ(file_bytes(dir / "a.exr"), file_bytes(dir / "b.exr"));
  }
}

TEST(ExrFile, KeepsChromaticitiesAndProvenance) {
  const TempDir dir;
  ExrOptions options;
  options.chromaticities = Chromaticities{{{{0.64, 0.33}, {0.3, 0.6}, {0.15, 0.06}, {0.31, 0.33}}}};
  options.attributes = {{"reseau.version", "1"}, {"reseau.source", "päth"}};
  write(dir / "x.exr", 3, 2, {"R", "G", "B"}, awkward(18), 2, options);
  const ExrReader reader(dir / "x.exr");
  ASSERT_TRUE(reader.chromaticities().has_value());
  EXPECT_NEAR(reader.chromaticities()->xy[1][1], 0.6, 1e-7);
  EXPECT_EQ(reader.attribute("reseau.source"), "päth");
  EXPECT_EQ(reader.attribute("reseau.none"), std::nullopt);
}

TEST(ExrFile, ReadsAnyRows) {
  const TempDir dir;
  const auto samples = awkward(5 * 90 * 3);
  write(dir / "x.exr", 5, 90, {"R", "G", "B"}, samples, 90);
  ExrReader reader(dir / "x.exr", {"B", "R"});
  std::vector<float> rows(5 * 2 * 2);
  for (const int y : {70, 3, 88}) {
    reader.read(y, 2, rows);
    EXPECT_EQ(rows[0], samples[static_cast<std::size_t>(y) * 15 + 2]);
    EXPECT_EQ(rows[1], samples[static_cast<std::size_t>(y) * 15]);
  }
}

TEST(ExrFile, NeverReplacesUnaskedAndLeavesNothingUnfinished) {
  const TempDir dir;
  write_bytes(dir / "x.exr", "mine");
  EXPECT_THROW(write(dir / "x.exr", 2, 2, {"Y"}, awkward(4), 2), InputError);
  EXPECT_EQ(file_bytes(dir / "x.exr"), "mine");
  {
    ExrOptions options;
    options.existing = Existing::kReplace;
    FloatImageWriter writer(dir / "x.exr", 2, 2, {"Y"}, options);
    writer.rows(0, 1, awkward(4).size() == 4 ? std::vector<float>{1, 2} : std::vector<float>{});
    EXPECT_EQ(names_in(dir.path()), (std::vector<std::string>{".x.exr.part", "x.exr"}));
    // Nobody else may write it meanwhile.
    EXPECT_THROW(FloatImageWriter(dir / "x.exr", 2, 2, {"Y"}, options), InputError);
  }
  EXPECT_EQ(names_in(dir.path()), std::vector<std::string>{"x.exr"});
  EXPECT_EQ(file_bytes(dir / "x.exr"), "mine");
  // The part of a run that was killed is taken over.
  write_bytes(dir / ".y.exr.part", std::string(100'000, 'x'));
  write(dir / "y.exr", 2, 2, {"Y"}, awkward(4), 2);
  EXPECT_TRUE(same_bits(read_exr(dir / "y.exr", {"Y"}).samples, awkward(4)));
}

TEST(ExrFile, SaysWhatIsWrong) {
  const TempDir dir;
  using testing::HasSubstr;
  EXPECT_THAT(input_error(dir / "none.exr"), HasSubstr("There is no file"));
  EXPECT_THAT(input_error(dir.path()), HasSubstr("is a folder"));
  write_bytes(dir / "empty.exr", "");
  EXPECT_THAT(input_error(dir / "empty.exr"), HasSubstr("not an OpenEXR"));
  write(dir / "map.exr", 40, 40, {"u", "v"}, awkward(3200), 40);
  EXPECT_THAT(input_error(dir / "map.exr"), HasSubstr("has no channel 'R'; it has: u, v."));
  const auto whole = file_bytes(dir / "map.exr");
  write_bytes(dir / "cut.exr", whole.substr(0, whole.size() / 2));
  EXPECT_THAT(input_error(dir / "cut.exr", {"u"}), HasSubstr("damaged"));
  write_bytes(dir / "head.exr", whole.substr(0, 60));
  EXPECT_THAT(input_error(dir / "head.exr", {"u"}), HasSubstr("damaged"));
}

TEST(ExrFile, TellsItsHashWithoutReadingItselfAgain) {
  const TempDir dir;
  const auto samples = awkward(33 * 200 * 3);
  for (const auto compression : {ExrCompression::kNone, ExrCompression::kSmall}) {
    for (const int rows_at_once : {1, 63, 64, 200}) {
      ExrOptions options;
      options.compression = compression;
      options.existing = Existing::kReplace;
      options.attributes = {{"reseau.source", "x"}};
      FloatImageWriter writer(dir / "a.exr", 33, 200, {"R", "G", "B"}, options);
      for (int y = 0; y < 200; y += rows_at_once) {
        const int n = std::min(rows_at_once, 200 - y);
        writer.rows(y, n,
                    std::span(samples).subspan(static_cast<std::size_t>(y) * 99,
                                               static_cast<std::size_t>(n) * 99));
      }
      writer.finish();
      EXPECT_EQ(writer.sha256(), sha256_of_file(dir / "a.exr")) << rows_at_once;
      if (compression == ExrCompression::kNone) {
        // Of stored rows it was known before: the file can be gone.
        std::filesystem::remove(dir / "a.exr");
        EXPECT_EQ(writer.sha256().size(), 64U);
      }
    }
  }
}

// As other programs write them: among the channels are half floats, whole numbers, and one at a
// lower resolution; the picture does not begin at (0, 0); rows from the bottom up.
TEST(ExrFile, ReadsStoredPicturesOfOtherPrograms) {
  using IMATH_NAMESPACE::Box2i;
  using IMATH_NAMESPACE::V2i;
  const TempDir dir;
  constexpr int kWidth = 12, kHeight = 30, kLeft = -3, kTop = 7;
  const auto expected = [](std::size_t c, int x, int y) {
    return static_cast<float>(c + 1) * 100 + static_cast<float>(x) + static_cast<float>(y) / 64;
  };
  for (const bool sparse : {false, true}) {
    for (const auto order : {Imf::INCREASING_Y, Imf::DECREASING_Y}) {
      const V2i from(kLeft, kTop), to(kLeft + kWidth - 1, kTop + kHeight - 1);
      Imf::Header header(Box2i(V2i(0, 0), V2i(99, 99)), Box2i(from, to), 1,
                         IMATH_NAMESPACE::V2f(0, 0), 1, order, Imf::NO_COMPRESSION);
      std::vector<float> planes(3 * kWidth * kHeight);
      std::vector<std::uint16_t> half(kWidth * kHeight, 0x3C00);
      std::vector<std::uint32_t> id(kWidth * kHeight, 77);
      Imf::FrameBuffer frame;
      const std::array<const char*, 3> names{"R", "G", "B"};
      for (std::size_t c = 0; c < 3; ++c) {
        float* plane = planes.data() + c * kWidth * kHeight;
        for (int y = 0; y < kHeight; ++y) {
          for (int x = 0; x < kWidth; ++x) plane[y * kWidth + x] = expected(c, x, y);
        }
        header.channels().insert(names[c], Imf::Channel(Imf::FLOAT));
        frame.insert(names[c], Imf::Slice::Make(Imf::FLOAT, plane, Box2i(from, to)));
      }
      header.channels().insert("A", Imf::Channel(Imf::HALF));
      frame.insert("A", Imf::Slice::Make(Imf::HALF, half.data(), Box2i(from, to)));
      header.channels().insert("Id", Imf::Channel(Imf::UINT));
      frame.insert("Id", Imf::Slice::Make(Imf::UINT, id.data(), Box2i(from, to)));
      std::vector<float> low(kWidth * kHeight, 5);
      if (sparse) {
        // Sampled every third column; the window begins and ends on one.
        header.channels().insert("Z", Imf::Channel(Imf::FLOAT, 3, 1));
        frame.insert("Z", Imf::Slice::Make(Imf::FLOAT, low.data(), Box2i(from, to), 0, 0, 3, 1));
      }
      {
        Imf::OutputFile file((dir / "x.exr").c_str(), header);
        file.setFrameBuffer(frame);
        file.writePixels(kHeight);
      }
      ExrReader reader(dir / "x.exr");
      ASSERT_EQ(reader.width_px(), kWidth);
      std::vector<float> rows(kWidth * 3 * 4);
      for (const int y : {20, 0, 26}) {
        reader.read(y, 4, rows);
        for (int i = 0; i < 4; ++i) {
          for (int x = 0; x < kWidth; ++x) {
            for (std::size_t c = 0; c < 3; ++c) {
              EXPECT_EQ(rows[static_cast<std::size_t>(i * kWidth + x) * 3 + c],
                        expected(c, x, y + i));
            }
          }
        }
      }
    }
  }
}

}  // namespace
}  // namespace reseau
