// Whatever comes in, the program answers within its own stated uncertainty or says that it cannot.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "capture/bench/stress_bench.h"

namespace reseau {
namespace {

TEST(Stress, EveryCaseIsAnsweredOrRefusedInASentence) {
  constexpr unsigned kSeed = 1;
  int n_answered = 0;
  for (const StressCase& test : stress_cases(4, kSeed)) {
    const StressResult result = run_stress_case(test);
    EXPECT_NE(result.outcome, StressOutcome::kFailed)
        << test.group << ", " << test.name << " (" << test.film << "): " << result.words
        << " Off by " << result.off_px << " px, claimed " << result.claimed_px << " px, largest "
        << result.largest_sample;
    if (result.outcome == StressOutcome::kRefused) {
      EXPECT_TRUE(result.words.ends_with('.')) << test.name << ": " << result.words;
    }
    n_answered += result.outcome == StressOutcome::kAnswered ? 1 : 0;
  }
  EXPECT_GT(n_answered, 20);
}

}  // namespace
}  // namespace reseau
