#include "drivers/coolscan/scan_pass.h"

#include <algorithm>
#include <string>
#include <variant>

#include "core/base/error.h"

namespace reseau::coolscan {
namespace {

using namespace std::chrono_literals;

// Whole records up to this size are safe in one READ; Nikon Scan used 131072 and more.
constexpr std::size_t kMaxReadBytes = 128 * 1024;
// The first READ of a pass may wait for the stage.
constexpr Duration kFirstReadTimeout = 180s;
constexpr Duration kReadTimeout = 30s;

std::vector<Colour> colours_of(const PassSpec& spec) {
  std::vector<Colour> colours = {Colour::kRed, Colour::kGreen, Colour::kBlue};
  // Nikon Scan names infrared first; the order does not change the data.
  if (spec.infrared) colours.insert(colours.begin(), Colour::kInfrared);
  return colours;
}

std::size_t exposure_index(Colour colour) {
  return colour == Colour::kInfrared ? 3 : static_cast<std::size_t>(colour) - 1;
}

DeviceError unasked(const std::string& what) {
  return {DeviceError::Kind::kProtocol,
          "The scanner wants to deliver the picture in a way that this program did not ask for. "
          "Please record the session with --record and report it.",
          what};
}

LineTables tables_of(const CurveSet& curves, const CurveRecord& record, const PassSpec& spec) {
  LineTables tables;
  const std::size_t n_colours = spec.infrared ? 4 : 3;
  for (std::size_t c = 0; c < n_colours; ++c) {
    tables.emplace_back();
    // The record names no type for infrared; red's stands in.
    const int type = record.curve_types.at(c < 3 ? c : 0);
    for (int line = 0; line < spec.sensor_lines; ++line) {
      tables.back().push_back(curves[c] ? curves[c]->table(line, type)
                                        : std::vector<std::uint16_t>{});
    }
  }
  return tables;
}

}  // namespace

ScanPass::ScanPass(Unit& unit, const PassSpec& spec, const PassRules& rules, const CurveSet& curves)
    : unit_(unit),
      rules_(rules),
      is_thumbnail_(spec.window.kind == ScanKind::kThumbnail),
      decoder_(decoder_for(spec, rules, curves, open(spec))),
      lines_left_(spec.crop_n_lines) {
  const RecordLayout& layout = decoder_.layout();
  const int window_lines = spec.window.height_px / spec.pitch;
  CHECK(spec.crop_n_lines > 0 && spec.crop_top_lines + spec.crop_n_lines <= window_lines);
  skip_lines_ = layout.padding.top_lines + spec.crop_top_lines;
  const int wire_lines = window_lines + layout.padding.top_lines + layout.padding.bottom_lines;
  const int per_block = layout.lines_per_block();
  records_left_ = (wire_lines + per_block - 1) / per_block * layout.gap;
}

std::vector<CooperationRecord> ScanPass::open(const PassSpec& spec) {
  const std::vector<Colour> colours = colours_of(spec);
  set_windows(spec, colours);
  return unit_.start_scan(colours);
}

void ScanPass::set_windows(const PassSpec& spec, const std::vector<Colour>& colours) {
  for (const Colour colour : colours) {
    Window window = spec.window;
    window.colour = colour;
    window.exposure_10ns = spec.exposures[exposure_index(colour)];
    unit_.set_window(window);
  }
}

BlockDecoder ScanPass::decoder_for(const PassSpec& spec, const PassRules& rules,
                                   const CurveSet& curves,
                                   const std::vector<CooperationRecord>& records) {
  RecordLayout layout;
  layout.width_px = spec.window.width_px / spec.pitch;
  layout.n_colours = spec.infrared ? 4 : 3;
  layout.bits = spec.window.bits;
  layout.sensor_lines = spec.sensor_lines;
  layout.gap = spec.gap;
  layout.readings = spec.window.readings;
  layout.padding = computed_padding(layout, rules.packet_bytes, rules.even_colours);
  LineTables corrections;
  for (const CooperationRecord& record : records) {
    if (const auto* padding = std::get_if<PaddingRecord>(&record)) layout.padding = *padding;
    if (const auto* types = std::get_if<CurveRecord>(&record)) {
      corrections = tables_of(curves, *types, spec);
    }
    const auto* line = std::get_if<LineRecord>(&record);
    if (line == nullptr) continue;
    const bool thumbnail = line->type == 1 && spec.window.kind == ScanKind::kThumbnail;
    const bool readings = line->type == 2 && line->readings == layout.readings;
    const bool registered = line->type == 4 && line->registration_gap == layout.gap;
    if (!thumbnail && !readings && !registered) {
      throw unasked("cooperation record of type " + std::to_string(line->type) + ", readings " +
                    std::to_string(line->readings) + ", gap " +
                    std::to_string(line->registration_gap));
    }
  }
  return {layout, spec.crop_left_px, spec.crop_width_px, corrections};
}

// Fills the buffer with whole blocks; returns how many came.
int ScanPass::read_records() {
  const RecordLayout& layout = decoder_.layout();
  const std::size_t block_bytes = layout.block_bytes(), record_bytes = layout.record_bytes();
  const int blocks_left = records_left_ / layout.gap;
  const auto fitting =
      static_cast<int>(std::min<std::size_t>(kMaxReadBytes / block_bytes, 1 << 20));
  const int n_blocks = std::min(std::max(1, fitting), blocks_left);
  buffer_.resize(static_cast<std::size_t>(n_blocks) * block_bytes);
  // One READ where the blocks fit into it, else record by record, or in any pieces where the unit
  // does not ask for whole records.
  std::size_t piece = buffer_.size();
  if (piece > kMaxReadBytes) {
    const std::size_t records = std::max<std::size_t>(1, kMaxReadBytes / record_bytes);
    piece = rules_.whole_records ? records * record_bytes : kMaxReadBytes;
  }
  std::size_t done = 0;
  while (done < buffer_.size()) {
    const std::size_t n = std::min(piece, buffer_.size() - done);
    const std::size_t got =
        unit_.read_image(std::span(buffer_).subspan(done, n), layout.bytes_per_sample(),
                         first_read_ ? kFirstReadTimeout : kReadTimeout);
    first_read_ = false;
    done += got;
    if (got == n) continue;
    if (!is_thumbnail_) throw unasked("the picture ended after " + std::to_string(done) + " bytes");
    records_left_ = 0;
    return static_cast<int>(done / block_bytes);
  }
  records_left_ -= n_blocks * layout.gap;
  if (records_left_ == 0) unit_.scan_drained();
  return n_blocks;
}

int ScanPass::read(std::vector<std::uint16_t>& samples) {
  const RecordLayout& layout = decoder_.layout();
  const int per_block = layout.lines_per_block();
  int n_delivered = 0;
  std::size_t used = 0;
  // A READ of nothing but lines to skip delivers none: go on to the next.
  while (n_delivered == 0 && records_left_ > 0) {
    const int n_blocks = read_records();
    for (int b = 0; b < n_blocks; ++b) {
      const ByteView block = ByteView(buffer_).subspan(
          static_cast<std::size_t>(b) * layout.block_bytes(), layout.block_bytes());
      const std::size_t block_samples = decoder_.block_samples();
      if (samples.size() < used + block_samples) samples.resize(used + block_samples);
      const auto out = std::span(samples).subspan(used, block_samples);
      decoder_.decode(block, out);
      const int n_skipped = std::min(skip_lines_, per_block);
      skip_lines_ -= n_skipped;
      const int n = std::min(per_block - n_skipped, lines_left_);
      lines_left_ -= n;
      n_delivered += n;
      const std::size_t line_samples = block_samples / static_cast<std::size_t>(per_block);
      const auto skipped =
          static_cast<std::ptrdiff_t>(static_cast<std::size_t>(n_skipped) * line_samples);
      const std::size_t n_samples = static_cast<std::size_t>(n) * line_samples;
      if (skipped > 0) std::copy_n(out.begin() + skipped, n_samples, out.begin());
      used += n_samples;
    }
  }
  return n_delivered;
}

}  // namespace reseau::coolscan
