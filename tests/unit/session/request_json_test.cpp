#include "capture/session/request_json.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/base/error.h"

namespace reseau {
namespace {

RecordedRequest everything() {
  RecordedRequest recorded;
  recorded.device_name = "sim:ls5000?seed=3";
  recorded.started_at_utc = "2026-11-22T10:15:00Z";
  ScanRequest& r = recorded.request;
  r.resolution_dpi = 2000;
  r.area = {0.1, 2.25, 1.0 / 3.0, 4};
  r.depth_bits = 14;
  r.infrared = false;
  r.focus.mode = FocusRequest::Mode::kPosition;
  r.focus.position = 217;
  r.focus.x_mm = 3.5;
  r.exposure.mode = ExposureRequest::Mode::kFixed;
  r.exposure.factor = 1.25;
  r.exposure.exposure_us = {800.5, std::nullopt, 1200, 0.1};
  r.exposure.lock = false;
  r.frame = 4;
  r.frame_offset_mm = -0.25;
  r.samples = 8;
  r.sensor_lines = SensorLines::kAll;
  r.overview = true;
  return recorded;
}

TEST(RequestJson, RoundTripIsExact) {
  const RecordedRequest one = everything();
  const auto two = recorded_request_from_json(recorded_request_to_json(one), "test");
  ASSERT_TRUE(two.has_value());
  EXPECT_EQ(two->device_name, one.device_name);
  EXPECT_EQ(two->started_at_utc, one.started_at_utc);
  const ScanRequest& a = one.request;
  const ScanRequest& b = two->request;
  EXPECT_EQ(a.resolution_dpi, b.resolution_dpi);
  EXPECT_EQ(a.area.left_mm, b.area.left_mm);
  EXPECT_EQ(a.area.top_mm, b.area.top_mm);
  EXPECT_EQ(a.area.width_mm, b.area.width_mm);
  EXPECT_EQ(a.area.height_mm, b.area.height_mm);
  EXPECT_EQ(a.depth_bits, b.depth_bits);
  EXPECT_EQ(a.infrared, b.infrared);
  EXPECT_EQ(a.focus.mode, b.focus.mode);
  EXPECT_EQ(a.focus.position, b.focus.position);
  EXPECT_EQ(a.focus.x_mm, b.focus.x_mm);
  EXPECT_EQ(a.focus.y_mm, b.focus.y_mm);
  EXPECT_EQ(a.exposure.mode, b.exposure.mode);
  EXPECT_EQ(a.exposure.factor, b.exposure.factor);
  EXPECT_EQ(a.exposure.exposure_us, b.exposure.exposure_us);
  EXPECT_EQ(a.exposure.lock, b.exposure.lock);
  EXPECT_EQ(a.frame, b.frame);
  EXPECT_EQ(a.frame_offset_mm, b.frame_offset_mm);
  EXPECT_EQ(a.samples, b.samples);
  EXPECT_EQ(a.sensor_lines, b.sensor_lines);
  EXPECT_EQ(a.overview, b.overview);
  EXPECT_EQ(recorded_request_to_json(*two), recorded_request_to_json(one));
}

TEST(RequestJson, AnOrdinaryScanNamesReadingsLinesAndOffsetToo) {
  const nlohmann::ordered_json object = request_to_json({});
  EXPECT_EQ(object.at("samples"), 1);
  EXPECT_EQ(object.at("sensor_lines"), "auto");
  EXPECT_EQ(object.at("frame_offset_mm"), 0.0);
}

TEST(RequestJson, SensorLinesOfEarlierRecordingsAreNumbers) {
  const auto lines = [](const std::string& value) {
    return recorded_request_from_json(
               R"({"schema":"reseau-request/1","request":{"sensor_lines":)" + value + "}}", "test")
        ->request.sensor_lines;
  };
  EXPECT_EQ(lines("1"), SensorLines::kOne);
  EXPECT_EQ(lines("2"), SensorLines::kAll);
  EXPECT_EQ(lines("\"one\""), SensorLines::kOne);
  EXPECT_THROW((void)lines("3"), InputError);
  EXPECT_THROW((void)lines("\"two\""), InputError);
}

TEST(RequestJson, OtherCommentsAreNotOurs) {
  for (const char* text :
       {"", "Nikon Scan 4", "{", "[]", "{}", R"({"schema":7})", R"({"schema":"somebody/1"})"}) {
    EXPECT_FALSE(recorded_request_from_json(text, "test").has_value()) << text;
  }
}

TEST(RequestJson, ADamagedRequestIsRefusedByName) {
  for (const char* body : {R"("request":5)", R"("request":{"resolution_dpi":"many"})",
                           R"("request":{"focus":{"mode":"soft"}})",
                           R"("request":{"exposure":{"mode":1}})", R"("device":[1])"}) {
    const std::string text = std::string(R"({"schema":"reseau-request/1",)") + body + "}";
    try {
      static_cast<void>(recorded_request_from_json(text, "box3.pcapng"));
      FAIL() << text;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find("box3.pcapng"), std::string::npos);
    }
  }
}

}  // namespace
}  // namespace reseau
