#include "capture/store/names.h"

#include <set>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include "core/base/error.h"
#include "tests/support/temp_dir.h"

namespace reseau {
namespace {

using test::names_in;
using test::TempDir;
using test::write_bytes;

TEST(Names, NumberFollowsTheHighestOfAllSiblings) {
  const TempDir dir;
  EXPECT_EQ(reserve_numbered(dir.path(), "box3").name(), "box3_01");
  write_bytes(dir / "box3_02.exr", "");
  EXPECT_EQ(reserve_numbered(dir.path(), "box3").name(), "box3_03");
  write_bytes(dir / "BOX3_07.TIF", "");
  EXPECT_EQ(reserve_numbered(dir.path(), "box3").name(), "box3_08");
  write_bytes(dir / ".box3_09.tif.part", "");
  EXPECT_EQ(reserve_numbered(dir.path(), "box3").name(), "box3_10");
  write_bytes(dir / "box3_11.partial.tif", "");
  EXPECT_EQ(reserve_numbered(dir.path(), "box3").name(), "box3_12");
  write_bytes(dir / "box3_99_preview.png", "");
  EXPECT_EQ(reserve_numbered(dir.path(), "box3").name(), "box3_100");
  // Not siblings: other stems, and words that begin with digits.
  write_bytes(dir / "box33_500.tif", "");
  write_bytes(dir / "box3_600abc.tif", "");
  write_bytes(dir / "box3.tif", "");
  EXPECT_EQ(reserve_numbered(dir.path(), "box3").name(), "box3_100");
}

TEST(Names, ReservationIsAFileThatGoesWithIt) {
  const TempDir dir;
  {
    const auto first = reserve_numbered(dir.path(), "Roll");
    EXPECT_EQ(names_in(dir.path()), std::vector<std::string>{".roll_01.reserved"});
    const auto second = reserve_numbered(dir.path(), "rOLL");
    EXPECT_EQ(second.name(), "rOLL_02");
    EXPECT_EQ(second.path(".tif"), dir / "rOLL_02.tif");
    EXPECT_THROW((void)reserve_numbered(dir.path(), "roll", 1), InputError);
    EXPECT_THROW((void)reserve_exact(dir.path(), "ROLL_02"), InputError);
    EXPECT_EQ(reserve_numbered(dir.path(), "roll", 5).number(), 5);
  }
  EXPECT_TRUE(names_in(dir.path()).empty());
}

TEST(Names, ExactNameIsTakenByAnyExtension) {
  const TempDir dir;
  write_bytes(dir / "scan.json", "");
  EXPECT_THROW((void)reserve_exact(dir.path(), "Scan"), InputError);
  EXPECT_EQ(reserve_exact(dir.path(), "scanner").name(), "scanner");
  write_bytes(dir / "party_01.tif", "");
  EXPECT_EQ(reserve_exact(dir.path(), "party").name(), "party");
  write_bytes(dir / "box_07.tif", "");
  EXPECT_THROW((void)reserve_numbered(dir.path(), "box", 7), InputError);
  // box_070 is another number.
  EXPECT_EQ(reserve_numbered(dir.path(), "box", 70).name(), "box_70");
}

TEST(Names, MovingKeepsTheReservation) {
  const TempDir dir;
  auto first = reserve_exact(dir.path(), "a");
  NameReservation second = std::move(first);
  first = reserve_exact(dir.path(), "b");
  EXPECT_EQ(names_in(dir.path()), (std::vector<std::string>{".a.reserved", ".b.reserved"}));
  second = reserve_exact(dir.path(), "c");
  EXPECT_EQ(second.name(), "c");
  EXPECT_EQ(names_in(dir.path()), (std::vector<std::string>{".b.reserved", ".c.reserved"}));
}

TEST(Names, RefusesPathsAndMakesFolders) {
  const TempDir dir;
  for (const std::string stem : {"", "../up", "a/b", ".hidden", "a b", "ü"}) {
    EXPECT_THROW((void)reserve_numbered(dir.path(), stem), InputError) << stem;
  }
  EXPECT_EQ(reserve_numbered(dir / "new/folder", "x").path(".tif"), dir / "new/folder/x_01.tif");
  write_bytes(dir / "file", "");
  EXPECT_THROW((void)reserve_numbered(dir / "file", "x"), std::system_error);
}

TEST(Names, SafeFileName) {
  EXPECT_EQ(safe_file_name("Box 3/7"), "Box_3_7");
  EXPECT_EQ(safe_file_name("..x"), "x");
  EXPECT_EQ(safe_file_name(""), "_");
  EXPECT_EQ(safe_file_name("..."), "_");
}

// Processes and threads that ask at once get different numbers, without a hole.
TEST(Names, RaceGivesEveryoneANameOfTheirOwn) {
  const TempDir dir;
  constexpr int kProcesses = 4, kThreads = 3, kEach = 5;
  std::vector<pid_t> children;
  for (int p = 0; p < kProcesses; ++p) {
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      std::vector<std::thread> threads;
      for (int t = 0; t < kThreads; ++t) {
        threads.emplace_back([&, t] {
          for (int i = 0; i < kEach; ++i) {
            const auto name = reserve_numbered(dir.path(), t % 2 == 0 ? "roll" : "ROLL");
            // O_EXCL would do as well; append shows a double use.
            std::ofstream(name.path(".tif"), std::ios::app) << "x";
          }
        });
      }
      for (auto& thread : threads) thread.join();
      ::_exit(0);
    }
    children.push_back(child);
  }
  for (const pid_t child : children) {
    int status = -1;
    ::waitpid(child, &status, 0);
    EXPECT_EQ(status, 0);
  }
  std::set<int> numbers;
  for (const auto& name : names_in(dir.path())) {
    EXPECT_EQ(test::file_bytes(dir / name), "x") << name;
    numbers.insert(std::stoi(name.substr(5)));
  }
  EXPECT_EQ(numbers.size(), static_cast<std::size_t>(kProcesses * kThreads * kEach));
}

}  // namespace
}  // namespace reseau
