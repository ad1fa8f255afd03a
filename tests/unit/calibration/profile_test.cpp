#include "calibration/profile/profile.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <random>
#include <system_error>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibration/profile/profile_io.h"
#include "core/base/error.h"
#include "tests/support/temp_dir.h"

namespace reseau {
namespace {

using testing::HasSubstr;

Profile full_profile() {
  Profile profile;
  profile.make = "Nikon";
  profile.model = "LS-5000 ED";
  profile.serial = "A\"1\"/2";
  profile.firmware = "1.02";
  profile.holder = "MA-21";
  profile.resolution_dpi = 4000;
  profile.focus_position = -213;
  profile.measured_at_utc = "2026-11-22T10:15:00Z";
  profile.tool_version = "0.1.0";
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> any(1e-9, 0.9);
  for (std::size_t c = 0; c < kProfileChannels; ++c) {
    profile.psf[c] = PsfWidth{any(random), any(random)};
    profile.offset_from_green_px[c] = Vec2{-any(random), any(random)};
    for (int i = 0; i < 5; ++i)
      profile.transfer[c].push_back({0.1 * i + 0.01 * any(random), any(random), any(random)});
    profile.noise[c] = NoiseModel{any(random) * 1e-12, any(random)};
    profile.dark_level[c] = any(random);
    for (int i = 0; i < 100; ++i) profile.flat_gain[c].push_back(any(random));
  }
  profile.gate[1] = GateRecord{1e-6,
                               std::array{1e-9, -1e-10, 1e-11},
                               1e-4,
                               0.1,
                               0.01,
                               1e-5,
                               {{1.004, 1e-5}, {0.996, 1e-5}},
                               Measured{1e-4, 1e-6},
                               {}};
  profile.gate[1]->leakage[3] = Measured{0.02, 0.001};
  profile.focus[3] = FocusRecord{0.25,
                                 {209.5, 0.2},
                                 Measured{10, 0.3},
                                 Measured{20, 1},
                                 0.8,
                                 {{200, 0.4, 0.001}, {210, 0.5, 0.002}}};
  profile.offset_sd_px[2] = OffsetSd{0.01, 0.02};
  profile.random[1] = RandomRecord{7,
                                   3.2,
                                   2,
                                   0.5,
                                   {0.1, 0.2, 0.3, 0.4},
                                   {0.01, 0.01, 0.01, 0.02},
                                   0.02,
                                   {0.03, 0.002},
                                   Measured{0.24, 0.001},
                                   {},
                                   {{0, 1, 0}, {0.02, 0.99, 0.001}},
                                   {{0, 1, 0}}};
  PsfRecord model;
  model.names = {"a", "b"};
  model.values = {1, 2};
  model.sd = {0.1, 0};
  model.determined = {true, false};
  model.covariance = {0.01, 0, 0, 0};
  model.chi2_per_freedom = 1.1;
  model.field[0] = FieldRecord{0, {0.02}, {1e-6}, {{-1, 1, 0.02, 0.001}}};
  PsfFieldRecord surfaces;
  surfaces.frame_px = {1400, 1000};
  surfaces.edges = 24;
  surfaces.known = surfaces.has_focus = true;
  surfaces.focus = 200.5;
  surfaces.surfaces = {{"a", 1, true}, {"b", 0, false}};
  surfaces.coefficients = {1, 0.1, 0.2, 3};
  surfaces.covariance.assign(16, 0.01);
  surfaces.rank = 3;
  surfaces.scatter = 1.25;
  surfaces.correlated = {{"a", "b", -0.96}};
  surfaces.remarks = {"b cannot be told."};
  model.surfaces = surfaces;
  profile.psf_model = model;
  profile.psf[2].reset();
  profile.dark_level[3].reset();
  profile.source_file = "razor.tif";
  profile.source_sha256 = "ab12";
  profile.method = "slanted edge";
  profile.remarks = {"first", "zweite Zeile: ü"};
  return profile;
}

using Folder = test::TempDir;

std::string input_error(const std::function<void()>& action) {
  try {
    action();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(Profile, RoundTripIsExact) {
  const Profile profile = full_profile();
  const std::string text = profile_to_json(profile);
  EXPECT_EQ(profile_from_json(text, "x"), profile);
  EXPECT_EQ(profile_to_json(profile_from_json(text, "x")), text);
  Profile small;
  small.model = "LS-50";
  small.resolution_dpi = 0.1 + 0.2;
  EXPECT_EQ(profile_from_json(profile_to_json(small), "x"), small);
}

TEST(Profile, ValidationNamesTheField) {
  const auto broken = [](const std::function<void(Profile&)>& damage) {
    Profile profile = full_profile();
    damage(profile);
    return input_error([&] { validate(profile); });
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(broken([](Profile&) {}), "no error");
  EXPECT_THAT(broken([](Profile& p) { p.model.clear(); }), HasSubstr("'model'"));
  EXPECT_THAT(broken([](Profile& p) { p.resolution_dpi = 0; }), HasSubstr("'resolution_dpi'"));
  EXPECT_THAT(broken([&](Profile& p) {
                p.psf[3] = PsfWidth{nan, 0};
              }),
              HasSubstr("'psf.infrared'"));
  EXPECT_THAT(broken([](Profile& p) { p.psf[0]->sd_px = -1; }), HasSubstr("'psf.red'"));
  EXPECT_THAT(broken([&](Profile& p) { p.transfer[1][2].f_cy_per_px = 0; }),
              HasSubstr("'transfer.green'"));
  EXPECT_THAT(broken([&](Profile& p) { p.transfer[0][1].value = nan; }),
              HasSubstr("'transfer.red'"));
  EXPECT_THAT(broken([&](Profile& p) { p.offset_from_green_px[2]->y = nan; }),
              HasSubstr("'offset_from_green_px.blue'"));
  EXPECT_THAT(broken([](Profile& p) { p.dark_level[1] = 1.5; }), HasSubstr("'dark_level.green'"));
  EXPECT_THAT(broken([](Profile& p) { p.flat_gain[1][7] = 0; }), HasSubstr("'flat_gain.green'"));
  EXPECT_THAT(broken([](Profile& p) { p.noise[0]->b = -1; }), HasSubstr("'noise.red'"));
}

TEST(Profile, JsonErrorsNameSourceAndField) {
  const auto error = [](const std::string& text) {
    return input_error([&] { (void)profile_from_json(text, "file.json"); });
  };
  EXPECT_THAT(error(""), testing::AllOf(HasSubstr("file.json"), HasSubstr("not JSON")));
  EXPECT_THAT(error("[]"), HasSubstr("must be an object"));
  EXPECT_THAT(error("{}"), HasSubstr("'schema'"));
  EXPECT_THAT(error(R"({"schema":"reseau.profile/9"})"), HasSubstr("version"));
  const std::string head = R"({"schema":"reseau.profile/1","model":"x","resolution_dpi":)";
  EXPECT_EQ(error(head + "4000}"), "no error");
  EXPECT_THAT(error(head + "\"4000\"}"), HasSubstr("'resolution_dpi' must be a number"));
  EXPECT_THAT(error(head + "-1}"), HasSubstr("'resolution_dpi'"));
  EXPECT_THAT(error(head + "1,\"serial\":5}"), HasSubstr("'serial' must be text"));
  EXPECT_THAT(error(head + "1,\"focus_position\":1.5}"), HasSubstr("'focus_position'"));
  EXPECT_THAT(error(head + R"(1,"channels":{"red":{"psf":{"sigma_px":1}}}})"),
              HasSubstr("'channels.red.psf.sd_px'"));
  EXPECT_THAT(error(head + R"(1,"channels":{"red":{"offset_from_green_px":[1]}}})"),
              HasSubstr("'channels.red.offset_from_green_px'"));
  EXPECT_THAT(error(head + R"(1,"channels":{"blue":{"flat_gain":[1,"x"]}}})"),
              HasSubstr("'channels.blue.flat_gain'"));
}

// Whatever is done to the text: a profile or an InputError, never anything else.
TEST(Profile, DamagedTextNeverCrashes) {
  const std::string text = profile_to_json(full_profile());
  std::mt19937 random(11);
  int n_refused = 0;
  for (int i = 0; i < 3000; ++i) {
    std::string damaged = text;
    for (int k = 0; k < 3; ++k) {
      damaged[random() % damaged.size()] = static_cast<char>(random() & 0xFF);
    }
    if (i % 5 == 0) damaged.resize(random() % damaged.size());
    n_refused += input_error([&] { (void)profile_from_json(damaged, "x"); }) != "no error" ? 1 : 0;
  }
  EXPECT_GT(n_refused, 1000);
}

TEST(Profile, MismatchesAreSentences) {
  const Profile profile = full_profile();
  CaptureContext context;
  EXPECT_TRUE(mismatches(profile, context, 0).empty());
  context.model = profile.model;
  context.serial = profile.serial;
  EXPECT_TRUE(mismatches(profile, context, 4000.002).empty());
  context.serial = "other";
  context.firmware = "1.03";
  const auto found = mismatches(profile, context, 2000);
  ASSERT_EQ(found.size(), 3U);
  EXPECT_THAT(found[0], HasSubstr("serial number"));
  EXPECT_THAT(found[1], HasSubstr("firmware '1.02', the scan of '1.03'"));
  EXPECT_THAT(found[2], HasSubstr("4000 dpi, the scan has 2000 dpi"));
}

TEST(ProfileFiles, NewestOfThisUnitIsFound) {
  const Folder folder;
  EXPECT_FALSE(find_profile(folder.path() / "missing", "LS-5000 ED", "1").found.has_value());
  Profile profile = full_profile();
  const auto keep = [&](const char* serial, const char* date, double dpi) {
    profile.serial = serial;
    profile.measured_at_utc = date;
    profile.resolution_dpi = dpi;
    save_profile(profile, profile_path(folder.path(), profile));
  };
  keep("1", "2026-01-01T00:00:00Z", 4000);
  keep("1", "2026-03-01T00:00:00Z", 4000);
  keep("1", "2026-05-01T00:00:00Z", 2000);
  keep("2", "2026-06-01T00:00:00Z", 4000);
  std::ofstream(folder.path() / "broken.json") << "{";

  const auto any = find_profile(folder.path(), "LS-5000 ED", "1");
  ASSERT_TRUE(any.found.has_value());
  EXPECT_EQ(any.found->profile.measured_at_utc, "2026-05-01T00:00:00Z");
  EXPECT_EQ(any.found->path, profile_path(folder.path(), any.found->profile));
  ASSERT_EQ(any.problems.size(), 1U);
  EXPECT_THAT(any.problems[0], HasSubstr("broken.json"));
  const auto at = find_profile(folder.path(), "LS-5000 ED", "1", 4000);
  ASSERT_TRUE(at.found.has_value());
  EXPECT_EQ(at.found->profile.measured_at_utc, "2026-03-01T00:00:00Z");
  EXPECT_FALSE(find_profile(folder.path(), "LS-50", "1").found.has_value());
  EXPECT_FALSE(find_profile(folder.path(), "LS-5000 ED", "").found.has_value());
}

TEST(ProfileFiles, SavingReplacesWholeFilesOnly) {
  const Folder folder;
  const auto path = folder.path() / "sub" / "p.json";
  Profile profile = full_profile();
  save_profile(profile, path);
  profile.holder = "SA-30";
  save_profile(profile, path);
  EXPECT_EQ(load_profile(path), profile);
  const auto n_files = std::distance(std::filesystem::directory_iterator(folder.path() / "sub"),
                                     std::filesystem::directory_iterator());
  EXPECT_EQ(n_files, 1);
  profile.model.clear();
  EXPECT_THROW(save_profile(profile, path), InputError);
  EXPECT_THROW(save_profile(full_profile(), "/proc/none/p.json"), std::system_error);
  EXPECT_THROW((void)load_profile(folder.path() / "none.json"), InputError);
  EXPECT_THROW((void)load_profile(folder.path()), InputError);
}

TEST(ProfileFiles, FolderFollowsTheEnvironment) {
  const char* old = std::getenv("XDG_DATA_HOME");
  const std::string kept = old != nullptr ? old : "";
  ::setenv("XDG_DATA_HOME", "/data", 1);
  EXPECT_EQ(default_profile_directory(), "/data/reseau/calibrations");
  ::setenv("XDG_DATA_HOME", "relative", 1);
  EXPECT_THAT(default_profile_directory().string(),
              testing::EndsWith("/.local/share/reseau/calibrations"));
  if (old != nullptr) {
    ::setenv("XDG_DATA_HOME", kept.c_str(), 1);
  } else {
    ::unsetenv("XDG_DATA_HOME");
  }
}

}  // namespace
}  // namespace reseau
