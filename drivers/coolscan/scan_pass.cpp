#include "drivers/coolscan/scan_pass.h"

#include <algorithm>
#include <string>
#include <variant>

#include "core/base/error.h"

namespace reseau::coolscan {
namespace {

using namespace std::chrono_literals;

// Whole lines up to this size are safe in one READ; Nikon Scan used 131072 and more.
constexpr int kMaxReadBytes = 128 * 1024;
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

}  // namespace

ScanPass::ScanPass(Unit& unit, const PassSpec& spec, int max_packet_bytes)
    : unit_(unit),
      layout_{spec.window.width_px / spec.pitch, spec.infrared ? 4 : 3, spec.window.bits, {}},
      crop_left_px_(spec.crop_left_px),
      crop_width_px_(spec.crop_width_px),
      lines_left_(spec.window.height_px / spec.pitch) {
  CHECK(crop_left_px_ + crop_width_px_ <= layout_.width_px && lines_left_ > 0);
  const std::vector<Colour> colours = colours_of(spec);
  set_windows(spec, colours);
  apply(unit_.start_scan(colours), max_packet_bytes);
}

void ScanPass::set_windows(const PassSpec& spec, const std::vector<Colour>& colours) {
  for (const Colour colour : colours) {
    Window window = spec.window;
    window.colour = colour;
    window.exposure_10ns = spec.exposures[exposure_index(colour)];
    unit_.set_window(window);
  }
}

void ScanPass::apply(const std::vector<CooperationRecord>& records, int max_packet_bytes) {
  layout_.padding =
      computed_padding(layout_.width_px, layout_.n_colours, layout_.bits, max_packet_bytes);
  for (const CooperationRecord& record : records) {
    if (const auto* padding = std::get_if<PaddingRecord>(&record)) layout_.padding = *padding;
    const auto* line = std::get_if<LineRecord>(&record);
    if (line != nullptr && line->type != 2) {
      throw DeviceError(DeviceError::Kind::kProtocol,
                        "The scanner wants to deliver the picture in a way that this program did "
                        "not ask for. Please record the session with --record and report it.",
                        "cooperation record of type " + std::to_string(line->type));
    }
  }
  top_lines_left_ = layout_.padding.top_lines;
  wire_lines_left_ = lines_left_ + layout_.padding.top_lines + layout_.padding.bottom_lines;
}

int ScanPass::read(std::vector<std::uint16_t>& samples) {
  const auto line_bytes = static_cast<std::size_t>(layout_.line_bytes());
  const auto line_samples =
      static_cast<std::size_t>(layout_.n_colours) * static_cast<std::size_t>(crop_width_px_);
  const int lines_per_read = std::max(1, kMaxReadBytes / layout_.line_bytes());
  int n_delivered = 0;
  // A READ of nothing but padding lines delivers none: go on to the next.
  while (n_delivered == 0 && wire_lines_left_ > 0) {
    const int n_wire = std::min(lines_per_read, wire_lines_left_);
    buffer_.resize(static_cast<std::size_t>(n_wire) * line_bytes);
    unit_.read_image(buffer_, layout_.bytes_per_sample(),
                     first_read_ ? kFirstReadTimeout : kReadTimeout);
    first_read_ = false;
    wire_lines_left_ -= n_wire;
    if (wire_lines_left_ == 0) unit_.scan_drained();

    const int n_skipped = std::min(top_lines_left_, n_wire);
    top_lines_left_ -= n_skipped;
    n_delivered = std::min(n_wire - n_skipped, lines_left_);
    lines_left_ -= n_delivered;
    const std::size_t needed = static_cast<std::size_t>(n_delivered) * line_samples;
    if (samples.size() < needed) samples.resize(needed);
    for (int i = 0; i < n_delivered; ++i) {
      const auto from = static_cast<std::size_t>(n_skipped + i) * line_bytes;
      const auto to = static_cast<std::size_t>(i) * line_samples;
      decode_line(layout_, ByteView(buffer_).subspan(from, line_bytes), crop_left_px_,
                  crop_width_px_, std::span(samples).subspan(to, line_samples));
    }
  }
  return n_delivered;
}

}  // namespace reseau::coolscan
