#include <algorithm>
#include <fstream>
#include <set>
#include <sstream>
#include <string>

#include <gtest/gtest.h>

#include "drivers/coolscan/models.h"

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

TEST(UdevRule, NamesExactlyTheModelsOfTheDriver) {
  const std::string rule = rule_text();
  const std::string key = "ATTR{idProduct}==\"";
  const std::size_t begin = rule.find(key);
  ASSERT_NE(begin, std::string::npos);
  const std::size_t end = rule.find('"', begin + key.size());
  std::stringstream ids(rule.substr(begin + key.size(), end - begin - key.size()));
  std::set<std::string> in_rule, in_table;
  for (std::string id; std::getline(ids, id, '|');) in_rule.insert(id);
  for (const Model& model : models()) {
    if (model.product_id != 0) in_table.insert(hex4(model.product_id));
  }
  EXPECT_EQ(in_rule, in_table);
  EXPECT_NE(rule.find("ATTR{idVendor}!=\"" + hex4(kNikonVendorId) + "\""), std::string::npos);
}

TEST(UdevRule, GivesAccessToThePersonAtTheSeatOnly) {
  const std::string rule = rule_text();
  EXPECT_NE(rule.find("TAG+=\"uaccess\""), std::string::npos);
  EXPECT_NE(rule.find("MODE=\"0660\""), std::string::npos);
  EXPECT_EQ(rule.find("0666"), std::string::npos);
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
