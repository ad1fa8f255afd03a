// The receipt beside every picture: what was done, with which figures, and the hashes of the files.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "capture/session/develop.h"
#include "capture/session/scan_session.h"
#include "core/line/line_format.h"
#include "core/reconstruct/reconstruct.h"
#include "drivers/scan_plan.h"

namespace reseau {

struct ReceiptFile {
  std::string role;  // "master", "reconstruction", "view", "view16", "recording", "source"
  std::filesystem::path path;
};

// The scan part; absent for a reconstruction of a file.
struct ReceiptScan {
  ScanRequest request;
  Negotiated negotiated;
  ScanOutcome outcome;
};

struct ReceiptInput {
  LineFormat format;
  CaptureContext context;
  std::string tone;  // "linear", "gamma 2.2", "from the ICC profile"
  std::vector<std::string> notes;
};

struct Receipt {
  std::string verb;        // "scan", "reconstruct"
  std::string written_at;  // ISO 8601 UTC
  std::optional<ReceiptScan> scan;
  ReceiptInput input;
  DevelopOptions settings;
  std::string quality = "standard";
  std::optional<Development> development;  // absent when nobody asked for a picture
  std::vector<ReceiptFile> files;          // hashed when it is made, unless known
  std::vector<std::string> notes;
};

// {"schema": "reseau-receipt/1", …}. Numbers that are not finite become null with a reason. Reads
// every file to hash it; throws std::system_error when one cannot be read.
[[nodiscard]] nlohmann::ordered_json receipt_to_json(const Receipt& receipt);

// Writes beside, then renames; refuses an existing file (InputError). Throws std::system_error.
void write_json_file(const nlohmann::ordered_json& object, const std::filesystem::path& path);

// Keys of `register --json` without the schema: found, screen, confidence, lattice_cy_per_px,
// residual_px, angle_deg, period_px, period_um, mirrored, …
[[nodiscard]] nlohmann::ordered_json registration_to_json(const Registration& registration);

}  // namespace reseau
