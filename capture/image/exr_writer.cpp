#include <algorithm>
#include <thread>

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfStandardAttributes.h>
#include <OpenEXR/ImfStringAttribute.h>
#include <OpenEXR/ImfThreading.h>

#include "capture/image/exr_file.h"
#include "core/base/check.h"
#include "core/base/error.h"

namespace reseau {
namespace {

// Rows given to OpenEXR at once: enough that each thread has a block of its own to compress.
constexpr int kBandRows = 64;

// OpenEXR's stream onto our part file. Its own streams know neither locks nor what went wrong.
class PartStream final : public Imf::OStream {
 public:
  explicit PartStream(const PartFile& file)
      : Imf::OStream(file.final_path().c_str()), file_(file) {}
  void write(const char data[], int n) override {
    int error = 0;
    const auto bytes = std::as_bytes(std::span(data, static_cast<std::size_t>(n)));
    file_.write_some_at(position_, bytes, error);
    if (error != 0) {
      error_ = error;
      file_.throw_write_error(error);
    }
    position_ += static_cast<std::uint64_t>(n);
  }
  std::uint64_t tellp() override { return position_; }
  void seekp(std::uint64_t position) override { position_ = position; }
  [[nodiscard]] int error() const { return error_; }

 private:
  const PartFile& file_;
  std::uint64_t position_ = 0;
  int error_ = 0;
};

Imf::Header make_header(int width_px, int height_px, const std::vector<std::string>& channels,
                        const ExrOptions& options) {
  Imf::Header header(width_px, height_px);
  header.compression() =
      options.compression == ExrCompression::kSmall ? Imf::PIZ_COMPRESSION : Imf::NO_COMPRESSION;
  for (const auto& name : channels) header.channels().insert(name, Imf::Channel(Imf::FLOAT));
  if (options.chromaticities) {
    const auto& xy = options.chromaticities->xy;
    const auto point = [&](std::size_t i) {
      return IMATH_NAMESPACE::V2f(static_cast<float>(xy[i][0]), static_cast<float>(xy[i][1]));
    };
    Imf::addChromaticities(header, Imf::Chromaticities(point(0), point(1), point(2), point(3)));
  }
  if (options.adopted_neutral) {
    Imf::addAdoptedNeutral(header, {static_cast<float>((*options.adopted_neutral)[0]),
                                    static_cast<float>((*options.adopted_neutral)[1])});
  }
  if (options.white_luminance) {
    Imf::addWhiteLuminance(header, static_cast<float>(*options.white_luminance));
  }
  for (const auto& [name, value] : options.attributes) {
    header.insert(name, Imf::StringAttribute(value));
  }
  return header;
}

}  // namespace

struct FloatImageWriter::State {
  State(const std::filesystem::path& path, int width_px, int height_px,
        std::vector<std::string> channel_names, const ExrOptions& options)
      : width(width_px),
        height(height_px),
        channels(std::move(channel_names)),
        file(path, PartFile::Kind::kScratch, options.existing),
        stream(file) {
    Imf::setGlobalThreadCount(static_cast<int>(std::max(1U, std::thread::hardware_concurrency())));
    run([&] {
      output =
          std::make_unique<Imf::OutputFile>(stream, make_header(width, height, channels, options));
    });
    band.resize(row_samples() * static_cast<std::size_t>(std::min(kBandRows, height)));
  }

  [[nodiscard]] std::size_t row_samples() const {
    return static_cast<std::size_t>(width) * channels.size();
  }

  // OpenEXR turns our exceptions into its own; the errno tells what really happened.
  template <typename Action>
  void run(const Action& action) {
    try {
      action();
    } catch (const std::system_error&) {
      throw;
    } catch (const std::exception& error) {
      if (stream.error() != 0) file.throw_write_error(stream.error());
      throw std::system_error(std::make_error_code(std::errc::io_error),
                              std::string("The picture cannot be written: ") + error.what());
    }
  }

  void flush() {
    if (n_in_band == 0) return;
    Imf::FrameBuffer frame;
    const std::size_t x_stride = channels.size() * sizeof(float);
    const std::size_t y_stride = x_stride * static_cast<std::size_t>(width);
    for (std::size_t c = 0; c < channels.size(); ++c) {
      // Slices are addressed from row 0 of the picture, which lies before the band.
      frame.insert(channels[c],
                   Imf::Slice::Make(Imf::FLOAT, band.data() + c, IMATH_NAMESPACE::V2i(0, n_written),
                                    width, n_in_band, x_stride, y_stride));
    }
    run([&] {
      output->setFrameBuffer(frame);
      output->writePixels(n_in_band);
    });
    n_written += n_in_band;
    n_in_band = 0;
  }

  void add(std::span<const float> samples) {
    while (!samples.empty()) {
      const auto room = static_cast<std::size_t>(kBandRows - n_in_band) * row_samples();
      const auto n = std::min(room, samples.size());
      std::copy_n(samples.begin(), n,
                  band.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(n_in_band) *
                                                             row_samples()));
      n_in_band += static_cast<int>(n / row_samples());
      samples = samples.subspan(n);
      if (n_in_band == kBandRows) flush();
    }
  }

  int width, height;
  std::vector<std::string> channels;
  PartFile file;
  PartStream stream;
  std::unique_ptr<Imf::OutputFile> output;
  std::vector<float> band;
  int n_in_band = 0, n_written = 0;
};

FloatImageWriter::FloatImageWriter(const std::filesystem::path& path, int width_px, int height_px,
                                   const std::vector<std::string>& channels,
                                   const ExrOptions& options) {
  CHECK(width_px > 0 && height_px > 0 && !channels.empty());
  state_ = std::make_unique<State>(path, width_px, height_px, channels, options);
}

FloatImageWriter::~FloatImageWriter() = default;
FloatImageWriter::FloatImageWriter(FloatImageWriter&&) noexcept = default;
FloatImageWriter& FloatImageWriter::operator=(FloatImageWriter&&) noexcept = default;

void FloatImageWriter::rows(int first_row, int n_rows, std::span<const float> samples) {
  CHECK(state_ && n_rows >= 0 && first_row == state_->n_written + state_->n_in_band &&
        n_rows <= state_->height - first_row &&
        samples.size() == state_->row_samples() * static_cast<std::size_t>(n_rows));
  state_->add(samples);
}

void FloatImageWriter::finish() {
  CHECK(state_ && state_->n_written + state_->n_in_band == state_->height);
  state_->flush();
  // The line table is written by the destructor of OutputFile, which cannot report a full disk.
  state_->output.reset();
  if (state_->stream.error() != 0) state_->file.throw_write_error(state_->stream.error());
  state_->file.publish();
}

}  // namespace reseau
