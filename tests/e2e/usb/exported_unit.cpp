#include "tests/e2e/usb/exported_unit.h"

#include <chrono>
#include <csignal>
#include <filesystem>

#include <gtest/gtest.h>

namespace reseau::testing {

ExportedUnit::ExportedUnit(const std::string& model, const std::vector<std::string>& settings,
                           const std::string& backend)
    : address_("unix:" + file("scanner.sock")) {
  std::vector<std::string> words{RESEAU_BINARY, "simulate", "--usbip", address_, "--model", model};
  words.insert(words.end(), settings.begin(), settings.end());
  server_ = std::make_unique<Process>(words);
  EXPECT_TRUE(server_->wait_for_line([this](const std::string& line) { return line == address_; },
                                     std::chrono::seconds(30)));
  std::filesystem::create_directory(file("sane.d"));
  test::write_bytes(file("sane.d/dll.conf"), backend + "\n");
  test::write_bytes(file("sane.d/coolscan3.conf"), "auto\n");
  // As Debian's file has it; the others are built in.
  test::write_bytes(file("sane.d/pieusb.conf"),
                    "usb 0x05e3 0x0145 0x47 0x00\nusb 0x05e3 0x0145 0x2e 0x00\n"
                    "usb 0x05e3 0x0142 0x2f 0x03\n");
}

ProcessResult ExportedUnit::run(std::vector<std::string> program,
                                std::vector<std::string> environment) const {
  program.insert(program.begin(), {RESEAU_USBIP_HOST, address_});
  ProcessOptions options;
  options.environment = std::move(environment);
  const ProcessResult result = run_process(program, options);
  EXPECT_FALSE(result.timed_out) << result.err;
  return result;
}

ProcessResult ExportedUnit::scanimage(std::vector<std::string> arguments,
                                      std::vector<std::string> environment) const {
  arguments.insert(arguments.begin(), RESEAU_SCANIMAGE);
  environment.push_back("SANE_CONFIG_DIR=" + file("sane.d"));
  return run(std::move(arguments), std::move(environment));
}

ProcessResult ExportedUnit::stop() {
  server_->send(SIGINT);
  return server_->wait(std::chrono::seconds(20));
}

}  // namespace reseau::testing
