#include "capture/store/names.h"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <system_error>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <unistd.h>

#include "core/base/error.h"

namespace reseau {
namespace {

constexpr int kMaxNumber = 999'999;

std::string lower(std::string_view text) {
  std::string out(text);
  std::ranges::transform(out, out.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return out;
}

// Names in the folder, lower case, without a leading dot.
std::vector<std::string> siblings(const std::filesystem::path& directory,
                                  const std::filesystem::path& except) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(directory)) {
    if (entry.path().filename() == except.filename()) continue;
    std::string name = lower(entry.path().filename().string());
    if (name.starts_with('.')) name.erase(0, 1);
    names.push_back(std::move(name));
  }
  return names;
}

// What may follow the name in a file that uses it.
enum class Tail {
  kExtension,  // "scan.tif", "scan.partial.tif"; "scan_01.tif" is another name
  kAnything,   // "box3_07_preview.png" as well; not "box3_070.tif"
};

bool uses(const std::string& file, const std::string& name, Tail tail) {
  if (!file.starts_with(name)) return false;
  if (file.size() == name.size()) return true;
  const auto next = static_cast<unsigned char>(file[name.size()]);
  return tail == Tail::kExtension ? next == '.' : std::isalnum(next) == 0;
}

// The number in "{stem}_{digits}…", or 0.
int number_of(const std::string& file, const std::string& stem) {
  if (!file.starts_with(stem) || file.size() <= stem.size() || file[stem.size()] != '_') return 0;
  int number = 0;
  const char* begin = file.data() + stem.size() + 1;
  const auto result = std::from_chars(begin, file.data() + file.size(), number);
  const bool ends = result.ptr == file.data() + file.size() ||
                    std::isalpha(static_cast<unsigned char>(*result.ptr)) == 0;
  if (result.ec != std::errc() || !ends || number < 0 || number > kMaxNumber) return 0;
  return number;
}

std::string numbered(const std::string& stem, int number) {
  char digits[16];
  std::snprintf(digits, sizeof digits, "_%02d", number);
  return stem + digits;
}

void require_plain(const std::string& name) {
  if (name.empty() || name != safe_file_name(name)) {
    throw InputError("'" + name +
                     "' cannot be a file name here; use letters, digits, '-', '_' and '.' only.");
  }
}

InputError taken(const std::string& name, const std::filesystem::path& directory) {
  return InputError("The name '" + name + "' is in use in '" + directory.string() +
                    "'; nothing is ever overwritten, choose another name or number.");
}

// False when somebody holds it.
bool create_lock(const std::filesystem::path& path) {
  const int fd = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (fd >= 0) {
    ::close(fd);
    return true;
  }
  if (errno == EEXIST) return false;
  throw std::system_error(errno, std::generic_category(),
                          "The folder '" + path.parent_path().string() + "' cannot be written");
}

void make_folder(const std::filesystem::path& directory) {
  std::error_code error;
  std::filesystem::create_directories(directory, error);
  if (error || !std::filesystem::is_directory(directory)) {
    if (!error) error = std::make_error_code(std::errc::not_a_directory);
    throw std::system_error(error, "The folder '" + directory.string() + "' cannot be made");
  }
}

std::filesystem::path lock_path_of(const std::filesystem::path& directory,
                                   const std::string& name) {
  std::string file(".");
  return directory / file.append(lower(name)).append(".reserved");
}

bool any_uses(const std::vector<std::string>& files, const std::string& name, Tail tail) {
  const std::string key = lower(name);
  return std::ranges::any_of(files, [&](const std::string& file) { return uses(file, key, tail); });
}

// Takes the name if nobody uses it. A file may have come between the look and the lock, hence the
// second look.
bool take(const std::filesystem::path& directory, const std::string& name, Tail tail) {
  if (any_uses(siblings(directory, {}), name, tail)) return false;
  const auto lock = lock_path_of(directory, name);
  if (!create_lock(lock)) return false;
  if (!any_uses(siblings(directory, lock), name, tail)) return true;
  ::unlink(lock.c_str());
  return false;
}

}  // namespace

std::filesystem::path NameReservation::path(std::string_view suffix) const {
  return directory_ / (name_ + std::string(suffix));
}

NameReservation::~NameReservation() {
  if (!lock_path_.empty()) ::unlink(lock_path_.c_str());
}

NameReservation::NameReservation(NameReservation&& other) noexcept
    : directory_(std::move(other.directory_)),
      lock_path_(std::exchange(other.lock_path_, {})),
      name_(std::move(other.name_)),
      number_(other.number_) {}

NameReservation& NameReservation::operator=(NameReservation&& other) noexcept {
  std::swap(directory_, other.directory_);
  std::swap(lock_path_, other.lock_path_);
  std::swap(name_, other.name_);
  std::swap(number_, other.number_);
  return *this;
}

NameReservation reserve_exact(const std::filesystem::path& directory, const std::string& name) {
  require_plain(name);
  make_folder(directory);
  if (!take(directory, name, Tail::kExtension)) throw taken(name, directory);
  NameReservation reservation;
  reservation.directory_ = directory;
  reservation.name_ = name;
  reservation.lock_path_ = lock_path_of(directory, name);
  return reservation;
}

NameReservation reserve_numbered(const std::filesystem::path& directory, const std::string& stem,
                                 std::optional<int> number) {
  require_plain(stem);
  make_folder(directory);
  if (number && (*number < 1 || *number > kMaxNumber)) {
    throw InputError("The number of a frame must lie between 1 and 999999.");
  }
  for (;;) {
    int candidate = number.value_or(1);
    if (!number) {
      for (const std::string& file : siblings(directory, {})) {
        candidate = std::max(candidate, number_of(file, lower(stem)) + 1);
      }
    }
    if (candidate > kMaxNumber) throw taken(numbered(stem, kMaxNumber), directory);
    const std::string name = numbered(stem, candidate);
    if (take(directory, name, Tail::kAnything)) {
      NameReservation reservation;
      reservation.directory_ = directory;
      reservation.name_ = name;
      reservation.number_ = candidate;
      reservation.lock_path_ = lock_path_of(directory, name);
      return reservation;
    }
    if (number) throw taken(name, directory);
  }
}

std::string safe_file_name(std::string_view text) {
  std::string out;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    const bool plain = byte < 0x80 && (std::isalnum(byte) != 0 || c == '-' || c == '_' || c == '.');
    out += plain ? c : '_';
  }
  const auto first = out.find_first_not_of('.');
  out.erase(0, std::min(first, out.size()));
  return out.empty() ? "_" : out;
}

}  // namespace reseau
