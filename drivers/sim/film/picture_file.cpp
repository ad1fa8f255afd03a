#include "drivers/sim/film/picture_file.h"

#include <cstddef>
#include <filesystem>
#include <system_error>
#include <vector>

#include <dlfcn.h>

#include "core/base/error.h"
#include "drivers/sim/film/picture_module.h"

namespace reseau::sim {
namespace {

struct Module {
  decltype(&reseau_read_picture) read = nullptr;
  decltype(&reseau_free_picture) free = nullptr;
};

// As installed and as built: bin/reseau finds lib/reseau.
Module open_module() {
  constexpr const char* kName = "lib/reseau/reseau_pictures.so";
  constexpr int kLevels = 2;
  std::error_code error;
  std::filesystem::path at = std::filesystem::read_symlink("/proc/self/exe", error).parent_path();
  for (int level = 0; level < kLevels && !at.empty(); ++level, at = at.parent_path()) {
    const std::filesystem::path candidate = at / kName;
    if (!std::filesystem::exists(candidate, error)) continue;
    void* const handle = dlopen(candidate.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (handle == nullptr) continue;
    Module module;
    module.read = reinterpret_cast<decltype(module.read)>(dlsym(handle, "reseau_read_picture"));
    module.free = reinterpret_cast<decltype(module.free)>(dlsym(handle, "reseau_free_picture"));
    if (module.read != nullptr && module.free != nullptr) return module;
  }
  return {};
}

}  // namespace

SceneRaster read_scene_picture(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) {
    throw InputError("There is no picture \"" + path +
                     "\" for the simulated film; give the name of an image file.");
  }
  static const Module module = open_module();
  if (module.read == nullptr) {
    throw InputError(
        "Pictures as scenes need OpenImageIO, and this program came without its module "
        "lib/reseau/reseau_pictures.so; use one of the built-in scenes.");
  }
  ReseauPicture picture{};
  module.read(path.c_str(), &picture);
  const std::string reason = picture.error;
  SceneRaster raster{picture.width_px, picture.height_px, {}};
  if (reason.empty()) {
    const std::size_t n = 3 * static_cast<std::size_t>(picture.width_px) *
                          static_cast<std::size_t>(picture.height_px);
    raster.rgb.assign(picture.rgb, picture.rgb + n);
  }
  module.free(&picture);
  if (!reason.empty()) {
    throw InputError("The picture \"" + path + "\" cannot be read: " + reason + ".");
  }
  return raster;
}

}  // namespace reseau::sim
