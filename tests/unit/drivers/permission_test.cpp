#include "drivers/permission.h"

#include <filesystem>

#include <gtest/gtest.h>

namespace reseau {
namespace {

TEST(Permission, EveryCaseHasItsCommand) {
  NodePermission seen;
  const auto remedy = [&] { return permission_remedy(seen, "/opt/60-reseau.rules"); };
  EXPECT_EQ(remedy(),
            "sudo groupadd --system scanner; sudo cp '/opt/60-reseau.rules' /etc/udev/rules.d/ && "
            "sudo udevadm control --reload && sudo udevadm trigger --subsystem-match=usb "
            "--subsystem-match=scsi_generic; without a seat (ssh, a service) also: sudo usermod "
            "-aG scanner \"$USER\", and log in again");
  seen.group_exists = true;
  EXPECT_TRUE(remedy().starts_with("sudo cp '/opt/60-reseau.rules' /etc/udev/rules.d/ && "));
  seen.rule_installed = true;
  EXPECT_TRUE(remedy().starts_with("sudo udevadm control --reload && sudo udevadm trigger"));
  seen.node_has_group = true;
  EXPECT_EQ(remedy(), "sudo usermod -aG scanner \"$USER\", and log in again");
  seen.listed = true;
  EXPECT_TRUE(remedy().starts_with("log out and in again"));
  seen.group_exists = false;
  EXPECT_TRUE(remedy().starts_with("sudo groupadd --system scanner && "));
}

TEST(Permission, FindsTheRuleOfTheseSources) {
  const std::filesystem::path rule = rule_source();
  EXPECT_EQ(rule.filename(), kRuleName);
  EXPECT_TRUE(std::filesystem::equivalent(rule, RESEAU_UDEV_RULE));
}

}  // namespace
}  // namespace reseau
