// Why a device node may not be used by this person, and the command that mends it.
#pragma once

#include <filesystem>
#include <string>

namespace reseau {

struct NodePermission {
  bool rule_installed = false;  // udev reads our rule
  bool group_exists = false;    // "scanner", which the rule gives the node to
  bool node_has_group = false;
  bool listed = false;    // this person is in the group by /etc/group
  bool in_group = false;  // and was so when this session began
};

// Looks at a node. Never fails; what cannot be seen counts as missing.
[[nodiscard]] NodePermission look_at_permission(const std::string& node, bool rule_installed);

// The rule file of this program: installed beside it, or in its sources; else its name alone.
[[nodiscard]] std::filesystem::path rule_source();
// One line for a shell that installs the rule and has udev act on it.
[[nodiscard]] std::string rule_command(const std::filesystem::path& rule, bool group_exists);
// What this person has to do to use a node that he or she may not use. Pure.
[[nodiscard]] std::string permission_remedy(const NodePermission& seen,
                                            const std::filesystem::path& rule);

inline constexpr const char* kRuleName = "60-reseau.rules";

}  // namespace reseau
