#include "capture/image/scan_reader.h"

#include <algorithm>
#include <cerrno>
#include <memory>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <tiffio.h>
#include <unistd.h>

#include "capture/image/icc.h"
#include "capture/image/icc_table.h"
#include "capture/image/infrared_plane.h"
#include "capture/image/tiff_file.h"
#include "capture/image/tiff_pixels.h"
#include "capture/store/master_source.h"
#include "capture/store/master_xmp.h"
#include "capture/store/quoted.h"
#include "core/base/error.h"
#include "core/line/memory_line_source.h"

namespace reseau {
namespace {

std::uint64_t memory_limit(const ReadScanOptions& options) {
  if (options.max_memory_bytes > 0) return options.max_memory_bytes;
  const long pages = ::sysconf(_SC_PHYS_PAGES), page_bytes = ::sysconf(_SC_PAGESIZE);
  if (pages <= 0 || page_bytes <= 0) return std::uint64_t{4} << 30;
  return static_cast<std::uint64_t>(pages) * static_cast<std::uint64_t>(page_bytes) / 4 * 3;
}

void require_supported(const TiffFile& file, const ReadScanOptions& options) {
  const TiffPage& page = file.page();
  const std::string scan = "The scan " + quoted(file.path());
  if (const auto why = unsupported_reason(page); !why.empty()) {
    throw InputError(scan + " cannot be read: " + why + ".");
  }
  if (page.samples == 1 && options.allow_grey) return;
  if (page.samples < 3) {
    throw InputError(scan + " has only " + (page.samples == 1 ? "one channel" : "two channels") +
                     ": the réseau is found in red, green and blue; scan in colour.");
  }
  if (page.samples > 4) {
    throw InputError(scan + " has " + std::to_string(page.samples) +
                     " channels, where red, green, blue and at most infrared are understood.");
  }
}

void require_memory(const TiffFile& file, std::uint64_t limit) {
  const TiffPage& page = file.page();
  // One plane more for infrared that comes apart.
  const std::uint64_t bytes = static_cast<std::uint64_t>(page.lines_in_file) *
                              static_cast<std::uint64_t>(page.width_px) *
                              static_cast<std::uint64_t>(page.samples + 1) * 2;
  if (bytes > limit) {
    throw InputError("The scan " + quoted(file.path()) + " needs " + std::to_string(bytes >> 20) +
                     " MB of memory, more than the " + std::to_string(limit >> 20) +
                     " MB there are for it; save it as an uncompressed 16-bit RGB TIFF, which is "
                     "read piece by piece.");
  }
}

void read_metadata(const TiffFile& file, Scan& scan) {
  scan.context.make = file.text(TIFFTAG_MAKE);
  scan.context.model = file.text(TIFFTAG_MODEL);
  scan.software = file.text(TIFFTAG_SOFTWARE);
  scan.date_time = file.text(TIFFTAG_DATETIME);
  scan.description = file.text(TIFFTAG_IMAGEDESCRIPTION);
  scan.icc = file.blob(TIFFTAG_ICCPROFILE);
  const auto packet = file.blob(TIFFTAG_XMLPACKET);
  const std::string_view text(reinterpret_cast<const char*>(packet.data()), packet.size());
  if (auto xmp = read_master_xmp(text)) {
    scan.context = std::move(xmp->context);
    scan.film = std::move(xmp->film);
  }
}

// Returns true when the samples have to go through the table of the profile.
bool choose_tone(const ReadScanOptions& options, Scan& scan) {
  if (options.gamma) {
    scan.tone = ToneCurves::gamma(*options.gamma);
    if (!scan.icc.empty()) scan.notes.emplace_back("The embedded colour profile is not used.");
  } else if (scan.icc.empty()) {
    scan.notes.emplace_back(
        "The scan has no colour profile and is taken as linear; give the gamma if it is encoded.");
  } else {
    IccTone tone = tone_of_icc(scan.icc);
    scan.tone = std::move(tone.curves);
    scan.notes.push_back(std::move(tone.note));
    return tone.through_table;
  }
  return false;
}

// The scan in memory, red, green and blue as linear light by the profile.
void go_through_table(Scan& scan) {
  const auto table = IccTable::open(scan.icc);
  const LineFormat format = scan.source->format();
  std::vector<std::uint16_t> samples(format.samples_per_line() *
                                     static_cast<std::size_t>(format.n_lines));
  scan.source->read(0, format.n_lines, samples);
  if (const auto n_outside = table->to_linear_light(format, samples); n_outside > 0) {
    scan.notes.push_back(std::to_string(n_outside) +
                         " samples are, by the profile, outside of what ProPhoto RGB holds and "
                         "were clipped.");
  }
  scan.source = std::make_shared<MemoryLineSource>(format, std::move(samples));
}

LineFormat format_of(const TiffPage& page, int n_lines) {
  LineFormat format;
  format.width_px = page.width_px;
  format.n_lines = n_lines;
  format.significant_bits = std::min(page.bits, 16);
  format.x_dpi = page.x_dpi;
  format.y_dpi = page.y_dpi;
  if (page.samples == 1) {
    format.channels = {Channel::kGrey};
    return format;
  }
  format.channels = {Channel::kRed, Channel::kGreen, Channel::kBlue};
  if (page.samples == 4) format.channels.push_back(Channel::kInfrared);
  return format;
}

// Lines that must be there, or those that are, when the person accepts that.
int accepted_lines(const TiffFile& file, const TiffPage& page, int readable,
                   const ReadScanOptions& options, Scan& scan) {
  if (readable >= page.height_px) return page.height_px;
  const std::string counts =
      std::to_string(readable) + " of " + std::to_string(page.height_px) + " lines";
  if (!options.accept_truncated || readable == 0) {
    throw InputError("The scan " + quoted(file.path()) + " is cut off or damaged: " + counts +
                     " can be read.");
  }
  scan.truncated = true;
  scan.notes.push_back("The scan is cut off or damaged; " + counts + " are used.");
  return readable;
}

std::shared_ptr<const LineSource> source_on_disk(const TiffFile& file, const LineFormat& format,
                                                 std::uint64_t offset) {
  const int fd = ::open(file.path().c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) {
    throw std::system_error(errno, std::generic_category(),
                            "The file " + quoted(file.path()) + " cannot be opened");
  }
  auto watermark = std::make_shared<LineWatermark>();
  watermark->raise_to(format.n_lines);
  watermark->close();
  const auto close_fd = [](const int* open_fd) { ::close(*open_fd); };
  const std::unique_ptr<const int, decltype(close_fd)> closer(&fd, close_fd);
  return std::make_shared<MasterFileSource>(format, fd, offset, std::move(watermark));
}

// Infrared from elsewhere, by precedence: the file that was named, a page, a file beside.
std::optional<InfraredPlane> separate_infrared(TiffFile& file, const TiffPage& page,
                                               const ReadScanOptions& options, Scan& scan) {
  if (!options.infrared_file.empty()) {
    scan.infrared = InfraredFrom::kSidecar;
    scan.infrared_path = options.infrared_file;
    return read_infrared_file(options.infrared_file, page.width_px, page.height_px);
  }
  if (page.samples != 3) return std::nullopt;
  if (auto plane = read_infrared_page(file, scan.notes)) {
    if (plane->n_lines == page.height_px) {
      scan.infrared = InfraredFrom::kSecondPage;
      return plane;
    }
    scan.notes.push_back("The page with infrared is cut off or damaged and not used.");
  }
  if (!options.look_for_sidecar) return std::nullopt;
  const auto sidecar = find_infrared_sidecar(file.path());
  if (sidecar.empty()) return std::nullopt;
  try {
    auto plane = read_infrared_file(sidecar, page.width_px, page.height_px);
    scan.infrared = InfraredFrom::kSidecar;
    scan.infrared_path = sidecar;
    return plane;
  } catch (const InputError& error) {
    scan.notes.push_back(std::string(error.what()) + " The scan is used without infrared.");
    return std::nullopt;
  }
}

// [line][4][pixel] to [line][3][pixel]: infrared that another file replaces.
void drop_fourth(std::vector<std::uint16_t>& samples, std::size_t width) {
  const std::size_t n_lines = samples.size() / (4 * width);
  for (std::size_t y = 1; y < n_lines; ++y) {
    std::copy_n(samples.begin() + static_cast<std::ptrdiff_t>(y * 4 * width), 3 * width,
                samples.begin() + static_cast<std::ptrdiff_t>(y * 3 * width));
  }
  samples.resize(n_lines * 3 * width);
}

}  // namespace

Scan read_scan(const std::filesystem::path& path, const ReadScanOptions& options) {
  TiffFile file(path);
  const TiffPage page = file.page();
  require_supported(file, options);

  Scan scan;
  scan.file_bits = page.bits;
  read_metadata(file, scan);
  const bool through_table = choose_tone(options, scan) && page.samples >= 3;
  if (page.orientation != 1) {
    scan.notes.emplace_back(
        "The file asks to be shown turned or mirrored; the pixels are used as they are stored.");
  }
  if (page.samples == 4) scan.infrared = InfraredFrom::kFourthSample;

  // What needs the first page comes before the file moves on to later ones.
  TiffPixels pixels;
  const bool on_disk = page.plain_offset.has_value() && unsupported_reason(page).empty();
  if (!on_disk) {
    require_memory(file, memory_limit(options));
    pixels = decode_page(file);
    if (pixels.n_lines < page.height_px && !file.last_complaint().empty()) {
      scan.notes.push_back("libtiff says: " + file.last_complaint());
    }
  }
  const int n_lines =
      accepted_lines(file, page, on_disk ? page.lines_in_file : pixels.n_lines, options, scan);
  LineFormat format = format_of(page, n_lines);
  if (pixels.n_clamped > 0) {
    scan.notes.push_back(std::to_string(pixels.n_clamped) +
                         " floating-point samples lay outside 0..1 and were clipped.");
  }
  const auto plane =
      page.samples == 1 ? std::nullopt : separate_infrared(file, page, options, scan);
  if (on_disk) scan.source = source_on_disk(file, format, *page.plain_offset);
  if (plane) {
    if (on_disk) {
      require_memory(file, memory_limit(options));
      pixels.samples.resize(format.samples_per_line() * static_cast<std::size_t>(n_lines));
      scan.source->read(0, n_lines, pixels.samples);
    }
    const auto width = static_cast<std::size_t>(page.width_px);
    pixels.samples.resize(format.samples_per_line() * static_cast<std::size_t>(n_lines));
    if (page.samples == 4) {
      drop_fourth(pixels.samples, width);
      format.channels.pop_back();
    }
    pixels.samples = with_plane(pixels.samples, 3, width, *plane, n_lines);
    format.channels.push_back(Channel::kInfrared);
    scan.source.reset();
  }
  if (!scan.source) {
    scan.source = std::make_shared<MemoryLineSource>(format, std::move(pixels.samples));
  }
  if (through_table) {
    require_memory(file, memory_limit(options));
    go_through_table(scan);
  }
  return scan;
}

}  // namespace reseau
