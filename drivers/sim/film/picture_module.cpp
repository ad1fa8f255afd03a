#include "drivers/sim/film/picture_module.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>
#include <vector>

#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>
#include <OpenImageIO/imageio.h>

namespace {

constexpr double kMostPixels = 4e8;

void say(ReseauPicture& out, const std::string& text) {
  std::snprintf(out.error, sizeof out.error, "%s", text.c_str());
}

float linear_of_srgb(float v) {
  return v <= 0.04045F ? v / 12.92F : std::pow((v + 0.055F) / 1.055F, 2.4F);
}

float linear_of_rec709(float v) {
  return v < 0.081F ? v / 4.5F : std::pow((v + 0.099F) / 1.099F, 1 / 0.45F);
}

bool is_linear(const std::string& space) {
  return space == "Linear" || space == "scene_linear" || space.rfind("lin", 0) == 0;
}

// As the file says; without a word integers are sRGB and floats are linear.
void to_linear(std::vector<float>& rgb, const std::string& space, bool integer) {
  if (space.rfind("Gamma", 0) == 0) {
    const auto gamma = static_cast<float>(std::atof(space.c_str() + 5));
    for (float& v : rgb) v = std::pow(std::max(v, 0.0F), gamma > 0 ? gamma : 1);
  } else if (space == "Rec709") {
    for (float& v : rgb) v = linear_of_rec709(v);
  } else if (space == "sRGB" || (integer && !is_linear(space))) {
    for (float& v : rgb) v = linear_of_srgb(v);
  }
  for (float& v : rgb) v = v < 0 ? 0.0F : v;  // NaN stays, for whoever uses it to refuse
}

bool read(const char* path, ReseauPicture& out) {
  OIIO::ImageSpec config;
  config.attribute("oiio:UnassociatedAlpha", 1);
  const auto input = OIIO::ImageInput::open(path, &config);
  if (!input) {
    say(out, OIIO::geterror());
    return false;
  }
  const OIIO::ImageSpec spec = input->spec();
  if (spec.width < 1 || spec.height < 1 || spec.nchannels < 1 || spec.depth > 1 ||
      static_cast<double>(spec.width) * spec.height > kMostPixels) {
    say(out, "its size is not that of a picture");
    return false;
  }
  const int n = spec.nchannels >= 3 ? 3 : 1;
  OIIO::ImageBuf picture(OIIO::ImageSpec(spec.width, spec.height, n, OIIO::TypeDesc::FLOAT));
  if (!input->read_image(0, 0, 0, n, OIIO::TypeDesc::FLOAT, picture.localpixels())) {
    say(out, input->geterror());
    return false;
  }
  picture.specmod().attribute("Orientation", spec.get_int_attribute("Orientation", 1));
  const OIIO::ImageBuf upright = OIIO::ImageBufAlgo::reorient(picture);
  out.width_px = upright.spec().width;
  out.height_px = upright.spec().height;
  const auto pixels =
      static_cast<std::size_t>(out.width_px) * static_cast<std::size_t>(out.height_px);
  std::vector<float> samples(pixels * static_cast<std::size_t>(n));
  if (!upright.get_pixels(upright.roi(), OIIO::TypeDesc::FLOAT, samples.data())) {
    say(out, upright.geterror());
    return false;
  }
  to_linear(samples, spec.get_string_attribute("oiio:ColorSpace"),
            !spec.format.is_floating_point());
  out.rgb = static_cast<float*>(std::malloc(3 * pixels * sizeof(float)));
  if (out.rgb == nullptr) {
    say(out, "there is not enough memory for it");
    return false;
  }
  for (std::size_t i = 0; i < pixels; ++i) {
    for (std::size_t c = 0; c < 3; ++c) out.rgb[3 * i + c] = samples[n == 3 ? 3 * i + c : i];
  }
  return true;
}

}  // namespace

extern "C" void reseau_read_picture(const char* path, ReseauPicture* out) {
  *out = {};
  try {
    if (!read(path, *out) && out->error[0] == 0) say(*out, "it is no picture");
  } catch (const std::exception& e) {
    say(*out, e.what());
  }
}

extern "C" void reseau_free_picture(ReseauPicture* picture) {
  std::free(picture->rgb);
  picture->rgb = nullptr;
}
