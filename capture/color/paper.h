// The figures of Hubicka, Kimrova and Konecny 2025 (arXiv:2501.06216) from our own numbers, beside
// the published ones. Pure; the caller writes the files.
#pragma once

#include <limits>
#include <span>
#include <string>
#include <vector>

#include "core/color/matrix3.h"

namespace reseau {

// One figure of ours beside a published one.
struct PaperFigure {
  // "areas", "tab1", "tab2", "tab3", "tab4", "claims", "scan", "scan-own"
  std::string part;
  std::string what;
  double ours = 0;
  // NaN where nothing is published, for limits on a whole table.
  double published = std::numeric_limits<double>::quiet_NaN();
  std::string limit;  // what must hold, in words; empty: shown for comparison only
  bool held = true;
  std::string remark;  // why a published figure does not recompute
};

struct PaperFile {
  std::string name;
  std::string text;
};

struct PaperReport {
  std::vector<PaperFigure> figures;
  std::vector<PaperFile> files;  // tables as CSV, plots as SVG
  std::string scan_parameters;   // how the scan was reconstructed, when there is one
  [[nodiscard]] bool held() const;
};

// Areas, Tab. 1 to 4 on the fitted scenes, claims of the text, plots.
[[nodiscard]] PaperReport make_paper();

// With which parameters Color-Screen rendered its test crop ("party"; Nikon LS-9000, 4000 dpi) for
// the differences that are compared with: those of the crop's own parameter file in its test suite,
// dark_point and screen_blur_radius. Nothing here is fitted to the differences.
inline constexpr double kPaperBlack = 0.014328;
inline constexpr double kPaperBlur_px = 0.5;

// The differences of Tab. 3 and 4 on the element intensities of a scan (process RGB of a real
// reconstruction), against Color-Screen's on its crop and the paper's photographs.
// `as_compared`: reconstructed with Color-Screen's parameters, for the comparison; the limits are
// on these. `own`: as this program reconstructs by itself, shown beside. `parameters`: of the
// former, in words.
[[nodiscard]] PaperReport paper_of_scan(std::span<const Vector3> as_compared,
                                        std::span<const Vector3> own,
                                        const std::string& parameters);

// The figures as a page for people, and as CSV.
[[nodiscard]] std::string paper_text(const PaperReport& report);
[[nodiscard]] std::string paper_csv(const PaperReport& report);

}  // namespace reseau
