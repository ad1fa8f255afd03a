// Names of output files: reserved on disk before film moves, never reused, never overwritten.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace reseau {

// A base name that nobody else will get: `{stem}_{NN}` in a folder, held by the hidden, exclusively
// created file `.{name}.reserved` (lower case, so that it also excludes on file systems that keep
// case). Released by destruction; after a crash the file stays and so does the number. Move-only.
class NameReservation {
 public:
  [[nodiscard]] const std::filesystem::path& directory() const { return directory_; }
  [[nodiscard]] const std::string& name() const { return name_; }  // "box3_07"
  [[nodiscard]] int number() const { return number_; }             // 7; 0 for an exact name
  // directory / (name + suffix), e.g. path(".tif").
  [[nodiscard]] std::filesystem::path path(std::string_view suffix) const;

  ~NameReservation();
  NameReservation(const NameReservation&) = delete;
  NameReservation& operator=(const NameReservation&) = delete;
  NameReservation(NameReservation&& other) noexcept;
  NameReservation& operator=(NameReservation&& other) noexcept;

 private:
  friend NameReservation reserve_numbered(const std::filesystem::path&, const std::string&,
                                          std::optional<int>);
  friend NameReservation reserve_exact(const std::filesystem::path&, const std::string&);
  NameReservation() = default;

  std::filesystem::path directory_, lock_path_;
  std::string name_;
  int number_ = 0;
};

// The number after the highest that any file of the folder uses with this stem, whatever its
// extension, case or leading dot (tif, exr, json, png, part, reserved …); at least two digits. With
// `number`: that one. Makes the folder when it is missing.
// Throws InputError for a stem that is no plain file name or when `number` is taken,
// std::system_error when the folder cannot be written.
[[nodiscard]] NameReservation reserve_numbered(const std::filesystem::path& directory,
                                               const std::string& stem,
                                               std::optional<int> number = std::nullopt);

// Exactly this base name. Throws InputError when any file of the folder has it, with any extension.
[[nodiscard]] NameReservation reserve_exact(const std::filesystem::path& directory,
                                            const std::string& name);

// ASCII letters, digits, - _ . only; other characters become '_', leading dots vanish. Never empty.
[[nodiscard]] std::string safe_file_name(std::string_view text);

}  // namespace reseau
