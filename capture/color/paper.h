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
  std::string part;  // "areas", "tab1", "tab2", "tab3", "tab4", "claims", "scan"
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
  [[nodiscard]] bool held() const;
};

// Areas, Tab. 1 to 4 on the fitted scenes, claims of the text, plots.
[[nodiscard]] PaperReport make_paper();

// The differences of Tab. 3 and 4 on the element intensities of a scan (process RGB of a real
// reconstruction), against Color-Screen's on the party crop and the paper's photographs.
[[nodiscard]] PaperReport paper_of_scan(std::span<const Vector3> intensities);

// The figures as a page for people, and as CSV.
[[nodiscard]] std::string paper_text(const PaperReport& report);
[[nodiscard]] std::string paper_csv(const PaperReport& report);

}  // namespace reseau
