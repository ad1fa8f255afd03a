#include <filesystem>
#include <fstream>
#include <string>
#include <system_error>
#include <vector>

#include <unistd.h>

#include "drivers/coolscan/models.h"
#include "drivers/families.h"
#include "drivers/permission.h"
#include "drivers/registry.h"
#include "drivers/scsi/sg_node.h"
#include "drivers/usb/libusb_transport.h"

namespace reseau {
namespace {

namespace fs = std::filesystem;

Finding bus_finding() {
  std::error_code error;
  const bool usbfs = fs::is_directory("/dev/bus/usb", error);
  if (usbfs) return {Finding::Level::kOk, "USB bus", "/dev/bus/usb is there", ""};
  return {Finding::Level::kProblem, "USB bus",
          "/dev/bus/usb is missing, so no USB device can be reached. In a container the bus has to "
          "be passed in",
          "run on the host, or start the container with --device=/dev/bus/usb"};
}

// Empty when no folder that udev reads has it.
fs::path installed_rule() {
  for (const char* directory : {"/etc/udev/rules.d", "/run/udev/rules.d", "/usr/lib/udev/rules.d",
                                "/lib/udev/rules.d", "/usr/local/lib/udev/rules.d"}) {
    fs::path path = fs::path(directory) / kRuleName;
    std::error_code error;
    if (fs::exists(path, error)) return path;
  }
  return {};
}

Finding rule_finding() {
  const fs::path rule = installed_rule();
  if (!rule.empty()) {
    return {Finding::Level::kOk, "udev rule", rule.string() + " is installed", ""};
  }
  const bool group_exists = look_at_permission("", false).group_exists;
  return {Finding::Level::kWarning, "udev rule",
          std::string(kRuleName) +
              " is not installed; without it, or SANE's rules, only root may use the scanner",
          rule_command(rule_source(), group_exists)};
}

struct Holders {
  std::vector<std::string> names;
  bool others_hidden = false;  // programs of other people, which only root may look at
};

// Programs that have the node open, as far as /proc lets this person look.
Holders holders_of(const std::string& node) {
  Holders holders;
  std::error_code error;
  const std::string self = std::to_string(getpid());
  for (const fs::directory_entry& process : fs::directory_iterator("/proc", error)) {
    const std::string pid = process.path().filename().string();
    if (pid == self || pid.find_first_not_of("0123456789") != std::string::npos) continue;
    std::error_code denied;
    fs::directory_iterator fd(process.path() / "fd", denied);
    holders.others_hidden = holders.others_hidden || denied == std::errc::permission_denied;
    for (; !denied && fd != fs::directory_iterator(); fd.increment(denied)) {
      std::error_code unreadable;
      if (fs::read_symlink(fd->path(), unreadable) != node) continue;
      std::string name;
      std::getline(std::ifstream(process.path() / "comm"), name);
      holders.names.push_back(name + " (process " + pid + ")");
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
    findings.push_back(
        {Finding::Level::kProblem, "permission on " + node, "you may not write to it",
         permission_remedy(look_at_permission(node, !installed_rule().empty()), rule_source())});
  }
  const Holders holders = holders_of(node);
  for (const std::string& holder : holders.names) {
    findings.push_back({Finding::Level::kWarning, "who uses " + node,
                        holder + " has the scanner open", "close that program"});
  }
  if (holders.names.empty() && holders.others_hidden) {
    findings.push_back({Finding::Level::kOk, "who uses " + node,
                        "no program of yours; to see those of others: sudo fuser -v " + node, ""});
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
