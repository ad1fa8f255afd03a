#include "drivers/permission.h"

#include <algorithm>
#include <string_view>
#include <system_error>
#include <vector>

#include <grp.h>
#include <pwd.h>
#include <sys/stat.h>
#include <unistd.h>

namespace reseau {
namespace {

namespace fs = std::filesystem;

constexpr const char* kGroup = "scanner";
constexpr const char* kTrigger =
    "sudo udevadm control --reload && sudo udevadm trigger --subsystem-match=usb "
    "--subsystem-match=scsi_generic";

std::string quoted(const fs::path& path) { return "'" + path.string() + "'"; }

}  // namespace

NodePermission look_at_permission(const std::string& node, bool rule_installed) {
  NodePermission seen;
  seen.rule_installed = rule_installed;
  const group* const scanner = getgrnam(kGroup);
  if (scanner == nullptr) return seen;
  seen.group_exists = true;
  const passwd* const person = getpwuid(getuid());
  for (char** member = scanner->gr_mem; person != nullptr && *member != nullptr; ++member) {
    seen.listed = seen.listed || std::string_view(*member) == person->pw_name;
  }
  const gid_t id = scanner->gr_gid;
  struct stat status {};
  seen.node_has_group = stat(node.c_str(), &status) == 0 && status.st_gid == id;
  std::vector<gid_t> groups(static_cast<std::size_t>(std::max(getgroups(0, nullptr), 0)));
  const int n = getgroups(static_cast<int>(groups.size()), groups.data());
  seen.in_group = getegid() == id || (n > 0 && std::find(groups.begin(), groups.begin() + n, id) !=
                                                   groups.begin() + n);
  return seen;
}

fs::path rule_source() {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  if (error) return kRuleName;
  for (fs::path above = program.parent_path(); above.has_relative_path();
       above = above.parent_path()) {
    for (const char* const folder : {"lib/udev/rules.d", "udev"}) {
      fs::path rule = above / folder / kRuleName;
      if (fs::exists(rule, error)) return rule;
    }
  }
  return kRuleName;
}

std::string rule_command(const fs::path& rule, bool group_exists) {
  return std::string(group_exists ? "" : "sudo groupadd --system scanner; ") + "sudo cp " +
         quoted(rule) + " /etc/udev/rules.d/ && " + kTrigger;
}

std::string permission_remedy(const NodePermission& seen, const fs::path& rule) {
  const std::string join = std::string("sudo usermod -aG ") + kGroup + " \"$USER\"";
  if (!seen.rule_installed) {
    // The rule alone serves whoever sits at the machine.
    return rule_command(rule, seen.group_exists) +
           "; without a seat (ssh, a service) also: " + join + ", and log in again";
  }
  if (!seen.group_exists) return "sudo groupadd --system scanner && " + std::string(kTrigger);
  if (!seen.node_has_group) return std::string(kTrigger) + ", or unplug the scanner and plug it in";
  if (!seen.listed && !seen.in_group) return join + ", and log in again";
  return "log out and in again, so that your new group counts; in this shell alone: newgrp scanner";
}

}  // namespace reseau
