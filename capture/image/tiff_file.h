#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

struct tiff;

namespace reseau {

// One directory of a TIFF, as far as scans need it.
struct TiffPage {
  int width_px = 0, height_px = 0;
  int samples = 1;  // per pixel
  int bits = 8;     // per sample
  bool is_float = false, is_unsigned = true;
  bool planar = false, tiled = false, compressed = false;
  bool reduced = false;  // a thumbnail of another page
  int photometric = 0;   // PhotometricInterpretation, TIFF 6.0
  int orientation = 1;
  double x_dpi = 0, y_dpi = 0;  // 0 = unknown
  // Lines whose strips or tiles lie wholly inside the file (for uncompressed strips: to the line).
  int lines_in_file = 0;
  // Where the pixels start when they lie in one uncompressed run of chunky samples in the byte
  // order of the machine.
  std::optional<std::uint64_t> plain_offset;

  [[nodiscard]] std::uint64_t row_bytes() const {
    return static_cast<std::uint64_t>(width_px) * static_cast<std::uint64_t>(samples) *
           static_cast<std::uint64_t>(bits) / 8;
  }
};

// A TIFF opened for reading through libtiff, whose messages are kept per file. Thread-bound.
class TiffFile {
 public:
  // Throws InputError for what is not a whole TIFF (nothing there, folder, empty, other format,
  // directory cut off, absurd dimensions), std::system_error when the system refuses.
  explicit TiffFile(const std::filesystem::path& path);
  ~TiffFile();
  TiffFile(const TiffFile&) = delete;
  TiffFile& operator=(const TiffFile&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] std::uint64_t file_bytes() const { return file_bytes_; }
  // Of the current directory; the first after construction.
  [[nodiscard]] const TiffPage& page() const { return page_; }
  // To the next directory. False after the last, and when the next is damaged.
  [[nodiscard]] bool next_page();

  // Text of an ASCII tag of the current directory; empty when absent.
  [[nodiscard]] std::string text(std::uint32_t tag) const;
  // Bytes of the ICC profile (34675) or the XMP packet (700).
  [[nodiscard]] std::vector<std::byte> blob(std::uint32_t tag) const;

  [[nodiscard]] tiff* handle() const { return tiff_; }
  // What libtiff last complained about; empty when it did not.
  [[nodiscard]] const std::string& last_complaint() const { return *complaint_; }

 private:
  std::filesystem::path path_;
  std::uint64_t file_bytes_ = 0;
  std::unique_ptr<std::string> complaint_;
  tiff* tiff_ = nullptr;
  TiffPage page_;
};

}  // namespace reseau
