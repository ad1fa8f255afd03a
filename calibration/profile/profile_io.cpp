#include "calibration/profile/profile_io.h"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <system_error>

#include <fcntl.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "calibration/profile/profile_fields.h"
#include "calibration/profile/records_io.h"
#include "core/base/error.h"

namespace reseau {
namespace {

using profile::Fields;
using profile::Json;
constexpr const char* kSchema = "reseau.profile/1";
constexpr std::uintmax_t kMaxFileBytes = std::uintmax_t{64} << 20;

Json channel_to_json(const Profile& profile, std::size_t c) {
  Json json = Json::object();
  if (const auto& psf = profile.psf[c]) {
    json["psf"] = {{"sigma_px", psf->sigma_px}, {"sd_px", psf->sd_px}};
  }
  if (!profile.transfer[c].empty()) {
    Json f = Json::array(), value = Json::array(), sd = Json::array();
    for (const TransferPoint& point : profile.transfer[c]) {
      f.push_back(point.f_cy_per_px);
      value.push_back(point.value);
      sd.push_back(point.sd);
    }
    json["transfer"] = {{"f_cy_per_px", f}, {"value", value}, {"sd", sd}};
  }
  if (const auto& offset = profile.offset_from_green_px[c]) {
    json["offset_from_green_px"] = {offset->x, offset->y};
  }
  if (const auto& dark = profile.dark_level[c]) json["dark_level"] = *dark;
  if (const auto& noise = profile.noise[c]) json["noise"] = {{"a", noise->a}, {"b", noise->b}};
  if (!profile.flat_gain[c].empty()) json["flat_gain"] = profile.flat_gain[c];
  profile::put_records(profile, c, json);
  return json;
}

void channel_from_json(const Fields& fields, std::size_t c, Profile& profile) {
  if (const auto psf = fields.object("psf")) {
    profile.psf[c] = PsfWidth{psf->number("sigma_px"), psf->number("sd_px")};
  }
  if (const auto transfer = fields.object("transfer")) {
    const auto f = transfer->numbers("f_cy_per_px"), value = transfer->numbers("value"),
               sd = transfer->numbers("sd");
    if (f.size() != value.size() || f.size() != sd.size()) {
      throw fields.error("transfer", "must hold as many values and deviations as frequencies");
    }
    for (std::size_t i = 0; i < f.size(); ++i)
      profile.transfer[c].push_back({f[i], value[i], sd[i]});
  }
  if (fields.has("offset_from_green_px")) {
    const auto xy = fields.numbers("offset_from_green_px");
    if (xy.size() != 2) throw fields.error("offset_from_green_px", "must hold x and y");
    profile.offset_from_green_px[c] = Vec2{xy[0], xy[1]};
  }
  if (fields.has("dark_level")) profile.dark_level[c] = fields.number("dark_level");
  if (const auto noise = fields.object("noise")) {
    profile.noise[c] = NoiseModel{noise->number("a"), noise->number("b")};
  }
  if (fields.has("flat_gain")) profile.flat_gain[c] = fields.numbers("flat_gain");
  profile::get_records(fields, c, profile);
}

Profile profile_of(const Fields& fields) {
  if (const auto schema = fields.text("schema"); schema != kSchema) {
    throw fields.error("schema", schema.starts_with("reseau.profile/")
                                     ? "names a version that this program does not know; use the "
                                       "program that wrote it or calibrate again"
                                     : "is not 'reseau.profile/1': this is no calibration profile");
  }
  Profile profile;
  profile.make = fields.text("make");
  profile.model = fields.text("model");
  profile.serial = fields.text("serial");
  profile.firmware = fields.text("firmware");
  profile.holder = fields.text("holder");
  profile.resolution_dpi = fields.number("resolution_dpi");
  if (fields.has("focus_position")) {
    const double focus = fields.number("focus_position");
    if (focus != std::floor(focus) || std::abs(focus) > 1e9) {
      throw fields.error("focus_position", "must be a whole number");
    }
    profile.focus_position = static_cast<int>(focus);
  }
  profile.measured_at_utc = fields.text("measured_at_utc");
  profile.tool_version = fields.text("tool_version");
  if (const auto channels = fields.object("channels")) {
    for (std::size_t c = 0; c < kProfileChannels; ++c) {
      if (const auto channel = channels->object(kProfileChannelNames[c])) {
        channel_from_json(*channel, c, profile);
      }
    }
  }
  if (const auto model = fields.object("psf_model")) {
    profile.psf_model = profile::psf_record_from(*model);
  }
  if (const auto provenance = fields.object("provenance")) {
    profile.source_file = provenance->text("source_file");
    profile.source_sha256 = provenance->text("source_sha256");
    profile.method = provenance->text("method");
    profile.remarks = provenance->texts("remarks");
  }
  return profile;
}

std::string safe_name(const std::string& text) {
  std::string out;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    out += byte < 0x80 && (std::isalnum(byte) != 0 || c == '-' || c == '_') ? c : '_';
  }
  return out.empty() ? "unknown" : out;
}

[[noreturn]] void fail(int error, const std::filesystem::path& path, const char* what) {
  throw std::system_error(error, std::generic_category(),
                          "The calibration profile '" + path.string() + "' cannot be " + what);
}

void write_all(int fd, const std::string& text, const std::filesystem::path& path) {
  std::size_t done = 0;
  while (done < text.size()) {
    const ssize_t n = ::write(fd, text.data() + done, text.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) fail(n < 0 ? errno : ENOSPC, path, "written");
    done += static_cast<std::size_t>(n);
  }
  if (::fsync(fd) != 0) fail(errno, path, "written");
}

// Newer first; at the wanted resolution before any other.
bool better(const Profile& a, const Profile& b, double dpi) {
  const auto fits = [&](const Profile& p) {
    return dpi <= 0 || std::abs(p.resolution_dpi - dpi) <= 0.01 * p.resolution_dpi;
  };
  if (fits(a) != fits(b)) return fits(a);
  return a.measured_at_utc > b.measured_at_utc;
}

}  // namespace

