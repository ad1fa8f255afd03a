// OpenEXR scanline files of FLOAT channels: pictures, maps, and reading them back.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "capture/store/part_file.h"
#include "core/color/element_color.h"

namespace reseau {

// All lossless. Grain fills the mantissa of a float, so that a reconstruction hardly shrinks:
// stored is the default because it is far faster; PIZ saves about a fifth. ZIP saves next to
// nothing.
enum class ExrCompression {
  kNone,   // stored
  kSmall,  // PIZ
};

struct ExrOptions {
  ExrCompression compression = ExrCompression::kNone;
  Existing existing = Existing::kRefuse;
  std::optional<Chromaticities> chromaticities;
  std::optional<Chromaticity> adopted_neutral;  // x, y that should look neutral
  std::optional<double> white_luminance;        // of (1, 1, 1) [cd/m2]
  // Custom attributes (strings): provenance. Names are prefixed with "reseau." by the caller.
  std::vector<std::pair<std::string, std::string>> attributes;
};

// Writes any set of float channels, row by row from the top. The file gets its name at finish(); a
// writer destroyed before leaves nothing. Same input, same bytes. Thread-bound.
class FloatImageWriter {
 public:
  // `channels` in the order of the samples given to rows(). Throws InputError when the name is
  // taken, std::system_error when it cannot be written.
  FloatImageWriter(const std::filesystem::path& path, int width_px, int height_px,
                   const std::vector<std::string>& channels, const ExrOptions& options = {});
  ~FloatImageWriter();
  FloatImageWriter(const FloatImageWriter&) = delete;
  FloatImageWriter& operator=(const FloatImageWriter&) = delete;
  FloatImageWriter(FloatImageWriter&&) noexcept;
  FloatImageWriter& operator=(FloatImageWriter&&) noexcept;

  // [row][pixel][channel], rows in order from 0. Throws std::system_error (disk full).
  void rows(int first_row, int n_rows, std::span<const float> samples);
  // All rows must have been given. Throws as PartFile::publish.
  void finish();
  // Of the finished file. Of one whose rows are stored it is known; another is read.
  [[nodiscard]] std::string sha256() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// What an EXR says of itself.
struct ExrHeader {
  int width_px = 0, height_px = 0;
  std::vector<std::string> channels;  // in alphabetical order
  std::optional<Chromaticities> chromaticities;
  std::vector<std::pair<std::string, std::string>> attributes;  // string attributes
};
// Throws as ExrReader.
[[nodiscard]] ExrHeader read_exr_header(const std::filesystem::path& path);

// Reads channels of an EXR as float, by rows. Thread-bound.
class ExrReader {
 public:
  // Throws InputError for a file that is no scanline or tiled EXR, lacks a channel (the message
  // lists those it has) or has absurd dimensions; std::system_error when it cannot be opened.
  explicit ExrReader(const std::filesystem::path& path,
                     const std::vector<std::string>& channels = {"R", "G", "B"});
  ~ExrReader();
  ExrReader(const ExrReader&) = delete;
  ExrReader& operator=(const ExrReader&) = delete;
  ExrReader(ExrReader&&) noexcept;
  ExrReader& operator=(ExrReader&&) noexcept;

  [[nodiscard]] int width_px() const;
  [[nodiscard]] int height_px() const;
  [[nodiscard]] std::optional<Chromaticities> chromaticities() const;
  [[nodiscard]] std::optional<Chromaticity> adopted_neutral() const;
  // Value of a string attribute, or nothing.
  [[nodiscard]] std::optional<std::string> attribute(const std::string& name) const;
  // [row][pixel][channel] in the order of the constructor. Throws InputError for damaged data.
  void read(int first_row, int n_rows, std::span<float> out);

 private:
  friend ExrHeader read_exr_header(const std::filesystem::path& path);
  struct State;
  std::unique_ptr<State> state_;
};

struct FloatImage {
  int width_px = 0, height_px = 0;
  std::vector<std::string> channels;
  std::vector<float> samples;  // [row][pixel][channel]
};

[[nodiscard]] FloatImage read_exr(const std::filesystem::path& path,
                                  const std::vector<std::string>& channels = {"R", "G", "B"});

}  // namespace reseau
