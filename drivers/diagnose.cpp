#include <filesystem>
#include <fstream>
#include <string>
#include <system_error>
#include <vector>

#include <unistd.h>

#include "drivers/coolscan/models.h"
#include "drivers/families.h"
#include "drivers/registry.h"
#include "drivers/scsi/sg_node.h"
#include "drivers/usb/libusb_transport.h"

namespace reseau {
namespace {

namespace fs = std::filesystem;

constexpr const char* kRuleName = "60-reseau.rules";
constexpr const char* kReload =
    "sudo udevadm control --reload && sudo udevadm trigger --subsystem-match=usb "
    "--subsystem-match=scsi_generic, or unplug the "
    "scanner and plug it in again";

Finding bus_finding() {
  std::error_code error;
  const bool usbfs = fs::is_directory("/dev/bus/usb", error);
  if (usbfs) return {Finding::Level::kOk, "USB bus", "/dev/bus/usb is there", ""};
  return {Finding::Level::kProblem, "USB bus",
          "/dev/bus/usb is missing, so no USB device can be reached. In a container the bus has to "
          "be passed in",
          "run on the host, or start the container with --device=/dev/bus/usb"};
}

Finding rule_finding() {
  for (const char* directory : {"/etc/udev/rules.d", "/run/udev/rules.d", "/usr/lib/udev/rules.d",
                                "/lib/udev/rules.d", "/usr/local/lib/udev/rules.d"}) {
    const fs::path path = fs::path(directory) / kRuleName;
    std::error_code error;
    if (fs::exists(path, error)) {
      return {Finding::Level::kOk, "udev rule", path.string() + " is installed", ""};
    }
  }
  return {Finding::Level::kWarning, "udev rule",
          std::string(kRuleName) +
              " is not installed; without it, or SANE's rules, only root may use the scanner",
          std::string("sudo cp udev/") + kRuleName + " /etc/udev/rules.d/ && " + kReload};
}

// Names of programs that have the node open, as far as /proc lets this user look.
std::vector<std::string> holders_of(const std::string& node) {
  std::vector<std::string> holders;
  std::error_code error;
  const std::string self = std::to_string(getpid());
  for (const fs::directory_entry& process : fs::directory_iterator("/proc", error)) {
    const std::string pid = process.path().filename().string();
    if (pid == self || pid.find_first_not_of("0123456789") != std::string::npos) continue;
    std::error_code denied;
    fs::directory_iterator fd(process.path() / "fd", denied);
    for (; !denied && fd != fs::directory_iterator(); fd.increment(denied)) {
      std::error_code unreadable;
      if (fs::read_symlink(fd->path(), unreadable) != node) continue;
      std::string name;
      std::getline(std::ifstream(process.path() / "comm"), name);
      holders.push_back(name + " (process " + pid + ")");
      break;
    }
  }
  return holders;
}

void add_unit(const std::string& name, const std::string& node, const std::string& link,
              std::vector<Finding>& findings) {
  findings.push_back({Finding::Level::kOk, name, "found at " + node + ", " + link, ""});
  if (access(node.c_str(), R_OK | W_OK) == 0) {
    findings.push_back({Finding::Level::kOk, "permission on " + node, "read and write", ""});
  } else {
    findings.push_back({Finding::Level::kProblem, "permission on " + node,
                        "you may not write to it",
                        std::string("install ") + kRuleName + ", then " + kReload +
                            "; without a seat (ssh, service) also: sudo adduser $USER scanner, "
                            "and log in again"});
  }
  for (const std::string& holder : holders_of(node)) {
    findings.push_back({Finding::Level::kWarning, "who uses " + node,
                        holder + " has the scanner open", "close that program"});
  }
}

}  // namespace

std::vector<Finding> diagnose_devices() {
  std::vector<Finding> findings = {bus_finding(), rule_finding()};
  const std::size_t n_before = findings.size();
  for (const UsbDeviceInfo& unit : list_known_units()) {
    add_unit(trade_name_of(unit.vendor_id, unit.product_id), unit.node, unit.speed, findings);
  }
  for (const SgDeviceInfo& unit : list_sg_scanners()) {
    const coolscan::Model* const model = coolscan::model_by_product(unit.product);
    if (model == nullptr) continue;
    add_unit(std::string(model->trade_name), unit.path, "FireWire or SCSI", findings);
  }
  if (findings.size() == n_before) {
    findings.push_back({Finding::Level::kWarning, "scanners",
                        "no film scanner is on the USB bus or behind FireWire or SCSI",
                        "plug it in, switch it on, and wait until its lamp stops blinking; a "
                        "simulated one is always there: -d sim:ls5000"});
  }
  return findings;
}

}  // namespace reseau
