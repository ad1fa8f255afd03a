#pragma once

#include <cstdint>
#include <exception>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "capture/store/line_watermark.h"
#include "capture/store/master_layout.h"
#include "capture/store/master_source.h"
#include "capture/store/part_file.h"
#include "core/line/line_sink.h"

namespace reseau {

struct MasterOptions {
  std::filesystem::path path;  // the final name; must not exist
  std::string film;            // what the person said is on the film, e.g. "dufay"; may be empty
  // Reserve room on the disk at begin(), so that a disk that is too small is found before the film
  // is read.
  bool reserve_space = true;
  // Files larger than this are BigTIFF; lowered by tests only.
  std::uint64_t bigtiff_above_bytes = kClassicTiffLimit;
};

struct MasterResult {
  // Where the lines are now: the final name; NAME.partial.tif after a cancelled or failed scan;
  // empty when no line came (nothing is left behind then).
  std::filesystem::path path;
  int n_lines = 0;
  bool complete = false;
  // Why the file could not be synced or given its name; null when all went well. The lines are then
  // in `path` (the part) still.
  std::exception_ptr error;
};

// Writes the master: one directory, chunky, 16 bit, uncompressed, R G B and infrared as a fourth
// sample (ExtraSamples 0), linear ICC profile, roles and settings in XMP. The bytes depend on
// format, context and lines only, not on the clock nor on how lines were grouped.
//
// While it grows the file is called `.NAME.tif.part` and is, after each lines(), a valid TIFF of
// the lines committed so far. The order of writes makes it so: pixels, at offsets known beforehand;
// then the byte counts of their strips; then the first 512 bytes, which hold the header and the
// whole directory, in one write with the new ImageLength. A killed process or a full disk therefore
// costs no committed line. After a power failure lines since the last sync (32 MiB at most) may be
// missing.
//
// Thread-bound (the writer thread); source() may be handed to any thread.
class MasterWriter final : public LineSink {
 public:
  explicit MasterWriter(MasterOptions options);
  ~MasterWriter() override;
  MasterWriter(const MasterWriter&) = delete;
  MasterWriter& operator=(const MasterWriter&) = delete;

  // Throws InputError when the name is taken, std::system_error when there is no room for the whole
  // scan or the folder cannot be written.
  void begin(const LineFormat& format, const CaptureContext& context) override;
  // Commits the block. Throws std::system_error with a sentence; earlier lines stay committed and
  // end() must still be called.
  void lines(const LineBlock& block) override;
  // kComplete with every line: published under the final name. Anything else with at least one
  // line: cut to the committed lines and published as NAME.partial.tif (NAME.partial-2.tif … when
  // taken). See result().
  void end(ScanEnd end) noexcept override;

  // Valid after begin(): the committed lines, during the scan and after it.
  [[nodiscard]] std::shared_ptr<const MasterFileSource> source() const { return source_; }
  // Valid after end().
  [[nodiscard]] const MasterResult& result() const { return result_; }

 private:
  void commit(int n_lines);
  void publish();

  MasterOptions options_;
  MasterLayout layout_;
  std::unique_ptr<PartFile> file_;
  std::shared_ptr<LineWatermark> watermark_;
  std::shared_ptr<const MasterFileSource> source_;
  std::vector<std::uint16_t> interleaved_;
  std::uint64_t unsynced_bytes_ = 0;
  int n_committed_ = 0;
  MasterResult result_;
};

}  // namespace reseau
