#include <system_error>

#include <gtest/gtest.h>

#include "capture/store/part_file.h"
#include "capture/store/sha256.h"
#include "core/base/error.h"
#include "tests/support/temp_dir.h"

namespace reseau {
namespace {

using test::file_bytes;
using test::names_in;
using test::TempDir;
using test::write_bytes;

// Examples of FIPS 180-2 and of its million-letter message.
TEST(Sha256, KnownAnswers) {
  const TempDir dir;
  const auto hash = [&](const std::string& text) {
    write_bytes(dir / "x", text);
    return sha256_of_file(dir / "x");
  };
  EXPECT_EQ(hash(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(hash("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(hash(std::string(1'000'000, 'a')),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
  EXPECT_THROW((void)sha256_of_file(dir / "none"), std::system_error);
  EXPECT_THROW((void)sha256_of_file(dir.path()), std::system_error);
}

TEST(PartFile, PreciousPartSurvivesItsOwnerScratchDoesNot) {
  const TempDir dir;
  {
    const PartFile precious(dir / "a", PartFile::Kind::kPrecious, Existing::kRefuse);
    const PartFile scratch(dir / "b", PartFile::Kind::kScratch, Existing::kRefuse);
    EXPECT_EQ(names_in(dir.path()), (std::vector<std::string>{".a.part", ".b.part"}));
  }
  EXPECT_EQ(names_in(dir.path()), std::vector<std::string>{".a.part"});
}

TEST(PartFile, PublishNeverReplacesUnasked) {
  const TempDir dir;
  PartFile file(dir / "a", PartFile::Kind::kScratch, Existing::kRefuse);
  file.write_at(0, std::as_bytes(std::span("new", 3)));
  write_bytes(dir / "a", "old");
  EXPECT_THROW(file.publish(), InputError);
  EXPECT_EQ(file_bytes(dir / "a"), "old");
  EXPECT_FALSE(file.publish_if_absent(dir / "a"));
  EXPECT_TRUE(file.publish_if_absent(dir / "b"));
  EXPECT_EQ(file_bytes(dir / "b"), "new");
  EXPECT_EQ(names_in(dir.path()), (std::vector<std::string>{"a", "b"}));

  PartFile asked(dir / "a", PartFile::Kind::kScratch, Existing::kReplace);
  asked.write_at(0, std::as_bytes(std::span("newer", 5)));
  asked.publish();
  EXPECT_EQ(file_bytes(dir / "a"), "newer");
}

TEST(PartFile, RefusesFoldersAndLinksInTheWay) {
  const TempDir dir;
  EXPECT_THROW(PartFile(dir.path() / "", PartFile::Kind::kScratch, Existing::kReplace), InputError);
  write_bytes(dir / "target", "mine");
  std::filesystem::create_symlink(dir / "target", dir / ".x.part");
  EXPECT_THROW(PartFile(dir / "x", PartFile::Kind::kScratch, Existing::kReplace),
               std::system_error);
  EXPECT_EQ(file_bytes(dir / "target"), "mine");
}

}  // namespace
}  // namespace reseau
