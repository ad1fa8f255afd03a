#include "capture/compare/pairing.h"

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/color/element_color.h"

namespace reseau::compare {
namespace {

// XYZ of the element intensities that a result was made from: by the matrix it holds, or by the
// primaries it names.
std::optional<Matrix3> xyz_from_process_of(const PictureHeader& header) {
  const std::optional<Matrix3> xyz = declared_xyz(header);
  if (xyz && header.output_from_process) return multiply(*xyz, *header.output_from_process);
  if (header.primaries.empty()) return std::nullopt;
  try {
    const Balance balance =
        header.balance.empty() ? Balance::kNeutral : parse_balance(header.balance);
    return make_color_model(header.primaries, balance, OutputSpace::kProcess).xyz_from_process;
  } catch (const InputError&) {
    return std::nullopt;  // made by another version; its chromaticities still count
  }
}

void require_layers(const PictureHeader& header, Layer layer, const char* side) {
  if (layer == Layer::kScene && header.has_process && !header.has_scene) {
    throw InputError(
        fmt::format("{} '{}' is a truth without the layer 'scene'.", side, header.path.string()));
  }
}

// `truth` beside `result`.
void pair_truth(const PictureHeader& truth, const PictureHeader& result, Layer layer,
                PictureChoice& choice, Pairing& pairing) {
  const bool both = result.has_process;
  const std::optional<Matrix3> model = xyz_from_process_of(result);
  if (layer == Layer::kScene ||
      (layer == Layer::kAuto && !both && !model && result.space != "process" && truth.has_scene)) {
    choice.scene_layer = true;
    pairing.sentence = "The truth is what the camera saw (layer 'scene', linear sRGB).";
    return;
  }
  if (both) {
    pairing.process_rgb = true;
    pairing.sentence = "Both are truths: process RGB, each seen through the primaries it declares.";
    return;
  }
  if (model) {
    choice.xyz_from_samples = *model;
    pairing.process_rgb = result.space == "process";
    pairing.sentence = fmt::format(
        "The truth is process RGB, seen through the primaries of the result ({}, balance {}){}.",
        result.primaries, result.balance.empty() ? "neutral" : result.balance,
        pairing.process_rgb ? "; so is the result, which is process RGB itself" : "");
    return;
  }
  pairing.process_rgb = result.space == "process";
  pairing.sentence =
      "The truth is process RGB, seen through the primaries it declares; the result names none.";
}

std::string describe_two_results(const PictureHeader& a, const PictureHeader& b) {
  if (a.space == "process" && b.space == "process") {
    return a.primaries == b.primaries && a.balance == b.balance
               ? "Both are process RGB, seen through the same primaries."
               : "Both are process RGB, each seen through its own primaries; the difference is "
                 "that "
                 "of intensities and of primaries.";
  }
  if (a.space == "process" || b.space == "process") {
    return fmt::format("{} is process RGB, seen through the primaries it declares.",
                       a.space == "process" ? "A" : "B");
  }
  return "Each picture has the colours that it declares.";
}

}  // namespace

Pairing pair_pictures(const PictureHeader& a, const PictureHeader& b,
                      const CompareOptions& options) {
  require_layers(a, options.layer, "A");
  require_layers(b, options.layer, "B");
  if (options.layer == Layer::kScene && !a.has_scene && !b.has_scene) {
    throw InputError("Neither picture is a truth with the layer 'scene'; leave --layer out.");
  }
  Pairing pairing;
  pairing.a.untagged_is_linear = pairing.b.untagged_is_linear = options.untagged_is_linear;
  if (a.has_process && b.has_process) {
    const bool scene = options.layer == Layer::kScene;
    pairing.a.scene_layer = pairing.b.scene_layer = scene;
    if (!scene) pair_truth(a, b, Layer::kProcess, pairing.a, pairing);
    if (scene) pairing.sentence = "Both are truths: what the camera saw (linear sRGB).";
    return pairing;
  }
  if (a.has_process) {
    pair_truth(a, b, options.layer, pairing.a, pairing);
  } else if (b.has_process) {
    pair_truth(b, a, options.layer, pairing.b, pairing);
  } else {
    pairing.process_rgb = a.space == "process" && b.space == "process";
    pairing.sentence = describe_two_results(a, b);
  }
  return pairing;
}

}  // namespace reseau::compare
