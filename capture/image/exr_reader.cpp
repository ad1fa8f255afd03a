#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfCompressionAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfStandardAttributes.h>
#include <OpenEXR/ImfStringAttribute.h>
#include <OpenEXR/ImfTestFile.h>
#include <OpenEXR/ImfThreading.h>
#include <fcntl.h>
#include <unistd.h>

#include "capture/image/exr_file.h"
#include "capture/store/quoted.h"
#include "core/base/check.h"
#include "core/base/error.h"

namespace reseau {
namespace {

constexpr std::int64_t kMaxExrSide = 1'000'000;
// All compressions of EXR together do not shrink a picture of floats further.
constexpr std::uintmax_t kMaxExrCompression = 5000;
constexpr std::uintmax_t kSmallestSuspectExr = std::uintmax_t{256} << 20;

void require_exr(const std::filesystem::path& path) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) {
    throw InputError(quoted(path) + " is a folder; give an OpenEXR file.");
  }
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (fd < 0) {
    if (errno == ENOENT || errno == ENOTDIR) {
      throw InputError("There is no file " + quoted(path) + ".");
    }
    throw std::system_error(errno, std::generic_category(),
                            "The file " + quoted(path) + " cannot be opened");
  }
  ::close(fd);
  if (!std::filesystem::is_regular_file(path, ignored) || !Imf::isOpenExrFile(path.c_str())) {
    throw InputError("The file " + quoted(path) + " is not an OpenEXR picture.");
  }
}

InputError cut_off(const std::filesystem::path& path, const std::exception& error) {
  return InputError("The picture " + quoted(path) + " is cut off or damaged (" + error.what() +
                    ").");
}

}  // namespace

struct ExrReader::State {
  State(std::filesystem::path file_path, std::vector<std::string> names)
      : path(std::move(file_path)), channels(std::move(names)) {
    require_exr(path);
    Imf::setGlobalThreadCount(static_cast<int>(std::max(1U, std::thread::hardware_concurrency())));
    try {
      input = std::make_unique<Imf::InputFile>(path.c_str());
    } catch (const std::exception& error) {
      throw InputError("The file " + quoted(path) + " is a damaged OpenEXR picture (" +
                       error.what() + ").");
    }
    window = input->header().dataWindow();
    require_size();
    require_channels();
    plan_stored_rows();
  }

  void require_size() const {
    const auto across = static_cast<std::int64_t>(window.max.x) - window.min.x + 1;
    const auto down = static_cast<std::int64_t>(window.max.y) - window.min.y + 1;
    const bool sane = across > 0 && down > 0 && across <= kMaxExrSide && down <= kMaxExrSide;
    const auto bytes = sane
                           ? static_cast<std::uintmax_t>(across) *
                                 static_cast<std::uintmax_t>(down) * channels.size() * sizeof(float)
                           : 0;
    if (!sane || (bytes > kSmallestSuspectExr &&
                  bytes / kMaxExrCompression > std::filesystem::file_size(path))) {
      throw InputError("The file " + quoted(path) + " claims " + std::to_string(across) + " x " +
                       std::to_string(down) + " pixels, which cannot be; it is damaged.");
    }
  }

  void require_channels() const {
    const auto& list = input->header().channels();
    std::string there;
    for (auto it = list.begin(); it != list.end(); ++it) {
      if (!there.empty()) there += ", ";
      there += it.name();
    }
    for (const auto& name : channels) {
      const auto* channel = list.findChannel(name);
      if (channel == nullptr) {
        throw InputError("The picture " + quoted(path) + " has no channel '" + name +
                         "'; it has: " + there + ".");
      }
      if (channel->xSampling != 1 || channel->ySampling != 1) {
        throw InputError("The channel '" + name + "' of " + quoted(path) +
                         " is stored at a lower resolution, which is not understood.");
      }
    }
  }

  [[nodiscard]] int width() const { return window.max.x - window.min.x + 1; }
  [[nodiscard]] int height() const { return window.max.y - window.min.y + 1; }

  // A stored row is the channels one after another, alphabetically, as they lie in memory here;
  // OpenEXR would take it apart byte by byte. Other files are left to OpenEXR.
  void plan_stored_rows() {
    const Imf::Header& header = input->header();
    if (std::endian::native != std::endian::little || header.hasTileDescription() ||
        header.compression() != Imf::NO_COMPRESSION) {
      return;
    }
    std::vector<std::size_t> begin(channels.size(), 0);
    std::size_t bytes = 0;
    for (auto it = header.channels().begin(); it != header.channels().end(); ++it) {
      const Imf::Channel& channel = it.channel();
      if (channel.xSampling != 1 || channel.ySampling != 1) return;
      for (std::size_t c = 0; c < channels.size(); ++c) {
        if (channels[c] != it.name()) continue;
        if (channel.type != Imf::FLOAT) return;
        begin[c] = bytes;
      }
      bytes += static_cast<std::size_t>(width()) *
               (channel.type == Imf::HALF ? sizeof(std::uint16_t) : sizeof(float));
    }
    if (bytes > std::numeric_limits<int>::max()) return;
    channel_begin = std::move(begin);
    stored_row.resize(bytes);
  }

