#include "capture/store/part_file.h"

#include <cerrno>
#include <cstdio>
#include <string>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "capture/store/quoted.h"
#include "core/base/error.h"

namespace reseau {
namespace {

[[noreturn]] void throw_errno(int error, const std::string& sentence) {
  throw std::system_error(error, std::generic_category(), sentence);
}

bool exists_at(const std::filesystem::path& path) {
  struct stat status {};
  return ::lstat(path.c_str(), &status) == 0;
}

InputError taken(const std::filesystem::path& path) {
  return InputError("The file " + quoted(path) +
                    " exists already and is never overwritten unasked; choose another name.");
}

// The name may have been given to another file between open and lock.
bool still_at(int fd, const std::filesystem::path& path) {
  struct stat by_fd {
  }, by_path{};
  return ::fstat(fd, &by_fd) == 0 && ::lstat(path.c_str(), &by_path) == 0 &&
         by_fd.st_ino == by_path.st_ino && by_fd.st_dev == by_path.st_dev;
}

int open_scratch(const std::filesystem::path& path) {
  for (;;) {
    const int fd = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0666);
    if (fd < 0) throw_errno(errno, "The file " + quoted(path) + " cannot be created");
    // A file system without locks is no reason to refuse.
    if (::flock(fd, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
      ::close(fd);
      throw InputError("Another program is writing " + quoted(path) +
                       "; wait until it is done or choose another name.");
    }
    if (!still_at(fd, path)) {
      ::close(fd);
      continue;
    }
    if (::ftruncate(fd, 0) != 0) {
      const int error = errno;
      ::close(fd);
      throw_errno(error, "The file " + quoted(path) + " cannot be emptied");
    }
    return fd;
  }
}

int open_precious(const std::filesystem::path& path) {
  const int fd = ::open(path.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0666);
  if (fd >= 0) {
    ::flock(fd, LOCK_EX | LOCK_NB);
    return fd;
  }
  if (errno == EEXIST) {
    throw InputError("The file " + quoted(path) +
                     " holds an unfinished scan and is left alone; it is a TIFF, so rename it to "
                     "keep it or delete it, or choose another name.");
  }
  throw_errno(errno, "The file " + quoted(path) + " cannot be created");
}

void sync_directory(const std::filesystem::path& file) {
  const auto directory = file.has_parent_path() ? file.parent_path() : std::filesystem::path(".");
  const int fd = ::open(directory.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0) return;  // the file itself is safe; only its name might be lost with the power
  ::fsync(fd);
  ::close(fd);
}

// For file systems that know neither RENAME_NOREPLACE nor hard links: the name is taken by an empty
// file of our own first, so that only this file is replaced.
bool rename_over_placeholder(const std::filesystem::path& from, const std::filesystem::path& to) {
  const int fd = ::open(to.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (fd < 0) {
    if (errno == EEXIST) return false;
    throw_errno(errno, "The file " + quoted(to) + " cannot be created");
  }
  ::close(fd);
  if (::rename(from.c_str(), to.c_str()) == 0) return true;
  const int error = errno;
  ::unlink(to.c_str());
  throw_errno(error, "The file " + quoted(from) + " cannot be renamed to " + quoted(to));
}

}  // namespace

std::filesystem::path part_path_of(const std::filesystem::path& path) {
  std::string name(".");
  name.append(path.filename().string()).append(".part");
  return path.parent_path() / name;
}

bool rename_if_absent(const std::filesystem::path& from, const std::filesystem::path& to) {
  if (::renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE) == 0) return true;
  if (errno == EEXIST) return false;
  if (errno != EINVAL && errno != ENOSYS && errno != EOPNOTSUPP) {
    throw_errno(errno, "The file " + quoted(from) + " cannot be renamed to " + quoted(to));
  }
  if (::link(from.c_str(), to.c_str()) == 0) {
    ::unlink(from.c_str());
    return true;
  }
  if (errno == EEXIST) return false;
  return rename_over_placeholder(from, to);
}

PartFile::PartFile(std::filesystem::path final_path, Kind kind, Existing existing)
    : final_path_(std::move(final_path)), kind_(kind), existing_(existing) {
  if (!final_path_.has_filename() || final_path_.filename() == "." ||
      final_path_.filename() == "..") {
    throw InputError("'" + final_path_.string() + "' is a folder; give the name of a file.");
  }
  part_path_ = part_path_of(final_path_);
  if (existing_ == Existing::kRefuse && exists_at(final_path_)) throw taken(final_path_);
  fd_ = kind_ == Kind::kPrecious ? open_precious(part_path_) : open_scratch(part_path_);
}

PartFile::~PartFile() {
  if (!published_ && kind_ == Kind::kScratch) ::unlink(part_path_.c_str());
  ::close(fd_);
}

std::size_t PartFile::write_some_at(std::uint64_t offset, std::span<const std::byte> bytes,
                                    int& error) const {
  std::size_t written = 0;
  error = 0;
  while (written < bytes.size()) {
    const ssize_t n = ::pwrite(fd_, bytes.data() + written, bytes.size() - written,
                               static_cast<off_t>(offset + written));
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) {
      error = n < 0 ? errno : ENOSPC;
      break;
    }
    written += static_cast<std::size_t>(n);
  }
  return written;
}

void PartFile::throw_write_error(int error) const {
  const std::string file = quoted(final_path_);
  if (error == ENOSPC || error == EDQUOT) {
    throw_errno(error, "There is no room left on the disk for " + file +
                           "; make room or choose another folder");
  }
  if (error == EFBIG) {
    throw_errno(error, "The file " + file + " has reached the largest size allowed here");
  }
  throw_errno(error, "The file " + file + " cannot be written");
}

void PartFile::write_at(std::uint64_t offset, std::span<const std::byte> bytes) const {
  int error = 0;
  write_some_at(offset, bytes, error);
  if (error != 0) throw_write_error(error);
}

void PartFile::sync() const {
  if (::fdatasync(fd_) != 0) throw_write_error(errno);
}

void PartFile::publish() {
  if (::fsync(fd_) != 0) throw_write_error(errno);
  if (existing_ == Existing::kReplace) {
    if (::rename(part_path_.c_str(), final_path_.c_str()) != 0) {
      throw_errno(errno, "The file " + quoted(final_path_) + " cannot be replaced");
    }
  } else if (!rename_if_absent(part_path_, final_path_)) {
    throw taken(final_path_);
  }
  published_ = true;
  sync_directory(final_path_);
}

bool PartFile::publish_if_absent(const std::filesystem::path& path) {
  if (::fsync(fd_) != 0) throw_write_error(errno);
  if (!rename_if_absent(part_path_, path)) return false;
  published_ = true;
  sync_directory(path);
  return true;
}

void PartFile::discard() noexcept {
  if (!published_) ::unlink(part_path_.c_str());
  published_ = true;
}

}  // namespace reseau
