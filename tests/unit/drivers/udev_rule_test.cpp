#include <algorithm>
#include <fstream>
#include <set>
#include <sstream>
#include <string>

#include <gtest/gtest.h>

#include "drivers/coolscan/models.h"
#include "drivers/pieusb/models.h"

namespace reseau::coolscan {
namespace {

std::string hex4(unsigned value) {
  char text[8];
  std::snprintf(text, sizeof text, "%04x", value);
  return text;
}

std::string rule_text() {
  std::ifstream file(RESEAU_UDEV_RULE);
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

// Product ids of the line of one vendor.
std::set<std::string> ids_in_rule(std::uint16_t vendor) {
  const std::string rule = rule_text();
  const std::string key = "ATTR{idVendor}==\"" + hex4(vendor) + "\", ATTR{idProduct}==\"";
  const std::size_t begin = rule.find(key);
  if (begin == std::string::npos) return {};
  const std::size_t end = rule.find('"', begin + key.size());
  std::stringstream ids(rule.substr(begin + key.size(), end - begin - key.size()));
  std::set<std::string> found;
  for (std::string id; std::getline(ids, id, '|');) found.insert(id);
  return found;
}

TEST(UdevRule, NamesExactlyTheModelsOfTheDrivers) {
  std::set<std::string> nikon, pie;
  for (const Model& model : models()) {
    if (model.product_id != 0) nikon.insert(hex4(model.product_id));
  }
  for (const pieusb::Model& model : pieusb::models()) pie.insert(hex4(model.product_id));
  EXPECT_EQ(ids_in_rule(kNikonVendorId), nikon);
  EXPECT_EQ(ids_in_rule(pieusb::kGenesysVendorId), pie);
}

TEST(UdevRule, GivesAccessToThePersonAtTheSeatOnly) {
  const std::string rule = rule_text();
  EXPECT_NE(rule.find("TAG+=\"uaccess\""), std::string::npos);
  EXPECT_NE(rule.find("MODE=\"0660\""), std::string::npos);
  EXPECT_EQ(rule.find("0666"), std::string::npos);
}

TEST(UdevRule, LetsNoUnitSleepAndServesBenchesWithoutASeat) {
  std::istringstream lines(rule_text());
  int n_usb = 0, n_sg = 0;
  for (std::string line; std::getline(lines, line);) {
    if (line.find("MODE=") == std::string::npos) continue;
    const bool is_usb = line.find("idVendor") != std::string::npos;
    ++(is_usb ? n_usb : n_sg);
    EXPECT_NE(line.find("GROUP=\"scanner\""), std::string::npos) << line;
    EXPECT_NE(line.find("TAG+=\"uaccess\""), std::string::npos) << line;
    if (is_usb) {
      EXPECT_NE(line.find("ATTR{power/control}=\"on\""), std::string::npos) << line;
    } else {
      EXPECT_NE(line.find("SUBSYSTEM==\"scsi_generic\""), std::string::npos) << line;
    }
  }
  EXPECT_EQ(n_usb, 2);
  const bool any_scsi = std::any_of(models().begin(), models().end(),
                                    [](const Model& model) { return model.product_id == 0; });
  EXPECT_EQ(n_sg, any_scsi ? 1 : 0);
}

TEST(UdevRule, SortsBeforeTheRuleThatActsOnTheTag) {
  const std::string path = RESEAU_UDEV_RULE;
  EXPECT_LT(path.substr(path.rfind('/') + 1), "73-seat-late.rules");
}

TEST(Models, AreFoundByBothNames) {
  for (const Model& model : models()) {
    if (model.product_id != 0) {
      EXPECT_EQ(model_by_usb_id(kNikonVendorId, model.product_id), &model);
    }
    EXPECT_EQ(model_by_product(model.product), &model);
  }
  EXPECT_EQ(model_by_product("LS-5000"), nullptr);
  EXPECT_EQ(model_by_usb_id(0x04B8, 0x4002), nullptr);
}

}  // namespace
}  // namespace reseau::coolscan