  void read_stored_row(int row, float* out) {
    int size = static_cast<int>(stored_row.size());
    input->rawPixelDataToBuffer(window.min.y + row, stored_row.data(), size);
    if (size != static_cast<int>(stored_row.size())) throw Iex::InputExc("A row is too short");
    const std::size_t n = channels.size();
    const auto across = static_cast<std::size_t>(width());
    const auto sample = [&](std::size_t c, std::size_t x) {
      float value = 0;
      std::memcpy(&value, stored_row.data() + channel_begin[c] + x * sizeof(float), sizeof(float));
      return value;
    };
    if (n == 3) {
      for (std::size_t x = 0; x < across; ++x, out += 3) {
        out[0] = sample(0, x);
        out[1] = sample(1, x);
        out[2] = sample(2, x);
      }
      return;
    }
    for (std::size_t c = 0; c < n; ++c) {
      for (std::size_t x = 0; x < across; ++x) out[x * n + c] = sample(c, x);
    }
  }

  std::filesystem::path path;
  std::vector<std::string> channels;
  std::unique_ptr<Imf::InputFile> input;
  IMATH_NAMESPACE::Box2i window;
  // Of files whose rows are stored: where each channel begins, and one row [bytes].
  std::vector<std::size_t> channel_begin;
  std::vector<char> stored_row;
};

ExrReader::ExrReader(const std::filesystem::path& path, const std::vector<std::string>& channels)
    : state_(std::make_unique<State>(path, channels)) {}

ExrReader::~ExrReader() = default;
ExrReader::ExrReader(ExrReader&&) noexcept = default;
ExrReader& ExrReader::operator=(ExrReader&&) noexcept = default;

int ExrReader::width_px() const { return state_->width(); }
int ExrReader::height_px() const { return state_->height(); }

std::optional<Chromaticities> ExrReader::chromaticities() const {
  const auto& header = state_->input->header();
  if (!Imf::hasChromaticities(header)) return std::nullopt;
  const Imf::Chromaticities& from = Imf::chromaticities(header);
  Chromaticities to;
  const std::array<IMATH_NAMESPACE::V2f, 4> points = {from.red, from.green, from.blue, from.white};
  for (std::size_t i = 0; i < points.size(); ++i) {
    to.xy[i] = {static_cast<double>(points[i].x), static_cast<double>(points[i].y)};
  }
  return to;
}

std::optional<Chromaticity> ExrReader::adopted_neutral() const {
  const auto& header = state_->input->header();
  if (!Imf::hasAdoptedNeutral(header)) return std::nullopt;
  const IMATH_NAMESPACE::V2f& xy = Imf::adoptedNeutral(header);
  return Chromaticity{static_cast<double>(xy.x), static_cast<double>(xy.y)};
}

std::optional<std::string> ExrReader::attribute(const std::string& name) const {
  const auto* found =
      state_->input->header().findTypedAttribute<Imf::StringAttribute>(name.c_str());
  if (found == nullptr) return std::nullopt;
  return found->value();
}

void ExrReader::read(int first_row, int n_rows, std::span<float> out) {
  const std::size_t row_samples =
      static_cast<std::size_t>(state_->width()) * state_->channels.size();
  CHECK(first_row >= 0 && n_rows >= 0 && n_rows <= state_->height() - first_row &&
        out.size() == row_samples * static_cast<std::size_t>(n_rows));
  if (n_rows == 0) return;
  if (!state_->stored_row.empty()) {
    try {
      for (int y = 0; y < n_rows; ++y) {
        state_->read_stored_row(first_row + y,
                                out.data() + row_samples * static_cast<std::size_t>(y));
      }
    } catch (const std::exception& error) {
      throw cut_off(state_->path, error);
    }
    return;
  }
  Imf::FrameBuffer frame;
  const std::size_t x_stride = state_->channels.size() * sizeof(float);
  const IMATH_NAMESPACE::V2i origin(state_->window.min.x, state_->window.min.y + first_row);
  for (std::size_t c = 0; c < state_->channels.size(); ++c) {
    frame.insert(state_->channels[c],
                 Imf::Slice::Make(Imf::FLOAT, out.data() + c, origin, state_->width(), n_rows,
                                  x_stride, row_samples * sizeof(float)));
  }
  try {
    state_->input->setFrameBuffer(frame);
    state_->input->readPixels(origin.y, origin.y + n_rows - 1);
  } catch (const std::exception& error) {
    throw cut_off(state_->path, error);
  }
}

ExrHeader read_exr_header(const std::filesystem::path& path) {
  const ExrReader reader(path, {});
  const Imf::Header& header = reader.state_->input->header();
  ExrHeader result;
  result.width_px = reader.width_px();
  result.height_px = reader.height_px();
  result.chromaticities = reader.chromaticities();
  for (auto it = header.channels().begin(); it != header.channels().end(); ++it) {
    result.channels.emplace_back(it.name());
  }
  for (auto it = header.begin(); it != header.end(); ++it) {
    const auto* text = dynamic_cast<const Imf::StringAttribute*>(&it.attribute());
    if (text != nullptr) result.attributes.emplace_back(it.name(), text->value());
  }
  return result;
}

FloatImage read_exr(const std::filesystem::path& path, const std::vector<std::string>& channels) {
  ExrReader reader(path, channels);
  FloatImage image;
  image.width_px = reader.width_px();
  image.height_px = reader.height_px();
  image.channels = channels;
  image.samples.resize(static_cast<std::size_t>(image.width_px) *
                       static_cast<std::size_t>(image.height_px) * channels.size());
  reader.read(0, image.height_px, image.samples);
  return image;
}

}  // namespace reseau