std::string profile_to_json(const Profile& profile) {
  validate(profile);
  Json json;
  json["schema"] = kSchema;
  json["make"] = profile.make;
  json["model"] = profile.model;
  json["serial"] = profile.serial;
  json["firmware"] = profile.firmware;
  json["holder"] = profile.holder;
  json["resolution_dpi"] = profile.resolution_dpi;
  if (profile.focus_position) json["focus_position"] = *profile.focus_position;
  json["measured_at_utc"] = profile.measured_at_utc;
  json["tool_version"] = profile.tool_version;
  Json channels = Json::object();
  for (std::size_t c = 0; c < kProfileChannels; ++c) {
    Json channel = channel_to_json(profile, c);
    if (!channel.empty()) channels[kProfileChannelNames[c]] = std::move(channel);
  }
  json["channels"] = std::move(channels);
  if (profile.psf_model) json["psf_model"] = profile::psf_record_to_json(*profile.psf_model);
  json["provenance"] = {{"source_file", profile.source_file},
                        {"source_sha256", profile.source_sha256},
                        {"method", profile.method},
                        {"remarks", profile.remarks}};
  // File names need not be UTF-8; JSON must be.
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

Profile profile_from_json(std::string_view text, const std::string& source) {
  Json json;
  try {
    json = Json::parse(text);
  } catch (const nlohmann::json::exception& error) {
    throw InputError("The calibration profile '" + source + "' is not JSON (" + error.what() +
                     ").");
  }
  Profile profile = profile_of(Fields(json, source, ""));
  try {
    validate(profile);
  } catch (const InputError& error) {
    throw InputError(std::string(error.what()) + " It was read from '" + source + "'.");
  }
  return profile;
}

Profile load_profile(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) {
    if (error && error != std::errc::no_such_file_or_directory) fail(error.value(), path, "read");
    throw InputError("There is no calibration profile '" + path.string() + "'.");
  }
  if (std::filesystem::file_size(path) > kMaxFileBytes) {
    throw InputError("The file '" + path.string() + "' is too large for a calibration profile.");
  }
  errno = 0;
  std::ifstream in(path, std::ios::binary);
  if (!in) fail(errno != 0 ? errno : EIO, path, "read");
  const std::string text{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  if (in.bad()) fail(EIO, path, "read");
  return profile_from_json(text, path.string());
}

void save_profile(const Profile& profile, const std::filesystem::path& path) {
  const std::string text = profile_to_json(profile);
  std::error_code error;
  if (path.has_parent_path()) std::filesystem::create_directories(path.parent_path(), error);
  if (error) fail(error.value(), path, "written");
  std::string name(".");
  name.append(path.filename().string()).append(".").append(std::to_string(::getpid()));
  const auto part = path.parent_path() / name.append(".part");
  const int fd = ::open(part.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOFOLLOW, 0666);
  if (fd < 0) fail(errno, path, "written");
  try {
    write_all(fd, text, path);
    if (::rename(part.c_str(), path.c_str()) != 0) fail(errno, path, "written");
  } catch (...) {
    ::close(fd);
    ::unlink(part.c_str());
    throw;
  }
  ::close(fd);
}

std::filesystem::path default_profile_directory() {
  // The XDG rules: a relative path there is to be ignored.
  const char* data = std::getenv("XDG_DATA_HOME");
  if (data != nullptr && data[0] == '/') {
    return std::filesystem::path(data) / "reseau" / "calibrations";
  }
  const char* home = std::getenv("HOME");
  return std::filesystem::path(home != nullptr ? home : "/") / ".local" / "share" / "reseau" /
         "calibrations";
}

std::filesystem::path profile_path(const std::filesystem::path& directory, const Profile& profile) {
  const std::string unit =
      safe_name(profile.model) + "-" + (profile.serial.empty() ? "" : safe_name(profile.serial));
  char dpi[32];
  std::snprintf(dpi, sizeof dpi, "-%.0fdpi.json", profile.resolution_dpi);
  return directory / unit / (safe_name(profile.measured_at_utc) + dpi);
}

ProfileSearch find_profile(const std::filesystem::path& directory, const std::string& model,
                           const std::string& serial, double dpi) {
  ProfileSearch search;
  std::error_code error;
  std::vector<std::filesystem::path> files;
  for (std::filesystem::recursive_directory_iterator
           it(directory, std::filesystem::directory_options::skip_permission_denied, error),
       end;
       !error && it != end; it.increment(error)) {
    if (it->path().extension() == ".json") files.push_back(it->path());
  }
  std::ranges::sort(files);
  for (const auto& path : files) {
    try {
      Profile profile = load_profile(path);
      if (profile.model != model || profile.serial != serial) continue;
      if (!search.found || better(profile, search.found->profile, dpi)) {
        search.found = FoundProfile{path, std::move(profile)};
      }
    } catch (const std::exception& problem) {
      search.problems.emplace_back(problem.what());
    }
  }
  return search;
}

}  // namespace reseau
