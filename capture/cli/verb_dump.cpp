#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <system_error>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <sys/utsname.h>
#include <unistd.h>

#include "capture/cli/develop_choice.h"
#include "capture/cli/failure.h"
#include "capture/cli/scan_choice.h"
#include "capture/cli/verbs.h"
#include "core/base/error.h"
#include "drivers/registry.h"
#include "drivers/sessions.h"

namespace reseau::cli {

namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

ordered_json system_json() {
  utsname name{};
  if (uname(&name) != 0) return ordered_json::object();
  // Not the node name: it often names a person.
  return {{"kernel", name.sysname}, {"release", name.release}, {"machine", name.machine}};
}

ordered_json findings_json() {
  ordered_json array = ordered_json::array();
  for (const Finding& finding : diagnose_devices()) {
    array.push_back({{"problem", finding.level != Finding::Level::kOk},
                     {"what", finding.what},
                     {"detail", finding.detail}});
  }
  return array;
}

ordered_json capabilities_json(const Capabilities& c) {
  return {{"make", c.make},
          {"model", c.model},
          {"firmware", c.firmware},
          {"link", c.link},
          {"adapter", c.adapter},
          {"film_present", c.film_present},
          {"resolutions_dpi", c.resolutions_dpi},
          {"depths_bits", c.depths_bits},
          {"infrared", c.infrared},
          {"sensor_lines", c.sensor_lines},
          {"max_samples", c.max_samples},
          {"frames", c.n_frames},
          {"can_eject", c.can_eject}};
}

// Opens the unit, which makes the driver read all that it can of it: "unit" and "error", one of
// them null. `serial` is filled in where it is known, even if the unit cannot be opened.
ordered_json look_at(const std::string& name, const fs::path& recording, std::string& serial) {
  ordered_json looked{{"unit", nullptr}, {"error", nullptr}};
  const std::string with_ids = "usb:04b0:4002:";
  if (name.starts_with("usb:") && name.size() > with_ids.size()) {
    serial = name.substr(with_ids.size());
  }
  OpenOptions options;
  options.record_to = recording;
  try {
    const OpenedScanner opened = open_scanner(name, options);
    looked["unit"] = capabilities_json(opened.scanner->capabilities());
    if (serial.empty()) serial = opened.scanner->capabilities().serial;
  } catch (const DeviceError& error) {
    looked["error"] = {{"message", error.what()}, {"detail", error.detail()}};
  } catch (const std::system_error& error) {
    looked["error"] = {{"message", error.what()}, {"detail", error.code().message()}};
  }
  return looked;
}

ordered_json commands_json(const fs::path& session) {
  ordered_json array = ordered_json::array();
  show_session(session, [&](const ShownExchange& e) {
    array.push_back({{"number", e.number},
                     {"command", e.command},
                     {"received_bytes", e.in_bytes},
                     {"outcome", e.outcome},
                     {"text", e.text}});
  });
  return array;
}

void refuse_taken(const fs::path& path) {
  if (!fs::exists(path)) return;
  throw Failure(kExitOutput, path.string() + " exists already and is not overwritten.",
                "Choose another name with -o.");
}

std::string without(std::string text, const std::string& secret) {
  for (std::size_t at = 0; !secret.empty() && (at = text.find(secret, at)) != std::string::npos;) {
    text.replace(at, secret.size(), secret.size(), 'X');
  }
  return text;
}

ExitCode dump(const std::string& device, const std::string& output, Work& work) {
  const std::string name =
      as_failure(Doing::kReadingOptions, [&] { return choose_device(device); });
  const fs::path json_path = output + ".json", session_path = output + ".pcapng";
  const PreparedDirectory prepared(json_path.has_parent_path() ? json_path.parent_path() : ".");
  refuse_taken(json_path);
  refuse_taken(session_path);
  const fs::path raw = output + fmt::format(".{}.part", getpid());
  std::string serial;
  const ordered_json looked =
      as_failure(Doing::kWriting, [&] { return look_at(name, raw, serial); });
  ordered_json json = {
      {"schema", "reseau-dump/1"}, {"version", RESEAU_VERSION},   {"device", name},
      {"system", system_json()},   {"findings", findings_json()}, {"unit", looked["unit"]},
      {"error", looked["error"]}};
  bool recorded = false;
  if (fs::exists(raw)) {
    try {
      RewriteOptions options;
      options.blank_serial = true;
      rewrite_session(raw, session_path, options);
      json["commands"] = commands_json(session_path);
      recorded = true;
    } catch (const InputError& error) {
      json["commands_missing"] = error.what();
    }
    fs::remove(raw);
  }
  const std::string text = without(json.dump(2), serial) + "\n";
  std::ofstream file(json_path);
  file << text << std::flush;
  if (!file) {
    throw Failure(kExitOutput, json_path.string() + " cannot be written.",
                  "Choose a folder with room that you may write to, with -o.");
  }
  work.reporter.say(
      "Read it before you send it: it names the scanner, its firmware, this system and who uses "
      "the scanner, and no serial number.");
  work.reporter.result_line(json_path.string());
  if (recorded) work.reporter.result_line(session_path.string());
  work.reporter.result_json({{"schema", "reseau-dump-files/1"},
                             {"json", json_path.string()},
                             {"session", recorded ? session_path.string() : ""},
                             {"opened", looked["error"].is_null()}});
  return looked["error"].is_null() ? kExitOk : kExitDevice;
}

}  // namespace

void add_dump(Program& program) {
  struct Options {
    std::string device, output = "reseau-dump";
  };
  auto options = std::make_shared<Options>();
  CLI::App* app = program.add_verb(
      "dump",
      "Writes what a maintainer needs to know of a scanner: NAME.json with the unit, what it "
      "answered and\nwhat 'doctor' finds, and NAME.pcapng, a recording of it. Moves no film; "
      "blanks "
      "the serial number.",
      "reseau dump\n"
      "reseau dump -d usb:04b0:4001 -o coolscan-v",
      [options](Work& work) { return dump(options->device, options->output, work); });
  program.prints_own_json(app);
  app->add_option("-d,--device-name", options->device, "The scanner; default the only one");
  app->add_option("-o,--output", options->output, "Name of both files, without ending");
}

}  // namespace reseau::cli
