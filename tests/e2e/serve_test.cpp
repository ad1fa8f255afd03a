// The local page of a running scan, asked as a browser asks.
#include <cmath>
#include <csignal>
#include <cstdint>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <httplib.h>
#include <png.h>

#include "capture/image/exr_file.h"
#include "tests/e2e/reseau_run.h"

namespace reseau::testing {
namespace {

using std::chrono::seconds;
using ::testing::HasSubstr;

// The next event of that name as it comes; null when none does.
nlohmann::json next_event(Process& process, const std::string& name) {
  nlohmann::json found;
  EXPECT_TRUE(process.wait_for_line(
      [&](const std::string& line) {
        const auto event = nlohmann::json::parse(line, nullptr, false);
        if (!event.is_object() || event.value("event", "") != name) return false;
        found = event;
        return true;
      },
      seconds(120)))
      << name;
  return found;
}

std::string get(httplib::Client& browser, const std::string& path) {
  const httplib::Result answer = browser.Get(path.c_str());
  if (!answer || answer->status != 200) {
    ADD_FAILURE() << path << ": " << (answer ? answer->status : -1);
    return {};
  }
  return answer->body;
}

// Linear samples of an sRGB PNG.
std::vector<float> decode(const std::string& bytes) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  EXPECT_NE(png_image_begin_read_from_memory(&image, bytes.data(), bytes.size()), 0);
  image.format = PNG_FORMAT_RGB;
  std::vector<std::uint8_t> samples(PNG_IMAGE_SIZE(image));
  EXPECT_NE(png_image_finish_read(&image, nullptr, samples.data(), 0, nullptr), 0);
  std::vector<float> linear;
  for (const std::uint8_t sample : samples) {
    const float v = static_cast<float>(sample) / 255;
    linear.push_back(v <= 0.04045F ? v / 12.92F : std::pow((v + 0.055F) / 1.055F, 2.4F));
  }
  return linear;
}

TEST(ServeE2e, ShowsColourWhileTheFilmMovesAndThenTheFinalPicture) {
  const TempDir dir;
  Process process(command({"serve", "-d", "sim:ls5000?seed=5&pace=real", "-x", "9mm", "-y", "5mm",
                           "-o", dir / "a.tif", "--listen", "127.0.0.1:0", "--json"}));
  std::string url = next_event(process, "page").value("url", "");
  ASSERT_THAT(url, HasSubstr("http://127.0.0.1:"));
  url.pop_back();
  httplib::Client browser(url);
  EXPECT_THAT(get(browser, "/"), HasSubstr("<!doctype html>"));
  auto state = nlohmann::json::parse(get(browser, "/state.json"));
  EXPECT_EQ(state["schema"], "reseau-live/1");
  EXPECT_EQ(state["lines_shown"], 0);

  const int n_rows = next_event(process, "plan").value("rows", 0);
  const nlohmann::json live = next_event(process, "live");
  ASSERT_TRUE(live.is_object());
  EXPECT_LT(live["rows_committed"], n_rows) << "no colour before the last line";
  state = nlohmann::json::parse(get(browser, "/state.json"));
  EXPECT_GE(state["lines_shown"], live["rows_shown"]);
  EXPECT_GT(state["strips"][0], 0);
  EXPECT_EQ(get(browser, "/strip/0.png").substr(1, 3), "PNG");

  // Another's port is refused before anything is done; another's name is turned away.
  const ProcessResult second =
      reseau({"serve", "-d", kDevice, "-o", dir / "b.tif", "--listen", url.substr(7)});
  EXPECT_NE(second.exit_code, 0);
  EXPECT_THAT(second.err, HasSubstr("Choose another port"));
  EXPECT_FALSE(std::filesystem::exists(dir / "b.tif"));
  const auto strange = browser.Get("/state.json", httplib::Headers{{"Host", "elsewhere.example"}});
  ASSERT_TRUE(strange);
  EXPECT_EQ(strange->status, 403);

  while (!state.value("ended", false)) {
    state = nlohmann::json::parse(get(browser, "/state.json"), nullptr, false);
    ASSERT_TRUE(state.is_object());
  }
  EXPECT_EQ(get(browser, "/picture.png"), file_bytes(dir / "a.png"));
  EXPECT_EQ(get(browser, "/receipt.json"), file_bytes(dir / "a.json"));
  const auto receipt = nlohmann::json::parse(file_bytes(dir / "a.json"));
  const nlohmann::json& provisional = receipt["provisional"];
  EXPECT_FALSE(provisional.contains("why_not"));
  EXPECT_GT(provisional["tiles"], 0);
  fmt::print("{}\nlast line to picture: {} s\n", provisional.dump(),
             receipt["timings"]["last_line_to_picture_s"].dump());

  // The provisional picture, as it was shown last, against the final one: at this size a pixel of
  // the page is one of the scan.
  ASSERT_EQ(state["step"], 1);
  ExrReader exr(dir / "a.exr");
  const int width = exr.width_px(), n = state["strip_rows"];
  std::vector<float> final_rgb(static_cast<std::size_t>(width) * static_cast<std::size_t>(n) * 3);
  exr.read(n, n, final_rgb);
  const std::vector<float> shown = decode(get(browser, "/strip/1.png"));
  ASSERT_EQ(shown.size(), final_rgb.size());
  const float exposure = state["exposure"];
  double sum = 0;
  for (std::size_t i = 0; i < shown.size(); ++i)
    sum += std::abs(shown[i] - std::min(1.0F, std::max(0.0F, exposure * final_rgb[i])));
  EXPECT_LT(sum / static_cast<double>(shown.size()), 0.02);

  process.send(SIGINT);
  EXPECT_EQ(process.wait(seconds(60)).exit_code, 0);
}

TEST(ServeE2e, ThePictureIsTheSameWithAndWithoutAPageAndOffline) {
  const TempDir dir;
  const auto scan = [&](const std::string& name, bool page) {
    auto arguments = small_scan("sim:ls5000?seed=5&noise=0.002", dir / (name + ".tif"));
    if (page) arguments.emplace_back("--page");
    const ProcessResult result = reseau(arguments);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return ExrReader(dir / (name + ".exr"));
  };
  ExrReader plain = scan("plain", false), shown = scan("shown", true);
  ASSERT_EQ(reseau({"reconstruct", dir / "shown.tif", "-o", dir / "again"}).exit_code, 0);
  ExrReader again(dir / "again" / "shown.exr");
  const auto pixels = [](ExrReader& exr) {
    std::vector<float> rgb(static_cast<std::size_t>(exr.width_px()) *
                           static_cast<std::size_t>(exr.height_px()) * 3);
    exr.read(0, exr.height_px(), rgb);
    return rgb;
  };
  EXPECT_EQ(pixels(shown), pixels(plain));
  EXPECT_EQ(pixels(shown), pixels(again));
}

TEST(ServeE2e, AFilmWithoutAScreenGetsItsMasterAndAWord) {
  const TempDir dir;
  auto arguments = small_scan("sim:ls5000?film=none", dir / "a.tif");
  arguments.insert(arguments.end(), {"--page", "--json"});
  const ProcessResult result = reseau(arguments);
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(events_of(json_lines(result.out), "live").empty());
  const auto receipt = nlohmann::json::parse(file_bytes(dir / "a.json"));
  EXPECT_EQ(receipt["provisional"]["why_not"], "No réseau was found while lines came.");
}

}  // namespace
}  // namespace reseau::testing
