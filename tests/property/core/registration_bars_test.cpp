// Registration against the truth of simulated films: cases of `reseau bench registration` that once
// were missed, or that guard what is claimed.
#include <string>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "capture/bench/registration_score.h"

namespace reseau {
namespace {

RegistrationScore score(const std::string& film) {
  RegistrationCase test;
  test.film = film;
  const RegistrationScore result = score_registration(test, 0);
  EXPECT_TRUE(result.found) << film << ": " << result.reason;
  fmt::print("{}: {:.4f} px rms, claimed {:.4f}, z {:.2f}\n", film, result.rms_px, result.sd_px,
             result.z_sd);
  return result;
}

// Borders of patches along the red lines once passed for an error of the stage, and the picture's
// own slopes, which differ by colour, for a bend of the film.
TEST(RegistrationBars, FlatFilmThatLiesAsTheScanDoesComesOutFlat) {
  for (const std::string film :
       {"width_px=1000&height_px=1000&scene=chart&angle=-90&blur_px=0.6&ir_blur_px=0.7&noise=0.006",
        "width_px=1000&height_px=1000&scene=chart&angle=90&blur_px=0.6&ir_blur_px=0.7&noise=0.006",
        "width_px=1000&height_px=1000&scene=natural&angle=0&blur_px=1.5&ir_blur_px=1.5&noise=0."
        "006"}) {
    const RegistrationScore result = score(film);
    EXPECT_LT(result.rms_px, 0.004) << film;
    EXPECT_TRUE(result.affine) << film;
  }
}

// Its slopes change by a quarter over 22 px: no large tile shows a lattice, no plane predicts the
// next block.
TEST(RegistrationBars, FilmThatBendsWithinATileIsFollowed) {
  const RegistrationScore result =
      score("width_px=400&height_px=400&scene=natural&angle=23&warp_px=4&warp_length_px=90");
  EXPECT_LT(result.lit_rms_px, 0.15);
}

// The same behind saturated patches, where a part once slipped by two periods and claimed to be
// right.
TEST(RegistrationBars, NoPartOfABentFilmSlipsByAPeriod) {
  const RegistrationScore result =
      score("width_px=600&height_px=600&scene=chart&angle=23&warp_px=4&warp_length_px=90");
  EXPECT_LT(result.lit_rms_px, 0.06);
  EXPECT_LT(result.worst_z, 12);
}

}  // namespace
}  // namespace reseau
