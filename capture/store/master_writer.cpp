#include "capture/store/master_writer.h"

#include <bit>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <string>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include "core/base/check.h"
#include "core/base/error.h"

namespace reseau {
namespace {

static_assert(std::endian::native == std::endian::little,
              "rows are written as they lie in memory, and the header says little endian");

// A power failure may cost this much; the sync of so little does not hold up a scan.
constexpr std::uint64_t kSyncBytes = std::uint64_t{32} << 20;
constexpr int kMaxAlternatives = 1000;

std::string megabytes(std::uint64_t bytes) {
  char text[40];
  std::snprintf(text, sizeof text, "%.0f MB", std::ceil(static_cast<double>(bytes) / 1e6));
  return text;
}

void reserve_room(const PartFile& file, std::uint64_t bytes) {
  // Ask first: a reservation that fails has by then taken the whole disk from everyone for a
  // moment.
  struct statvfs room {};
  const bool fits = ::fstatvfs(file.fd(), &room) != 0 ||
                    static_cast<std::uint64_t>(room.f_bavail) * room.f_frsize >= bytes;
  // KEEP_SIZE: the file must not claim more than was written to it.
  if (fits && ::fallocate(file.fd(), FALLOC_FL_KEEP_SIZE, 0, static_cast<off_t>(bytes)) == 0)
    return;
  const int error = fits ? errno : ENOSPC;
  if (error != ENOSPC && error != EDQUOT) return;  // the file system cannot reserve
  throw std::system_error(error, std::generic_category(),
                          "The scan needs " + megabytes(bytes) + " and the disk has no room for '" +
                              file.final_path().string() +
                              "'; make room, choose another folder or a lower resolution");
}

template <std::size_t kChannels>
void join_line(const LineBlock& block, int line, std::uint16_t* out) {
  const std::uint16_t* planes[kChannels];
  for (std::size_t c = 0; c < kChannels; ++c) {
    planes[c] = block.plane(line, static_cast<int>(c)).data();
  }
  const auto width = static_cast<std::size_t>(block.width_px);
  for (std::size_t x = 0; x < width; ++x) {
    for (std::size_t c = 0; c < kChannels; ++c) out[x * kChannels + c] = planes[c][x];
  }
}

void join_line(const LineBlock& block, int line, std::uint16_t* out) {
  if (block.n_channels == 4) return join_line<4>(block, line, out);
  if (block.n_channels == 3) return join_line<3>(block, line, out);
  const auto channels = static_cast<std::size_t>(block.n_channels);
  for (std::size_t c = 0; c < channels; ++c) {
    const auto plane = block.plane(line, static_cast<int>(c));
    for (std::size_t x = 0; x < plane.size(); ++x) out[x * channels + c] = plane[x];
  }
}

// NAME.tif, NAME-2.tif … or NAME.partial.tif, NAME.partial-2.tif …
std::filesystem::path alternative(const std::filesystem::path& path, bool complete, int attempt) {
  std::string name = path.stem().string();
  if (!complete) name += ".partial";
  if (attempt > 1) name.append("-").append(std::to_string(attempt));
  return path.parent_path() / (name + path.extension().string());
}

}  // namespace

MasterWriter::MasterWriter(MasterOptions options) : options_(std::move(options)) {}

MasterWriter::~MasterWriter() {
  if (watermark_) watermark_->close();
}

void MasterWriter::begin(const LineFormat& format, const CaptureContext& context) {
  CHECK(file_ == nullptr);
  layout_ = plan_master(format, make_master_tags(format, context, options_.film),
                        options_.bigtiff_above_bytes);
  auto file =
      std::make_unique<PartFile>(options_.path, PartFile::Kind::kPrecious, Existing::kRefuse);
  try {
    if (options_.reserve_space) reserve_room(*file, layout_.total_bytes);
    file->write_at(kMasterHeadBytes, encode_master_values(layout_, 0));
    watermark_ = std::make_shared<LineWatermark>();
    source_ =
        std::make_shared<MasterFileSource>(format, file->fd(), layout_.data_offset, watermark_);
  } catch (...) {
    file->discard();
    throw;
  }
  file_ = std::move(file);
}

void MasterWriter::lines(const LineBlock& block) {
  CHECK(file_ != nullptr && block.first_line == n_committed_ &&
        block.width_px == layout_.format.width_px &&
        block.n_channels == layout_.format.n_channels() && block.n_lines >= 0 &&
        block.n_lines <= layout_.format.n_lines - n_committed_);
  const std::size_t per_line = layout_.format.samples_per_line();
  interleaved_.resize(per_line * static_cast<std::size_t>(block.n_lines));
  for (int y = 0; y < block.n_lines; ++y) {
    join_line(block, y, interleaved_.data() + per_line * static_cast<std::size_t>(y));
  }

  int error = 0;
  const std::size_t written = file_->write_some_at(layout_.row_offset(n_committed_),
                                                   std::as_bytes(std::span(interleaved_)), error);
  unsynced_bytes_ += written;
  if (error == 0 && unsynced_bytes_ >= kSyncBytes) {
    file_->sync();
    unsynced_bytes_ = 0;
  }
  // Of a block that did not fit, the lines that did are kept.
  const int whole = static_cast<int>(written / layout_.bytes_per_row);
  if (whole > 0) commit(n_committed_ + whole);
  if (error != 0) file_->throw_write_error(error);
}

void MasterWriter::commit(int n_lines) {
  const MasterPatch counts = encode_strip_counts(layout_, n_committed_, n_lines);
  file_->write_at(counts.offset, counts.bytes);
  file_->write_at(0, encode_master_head(layout_, n_lines));
  n_committed_ = n_lines;
  watermark_->raise_to(n_lines);
}

void MasterWriter::end(ScanEnd end) noexcept {
  CHECK(file_ != nullptr);
  result_.n_lines = n_committed_;
  result_.complete = end == ScanEnd::kComplete && n_committed_ == layout_.format.n_lines;
  try {
    publish();
  } catch (...) {
    result_.error = std::current_exception();
    result_.path = file_->part_path();
  }
  watermark_->close();
  file_.reset();
}

void MasterWriter::publish() {
  if (n_committed_ == 0) {
    file_->discard();
    return;
  }
  // Half a line of a full disk, and room reserved for lines that never came.
  if (::ftruncate(file_->fd(), static_cast<off_t>(layout_.row_offset(n_committed_))) != 0) {
    file_->throw_write_error(errno);
  }
  for (int attempt = 1; attempt <= kMaxAlternatives; ++attempt) {
    const auto path = alternative(options_.path, result_.complete, attempt);
    if (!file_->publish_if_absent(path)) continue;
    result_.path = path;
    return;
  }
  throw InputError("All names like '" + options_.path.string() +
                   "' are taken; the scan stays in '" + file_->part_path().string() + "'.");
}

}  // namespace reseau
