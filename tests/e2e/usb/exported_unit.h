// `reseau simulate --usbip` in a process of its own, and programs that see its unit on their bus.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "tests/support/process.h"
#include "tests/support/temp_dir.h"

namespace reseau::testing {

class ExportedUnit {
 public:
  // Settings as words of the command line: "frames=6". `backend` is the one that SANE loads.
  ExportedUnit(const std::string& model, const std::vector<std::string>& settings,
               const std::string& backend = "coolscan3");

  // Runs a program under tests/support/usbip_host.
  [[nodiscard]] ProcessResult run(std::vector<std::string> program,
                                  std::vector<std::string> environment = {}) const;
  // scanimage with SANE's coolscan3 alone, on this unit.
  [[nodiscard]] ProcessResult scanimage(std::vector<std::string> arguments,
                                        std::vector<std::string> environment = {}) const;
  // As Ctrl-C does.
  [[nodiscard]] ProcessResult stop();
  [[nodiscard]] const std::string& address() const { return address_; }
  [[nodiscard]] std::string file(const std::string& name) const { return (dir_ / name).string(); }

 private:
  test::TempDir dir_;
  std::string address_;
  std::unique_ptr<Process> server_;
};

}  // namespace reseau::testing
