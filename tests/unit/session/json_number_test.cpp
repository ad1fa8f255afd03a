#include "capture/session/json_number.h"

#include <limits>

#include <gtest/gtest.h>

namespace reseau {
namespace {

TEST(JsonNumber, FiniteNumbersAreNumbers) {
  nlohmann::ordered_json object = nlohmann::ordered_json::object();
  put_number(object, "a", 1.5);
  EXPECT_EQ(object.dump(), R"({"a":1.5})");
}

TEST(JsonNumber, WhatIsNotFiniteIsNullWithAReason) {
  nlohmann::ordered_json object = nlohmann::ordered_json::object();
  put_number(object, "a", std::numeric_limits<double>::quiet_NaN());
  put_number(object, "b", -std::numeric_limits<double>::infinity(), "no light");
  EXPECT_TRUE(object["a"].is_null());
  EXPECT_TRUE(object["b"].is_null());
  EXPECT_EQ(object["not_available"]["a"], "not a finite number");
  EXPECT_EQ(object["not_available"]["b"], "no light");
}

}  // namespace
}  // namespace reseau
