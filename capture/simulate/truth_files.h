// What is known about a simulated scan, as files beside it. README.md describes them.
#pragma once

#include <filesystem>
#include <functional>

#include <nlohmann/json.hpp>

#include "drivers/sim/simulate.h"

namespace reseau::simulate {

// NAME.exr, NAME.json, NAME.elements.exr, NAME.psf.exr.
struct TruthNames {
  std::filesystem::path picture, parameters, elements, psf;
};
// From the name of the picture.
[[nodiscard]] TruthNames truth_names(const std::filesystem::path& picture);

// A scan and what is known about it, without its samples.
struct KnownScan {
  LineFormat format;
  sim::FilmTruth truth;
};

// Of every pixel: process RGB, the silver (IR); u and v where there is a réseau; scene.R, G, B
// where they differ from process RGB; harm where there is any. Lines are made on all cores.
// `keep_going` is asked every few lines with the fraction that is done; false ends it without a
// file. Throws as FloatImageWriter.
[[nodiscard]] bool write_truth_picture(const KnownScan& scan, const std::filesystem::path& path,
                                       const std::function<bool(double)>& keep_going);

// Of every period of the réseau: the silver transmittance behind its red, green and blue element at
// the middle of each (R, G, B), and where the green one lies (x, y) [px]. Pixel (i, j) is period
// (u, v) = (i + first_u, j + first_v); NaN where the element lies outside the scan. Returns the
// first period. The scan must have a réseau. Throws as FloatImageWriter.
struct FirstPeriod {
  int u = 0, v = 0;
};
FirstPeriod write_element_samples(const KnownScan& scan, const std::filesystem::path& path);

// Spread functions R G B IR at `kPsfPlaces` x `kPsfPlaces` places of the scan, side by side; see
// truth_to_json() for their scale. Throws as FloatImageWriter.
inline constexpr int kPsfPlaces = 3;
inline constexpr int kPsfSamplesPerPx = 8;
inline constexpr int kPsfRadiusPx = 8;
void write_psf_grid(const sim::SimSpec& spec, const std::filesystem::path& path);

// Schema reseau-truth/1: everything that decided the scan, with the seed.
[[nodiscard]] nlohmann::ordered_json truth_to_json(const sim::SimSpec& spec, const KnownScan& scan);

}  // namespace reseau::simulate
