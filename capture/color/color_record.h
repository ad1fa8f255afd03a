// How a picture's colours were made, as receipts and EXR attributes keep it.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "capture/image/exr_file.h"
#include "core/color/element_color.h"

namespace reseau {

// Sets chromaticities, adopted neutral, white luminance and the attributes "reseau.*", among them
// "reseau.outputFromProcess", the nine numbers of the matrix, row by row, exactly.
void declare_color(const ColorRecipe& recipe, ExrOptions& options);

// The matrix that a picture of ours says it was made with. InputError when the file does not say or
// what it says cannot be inverted.
[[nodiscard]] Matrix3 output_from_process_of(const ExrReader& reader, const std::string& name);

// {"space", "primaries", "source", "balance", "areas", "light", ...} for receipts and --json.
[[nodiscard]] nlohmann::ordered_json color_to_json(const ColorRecipe& recipe);

// Linear sRGB from the output space of a recipe, for looking; the white balance is part of the
// picture already.
[[nodiscard]] Matrix3 srgb_from_output(const ColorRecipe& recipe);

[[nodiscard]] std::string balance_word(Balance balance);
[[nodiscard]] nlohmann::ordered_json matrix_json(const Matrix3& matrix);

}  // namespace reseau
