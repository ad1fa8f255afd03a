// Damaged TIFFs: the reader gives a scan or an InputError, and nothing else happens.
#include <random>

#include <gtest/gtest.h>
#include <tiffio.h>

#include "capture/image/icc.h"
#include "capture/image/scan_reader.h"
#include "capture/store/master_writer.h"
#include "core/base/error.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/capture/scan_fixture.h"

namespace reseau {
namespace {

using test::file_bytes;
using test::TempDir;
using test::write_bytes;

std::string master_bytes(const TempDir& dir) {
  const auto format = test::small_format(60, 40);
  MasterOptions options;
  options.path = dir / "seed.tif";
  MasterWriter writer(options);
  writer.begin(format, test::small_context());
  writer.lines(test::block_of(format, 0, 40));
  writer.end(ScanEnd::kComplete);
  return file_bytes(options.path);
}

std::string foreign_bytes(const TempDir& dir, int compression, bool tiled, bool planar, int bits) {
  const auto path = dir / "foreign.tif";
  TIFF* tiff = TIFFOpen(path.c_str(), "w");
  TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, 40);
  TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, 40);
  TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, 3);
  TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, bits);
  TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_RGB);
  TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, planar ? PLANARCONFIG_SEPARATE : PLANARCONFIG_CONTIG);
  TIFFSetField(tiff, TIFFTAG_COMPRESSION, compression);
  const auto icc = srgb_icc();
  TIFFSetField(tiff, TIFFTAG_ICCPROFILE, static_cast<std::uint32_t>(icc.size()), icc.data());
  std::vector<std::uint8_t> data(48 * 48 * 8, 77);
  for (std::size_t i = 0; i < data.size(); i += 3) data[i] = static_cast<std::uint8_t>(i * 13);
  if (tiled) {
    TIFFSetField(tiff, TIFFTAG_TILEWIDTH, 16);
    TIFFSetField(tiff, TIFFTAG_TILELENGTH, 16);
    for (std::uint32_t tile = 0; tile < TIFFNumberOfTiles(tiff); ++tile) {
      TIFFWriteEncodedTile(tiff, tile, data.data(), TIFFTileSize(tiff));
    }
  } else {
    TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, 8);
    for (std::uint32_t strip = 0; strip < TIFFNumberOfStrips(tiff); ++strip) {
      TIFFWriteEncodedStrip(tiff, strip, data.data(), TIFFStripSize(tiff));
    }
  }
  TIFFClose(tiff);
  return file_bytes(path);
}

// Where damage matters: the header, and the directory wherever it lies.
std::size_t place(const std::string& bytes, std::mt19937& random) {
  const auto at = [&](std::size_t i) {
    return static_cast<std::size_t>(static_cast<unsigned char>(bytes[i]));
  };
  const std::size_t directory = at(4) | at(5) << 8 | at(6) << 16 | at(7) << 24;
  switch (random() % 4) {
    case 0:
      return random() % bytes.size();
    case 1:
      return random() % std::min<std::size_t>(bytes.size(), 512);
    default:
      return std::min(directory + random() % 260, bytes.size() - 1);
  }
}

TEST(ScanReaderFuzz, MutatedFilesAreReadOrRefused) {
  const TempDir dir;
  const std::vector<std::string> seeds = {
      master_bytes(dir),
      foreign_bytes(dir, COMPRESSION_LZW, false, false, 16),
      foreign_bytes(dir, COMPRESSION_ADOBE_DEFLATE, true, true, 16),
      foreign_bytes(dir, COMPRESSION_PACKBITS, true, false, 8),
      foreign_bytes(dir, COMPRESSION_JPEG, false, false, 8),
      foreign_bytes(dir, COMPRESSION_NONE, false, true, 8)};
  constexpr unsigned kSeed = 20261122;
  SCOPED_TRACE("seed " + std::to_string(kSeed));
  std::mt19937 random(kSeed);
  ReadScanOptions options;
  options.max_memory_bytes = std::uint64_t{64} << 20;
  options.allow_grey = true;
  int n_read = 0, n_refused = 0;
  for (int i = 0; i < 1500; ++i) {
    std::string bytes = seeds[static_cast<std::size_t>(i) % seeds.size()];
    const auto n_changes = 1 + random() % 4;
    for (unsigned k = 0; k < n_changes; ++k) {
      const char extremes[] = {0, 1, -1, 127, -128};
      bytes[place(bytes, random)] =
          random() % 2 == 0 ? extremes[random() % 5] : static_cast<char>(random() & 0xFF);
    }
    if (random() % 8 == 0) bytes.resize(random() % bytes.size());
    write_bytes(dir / "x.tif", bytes);
    options.accept_truncated = random() % 2 == 0;
    try {
      const Scan scan = read_scan(dir / "x.tif", options);
      const auto& format = scan.source->format();
      ASSERT_GT(format.n_lines, 0);
      std::vector<std::uint16_t> line(format.samples_per_line());
      scan.source->read(0, 1, line);
      scan.source->read(format.n_lines - 1, 1, line);
      ++n_read;
    } catch (const InputError&) {
      ++n_refused;
    }
  }
  // Both must happen, or the damage is of the wrong kind.
  EXPECT_GT(n_read, 200);
  EXPECT_GT(n_refused, 200);
}

}  // namespace
}  // namespace reseau
