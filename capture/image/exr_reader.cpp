#include <algorithm>
#include <cerrno>
#include <system_error>
#include <thread>

#include <OpenEXR/ImfChannelList.h>
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

  std::filesystem::path path;
  std::vector<std::string> channels;
  std::unique_ptr<Imf::InputFile> input;
  IMATH_NAMESPACE::Box2i window;
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
    throw InputError("The picture " + quoted(state_->path) + " is cut off or damaged (" +
                     error.what() + ").");
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
