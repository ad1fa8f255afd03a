#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfStandardAttributes.h>
#include <OpenEXR/ImfStringAttribute.h>
#include <OpenEXR/ImfThreading.h>

#include "capture/image/exr_file.h"
#include "capture/store/sha256.h"
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
    follow(bytes);
    position_ += static_cast<std::uint64_t>(n);
  }
  std::uint64_t tellp() override { return position_; }
  void seekp(std::uint64_t position) override { position_ = position; }
  [[nodiscard]] int error() const { return error_; }

  // The hash of a file whose rows are stored, made as it is written. Only the table of where each
  // row begins is written last, and of stored rows it is known before: what was said here is
  // compared with what comes.
  void foresee_table(int n_rows, std::size_t row_bytes) {
    const std::size_t table_bytes = static_cast<std::size_t>(n_rows) * sizeof(std::uint64_t);
    if (head_.size() != position_ || head_.size() < table_bytes) return;
    std::uint64_t offset = head_.size();
    for (std::size_t at = head_.size() - table_bytes; at < head_.size(); at += sizeof offset) {
      for (std::size_t i = 0; i < sizeof offset; ++i) {
        head_[at + i] = static_cast<std::byte>(offset >> (8 * i) & 0xff);
      }
      offset += kRowHeadBytes + row_bytes;
    }
    hash_.emplace();
    hash_->add(head_);
    hashed_ = head_.size();
  }
  // Nothing when the file was not written as foreseen.
  [[nodiscard]] std::optional<std::string> hash() {
    if (!hash_ || hashed_ < head_.size()) return std::nullopt;
    return hash_->hex();
  }

 private:
  static constexpr std::size_t kRowHeadBytes = 8;  // its number and its size

  void follow(std::span<const std::byte> bytes) {
    if (!hash_) {
      if (position_ == head_.size()) head_.insert(head_.end(), bytes.begin(), bytes.end());
      return;
    }
    if (position_ == hashed_) {
      hash_->add(bytes);
      hashed_ += bytes.size();
    } else if (position_ + bytes.size() > head_.size() ||
               !std::equal(bytes.begin(), bytes.end(),
                           head_.begin() + static_cast<std::ptrdiff_t>(position_))) {
      hash_.reset();
      head_.clear();
    }
  }

  const PartFile& file_;
  std::uint64_t position_ = 0;
  int error_ = 0;
  std::vector<std::byte> head_;  // up to the first row, the table as foreseen
  std::optional<Sha256> hash_;
  std::uint64_t hashed_ = 0;
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
    if (options.compression == ExrCompression::kNone) {
      stream.foresee_table(height, row_samples() * sizeof(float));
    }
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

  void write(const float* samples, int n_rows) {
    if (n_rows == 0) return;
    Imf::FrameBuffer frame;
    const std::size_t x_stride = channels.size() * sizeof(float);
    const std::size_t y_stride = x_stride * static_cast<std::size_t>(width);
    // OpenEXR wants to be able to write where it only reads.
    auto* const at = const_cast<float*>(samples);
    for (std::size_t c = 0; c < channels.size(); ++c) {
      // Slices are addressed from row 0 of the picture, which lies before these.
      frame.insert(channels[c],
                   Imf::Slice::Make(Imf::FLOAT, at + c, IMATH_NAMESPACE::V2i(0, n_written), width,
                                    n_rows, x_stride, y_stride));
    }
    run([&] {
      output->setFrameBuffer(frame);
      output->writePixels(n_rows);
    });
    n_written += n_rows;
  }

  void flush() {
    write(band.data(), n_in_band);
    n_in_band = 0;
  }

  void add(std::span<const float> samples) {
    const std::size_t whole = static_cast<std::size_t>(kBandRows) * row_samples();
    while (!samples.empty()) {
      std::size_t n = 0;
      if (n_in_band == 0 && samples.size() >= whole) {
        n = whole;
        write(samples.data(), kBandRows);
      } else {
        const std::size_t there = static_cast<std::size_t>(n_in_band) * row_samples();
        n = std::min(whole - there, samples.size());
        std::copy_n(samples.begin(), n, band.begin() + static_cast<std::ptrdiff_t>(there));
        n_in_band += static_cast<int>(n / row_samples());
        if (n_in_band == kBandRows) flush();
      }
      samples = samples.subspan(n);
    }
  }

  int width, height;
  std::vector<std::string> channels;
  PartFile file;
  PartStream stream;
  std::unique_ptr<Imf::OutputFile> output;
  std::vector<float> band;
  int n_in_band = 0, n_written = 0;
  std::optional<std::string> sha256;
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
  state_->sha256 = state_->stream.hash();
}

std::string FloatImageWriter::sha256() const {
  CHECK(state_ && state_->output == nullptr);
  return state_->sha256 ? *state_->sha256 : sha256_of_file(state_->file.final_path());
}

}  // namespace reseau
