#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>

namespace reseau {

// What to do when the final name is taken.
enum class Existing {
  kRefuse,   // leave it alone; InputError
  kReplace,  // only when a person asked for it
};

// A file under construction: written as `.NAME.part` beside its final place, where no watcher of
// the folder takes it for a picture, and given its name in one step when it is whole. Thread-bound.
//
// The part is locked while it is open. kScratch takes over a part that nobody holds (left behind by
// a killed run); kPrecious never touches one: it may hold lines of an unfinished scan.
class PartFile {
 public:
  enum class Kind { kScratch, kPrecious };

  // Throws InputError when the final name is taken and `existing` is kRefuse, or when the part is
  // held by another program or precious; std::system_error when the folder cannot be written.
  PartFile(std::filesystem::path final_path, Kind kind, Existing existing);
  // Removes a part of kind kScratch that was not published; closes.
  ~PartFile();
  PartFile(const PartFile&) = delete;
  PartFile& operator=(const PartFile&) = delete;

  [[nodiscard]] int fd() const { return fd_; }
  [[nodiscard]] const std::filesystem::path& final_path() const { return final_path_; }
  [[nodiscard]] const std::filesystem::path& part_path() const { return part_path_; }

  // Writes all bytes at `offset`; throws std::system_error with a sentence (disk full, limit, I/O).
  void write_at(std::uint64_t offset, std::span<const std::byte> bytes) const;
  // The same without throwing: returns how many bytes were written and sets `error` to the errno
  // that kept the rest from it, 0 when there is no rest.
  std::size_t write_some_at(std::uint64_t offset, std::span<const std::byte> bytes,
                            int& error) const;
  // The std::system_error of write_at for an errno.
  [[noreturn]] void throw_write_error(int error) const;
  // Waits until what was written is on the medium. Throws std::system_error.
  void sync() const;
  // fsync, then the final name. Throws std::system_error, or InputError when the name was taken
  // meanwhile and kRefuse holds; the part then stays.
  void publish();
  // fsync, then another name of the same folder. Returns false when that is taken.
  [[nodiscard]] bool publish_if_absent(const std::filesystem::path& path);
  // Removes the part, precious or not.
  void discard() noexcept;

 private:
  std::filesystem::path final_path_, part_path_;
  Kind kind_;
  Existing existing_;
  int fd_ = -1;
  bool published_ = false;
};

// `.NAME.part` in the folder of `path`.
[[nodiscard]] std::filesystem::path part_path_of(const std::filesystem::path& path);

// Renames without ever replacing: renameat2(RENAME_NOREPLACE), or link and unlink where the file
// system lacks it. Returns false when `to` exists; throws std::system_error for other failures.
[[nodiscard]] bool rename_if_absent(const std::filesystem::path& from,
                                    const std::filesystem::path& to);

}  // namespace reseau
