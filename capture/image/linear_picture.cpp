#include "capture/image/linear_picture.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <tiffio.h>

#include "capture/image/exr_file.h"
#include "capture/image/tiff_file.h"
#include "capture/store/quoted.h"
#include "core/base/check.h"
#include "core/base/error.h"
#include "core/line/channel_name.h"

namespace reseau {
namespace {

bool is_exr(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension) c = static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
  return extension == ".exr";
}

// Names of ours first, in our order; everything else as the file has it.
std::vector<std::string> order_exr_channels(const std::vector<std::string>& found,
                                            std::vector<std::string>& names) {
  constexpr std::array<std::array<const char*, 2>, 5> kKnown = {
      {{"R", "red"}, {"G", "green"}, {"B", "blue"}, {"IR", "infrared"}, {"Y", "grey"}}};
  std::vector<std::string> out;
  for (const auto& known : kKnown) {
    if (std::find(found.begin(), found.end(), known[0]) == found.end()) continue;
    out.emplace_back(known[0]);
    names.emplace_back(known[1]);
  }
  if (out.empty()) names = out = found;
  return out;
}

}  // namespace

struct LinearPicture::State {
  int width = 0, height = 0;
  std::vector<std::string> channels;
  double lowest = -std::numeric_limits<double>::infinity();
  double highest = std::numeric_limits<double>::infinity();
  double quantum = 0, dpi = 0;
  CaptureContext context;
  std::vector<std::string> notes;
  std::optional<Scan> scan;        // integer TIFF
  std::vector<float> interleaved;  // floats: [row][pixel][channel]
};

namespace {

// Chunky 32-bit floats in strips, as they are; false when the file is none.
bool read_float_tiff(const std::filesystem::path& path, const ReadScanOptions& options, int& width,
                     int& height, int& samples, double& dpi, std::vector<float>& out) {
  TiffFile file(path);
  const TiffPage& page = file.page();
  if (!page.is_float || page.bits != 32 || page.tiled || (page.planar && page.samples > 1)) {
    return false;
  }
  if (page.lines_in_file < page.height_px) {
    throw InputError("The picture " + quoted(path) + " is cut off.");
  }
  width = page.width_px;
  height = page.height_px;
  samples = page.samples;
  dpi = page.x_dpi;
  const std::size_t row = static_cast<std::size_t>(width) * static_cast<std::size_t>(samples);
  out.resize(row * static_cast<std::size_t>(height));
  for (int y = 0; y < height; ++y) {
    if (TIFFReadScanline(file.handle(), &out[row * static_cast<std::size_t>(y)],
                         static_cast<std::uint32_t>(y)) != 1) {
      throw InputError("The picture " + quoted(path) + " is damaged at line " + std::to_string(y) +
                       ".");
    }
  }
  if (options.gamma) {
    for (float& v : out) {
      v = static_cast<float>(std::copysign(std::pow(std::abs(double{v}), *options.gamma), v));
    }
  }
  return true;
}

}  // namespace

LinearPicture::LinearPicture(const std::filesystem::path& path, const ReadScanOptions& options)
    : state_(std::make_unique<State>()) {
  State& s = *state_;
  if (is_exr(path)) {
    const ExrHeader header = read_exr_header(path);
    const std::vector<std::string> wanted = order_exr_channels(header.channels, s.channels);
    FloatImage image = read_exr(path, wanted);
    s.width = image.width_px;
    s.height = image.height_px;
    s.interleaved = std::move(image.samples);
    return;
  }
  int samples = 0;
  if (read_float_tiff(path, options, s.width, s.height, samples, s.dpi, s.interleaved)) {
    constexpr std::array<const char*, 4> kNames = {"red", "green", "blue", "infrared"};
    if (samples <= 2) s.channels.emplace_back("grey");
    for (std::size_t i = s.channels.size(); i < static_cast<std::size_t>(samples); ++i) {
      s.channels.push_back(samples > 2 && i < 4 ? kNames[i] : "sample" + std::to_string(i + 1));
    }
    return;
  }
  ReadScanOptions grey = options;
  grey.allow_grey = true;
  s.scan = read_scan(path, grey);
  const LineFormat& format = s.scan->source->format();
  s.width = format.width_px;
  s.height = format.n_lines;
  for (const Channel channel : format.channels) s.channels.emplace_back(channel_name(channel));
  s.context = s.scan->context;
  s.notes = s.scan->notes;
  s.dpi = format.x_dpi;
  const std::vector<float>& table = s.scan->tone.table(0);
  s.lowest = double{table.front()};
  s.highest = double{table.back()};
  const std::size_t step = s.scan->file_bits == 8 ? 257 : 1;
  for (std::size_t i = step; i < table.size(); i += step) {
    s.quantum = std::max(s.quantum, double{table[i]} - double{table[i - step]});
  }
}

LinearPicture::~LinearPicture() = default;

int LinearPicture::width_px() const { return state_->width; }
int LinearPicture::height_px() const { return state_->height; }
const std::vector<std::string>& LinearPicture::channels() const { return state_->channels; }
double LinearPicture::lowest() const { return state_->lowest; }
double LinearPicture::highest() const { return state_->highest; }
double LinearPicture::quantum() const { return state_->quantum; }
const CaptureContext& LinearPicture::context() const { return state_->context; }
double LinearPicture::dpi() const { return state_->dpi; }
const std::vector<std::string>& LinearPicture::notes() const { return state_->notes; }

std::vector<float> LinearPicture::plane(std::size_t channel, const PixelRect& rect) const {
  const State& s = *state_;
  CHECK(channel < s.channels.size() && rect.x >= 0 && rect.y >= 0 && rect.width > 0 &&
        rect.height > 0 && rect.width <= s.width - rect.x && rect.height <= s.height - rect.y);
  const auto width = static_cast<std::size_t>(rect.width), first = static_cast<std::size_t>(rect.x);
  const auto n = s.channels.size(), whole = static_cast<std::size_t>(s.width);
  std::vector<float> out(width * static_cast<std::size_t>(rect.height));
  std::vector<std::uint16_t> line;
  for (int y = 0; y < rect.height; ++y) {
    float* to = &out[static_cast<std::size_t>(y) * width];
    if (s.scan) {
      line.resize(whole * n);
      s.scan->source->read(rect.y + y, 1, line);
      const std::vector<float>& table = s.scan->tone.table(static_cast<int>(channel));
      const std::uint16_t* from = &line[channel * whole + first];
      for (std::size_t x = 0; x < width; ++x) to[x] = table[from[x]];
    } else {
      const float* from =
          &s.interleaved[(static_cast<std::size_t>(rect.y + y) * whole + first) * n + channel];
      for (std::size_t x = 0; x < width; ++x) to[x] = from[x * n];
    }
  }
  return out;
}

}  // namespace reseau
