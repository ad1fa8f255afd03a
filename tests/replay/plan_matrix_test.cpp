// The text of every plan: models x adapters x resolutions x depths x channels x modes.
#include <fstream>
#include <memory>
#include <sstream>
#include <string>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "drivers/registry.h"
#include "drivers/scanner.h"

namespace reseau {
namespace {

void write_plan(const Scanner& scanner, const ScanRequest& request, std::ostream& text) {
  Negotiated n;
  try {
    n = scanner.negotiate(request);
  } catch (const InputError& error) {
    text << "refused: " << error.what() << "\n";
    return;
  }
  const ScanPlan& p = n.plan;
  text << p.resolution_dpi << " dpi/" << p.pitch << " " << p.depth_bits << " bit "
       << (p.overview   ? "overview"
           : p.infrared ? "RGBI"
                        : "RGB")
       << " lines " << p.sensor_lines << " samples " << p.samples << ": x " << p.x_origin_px << "+"
       << p.window_width_px << " y " << p.y_origin_px << "+" << p.window_height_px << " crop "
       << p.crop_left_px << "," << p.crop_top_lines << " -> " << p.format.width_px << "x"
       << p.format.n_lines;
  for (const Adjustment& a : n.adjusted) text << "; " << a.field << " " << a.granted;
  text << "\n";
}

void write_unit(const std::string& name, std::ostream& text) {
  const std::unique_ptr<Scanner> scanner = open_scanner(name, {}).scanner;
  const Capabilities& c = scanner->capabilities();
  text << "== " << name << " " << c.model << ", " << c.adapter << ", " << c.link << ", frames "
       << c.n_frames << "\n";
  for (std::size_t i = 0; i < c.resolutions_dpi.size(); ++i) {
    for (const int bits : c.depths_bits) {
      for (const bool infrared : {false, true}) {
        for (const SensorLines lines : {SensorLines::kOne, SensorLines::kAll}) {
          for (const int samples : {1, 4}) {
            if (lines == SensorLines::kAll && c.sensor_lines == 1) continue;
            if (samples > c.max_samples) continue;
            ScanRequest request;
            request.resolution_dpi = c.resolutions_dpi[i];
            request.depth_bits = bits;
            request.infrared = infrared;
            request.sensor_lines = lines;
            request.samples = samples;
            write_plan(*scanner, request, text);
          }
        }
      }
    }
  }
  ScanRequest request;
  request.frame = c.n_frames;
  request.frame_offset_mm = -0.25;
  request.area = {5.0, 6.0, 10.0, 11.0};
  write_plan(*scanner, request, text);
  request = {};
  request.overview = true;
  write_plan(*scanner, request, text);
}

TEST(PlanMatrix, IsAsItWas) {
  std::ostringstream text;
  for (const char* const model :
       {"ls5000", "ls50", "ls40", "ls4000", "ls8000", "ls9000", "ls2000", "ls30"}) {
    write_unit(std::string("sim:") + model, text);
  }
  // What can be pushed into each. LS-8000 and LS-9000 have holders instead, LS-2000 and LS-30 do
  // not say what they have.
  for (const char* const model : {"ls5000", "ls50", "ls40", "ls4000"}) {
    for (const char* const adapter : {"sa21", "sa30", "mount", "aps", "feeder"}) {
      write_unit(std::string("sim:") + model + "?adapter=" + adapter, text);
    }
  }
  for (const char* const model : {"crystalscan3600", "crystalscan7200", "proscan7200", "proscan10t",
                                  "digitdia5000", "digitdia6000", "rps7200"}) {
    write_unit(std::string("sim:") + model, text);
  }
  // The new text is always in the build tree, to be looked at and copied when a change is meant.
  std::ofstream(RESEAU_GOLDEN_OUT) << text.str();
  std::ifstream file(RESEAU_GOLDEN_DIR "/plan_matrix.txt");
  std::stringstream golden;
  golden << file.rdbuf();
  EXPECT_TRUE(golden.str() == text.str())
      << "differs from plan_matrix.txt; compare with " RESEAU_GOLDEN_OUT;
}

}  // namespace
}  // namespace reseau
