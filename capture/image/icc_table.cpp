#include "capture/image/icc_table.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <utility>
#include <vector>

#include "capture/image/lcms_handles.h"
#include "core/base/check.h"
#include "core/base/parallel.h"
#include "core/color/adaptation.h"
#include "core/color/rgb_space.h"

namespace reseau {
namespace {

constexpr int kLinesAtOnce = 16;

bool has_table(const LcmsProfile& profile) {
  constexpr std::array<cmsUInt32Number, 3> kIntents = {
      INTENT_PERCEPTUAL, INTENT_RELATIVE_COLORIMETRIC, INTENT_SATURATION};
  for (const cmsUInt32Number intent : kIntents) {
    if (cmsIsCLUT(profile.get(), intent, LCMS_USED_AS_INPUT)) return true;
  }
  return false;
}

// White of the profile connection space to (1, 1, 1).
std::array<float, 9> prophoto_from_pcs() {
  const Chromaticities space = rgb_space_chromaticities("prophoto");
  const Matrix3 xyz = xyz_from_rgb(space);
  const Xyz white = multiply(xyz, Vector3{1, 1, 1});
  const cmsCIEXYZ* pcs = cmsD50_XYZ();
  const Matrix3 m =
      multiply(inverse(xyz), bradford_target_from_source({pcs->X, pcs->Y, pcs->Z}, white));
  std::array<float, 9> out{};
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = static_cast<float>(m[i]);
  return out;
}

}  // namespace

struct IccTable::State {
  LcmsTransform transform;  // 16-bit RGB to XYZ as float, relative to the white of the profile
  std::array<float, 9> rgb_from_xyz = prophoto_from_pcs();
};

IccTable::IccTable(std::unique_ptr<State> state) : state_(std::move(state)) {}
IccTable::~IccTable() = default;

std::unique_ptr<const IccTable> IccTable::open(std::span<const std::byte> icc) {
  const LcmsProfile profile(
      cmsOpenProfileFromMem(icc.data(), static_cast<cmsUInt32Number>(icc.size())));
  if (profile == nullptr || cmsGetColorSpace(profile.get()) != cmsSigRgbData ||
      !has_table(profile)) {
    return nullptr;
  }
  const LcmsProfile xyz(cmsCreateXYZProfile());
  auto state = std::make_unique<State>();
  // Without a cache a transform may be shared by threads; without optimisation it stays exact.
  state->transform.reset(cmsCreateTransform(profile.get(), TYPE_RGB_16, xyz.get(), TYPE_XYZ_FLT,
                                            INTENT_RELATIVE_COLORIMETRIC,
                                            cmsFLAGS_NOCACHE | cmsFLAGS_NOOPTIMIZE));
  if (state->transform == nullptr) return nullptr;
  return std::unique_ptr<const IccTable>(new IccTable(std::move(state)));
}

std::uint64_t IccTable::to_linear_light(const LineFormat& format,
                                        std::span<std::uint16_t> samples) const {
  const auto width = static_cast<std::size_t>(format.width_px);
  const std::size_t line_samples = format.samples_per_line();
  CHECK(line_samples > 0 && samples.size() % line_samples == 0);
  const std::array planes = {format.plane_of(Channel::kRed), format.plane_of(Channel::kGreen),
                             format.plane_of(Channel::kBlue)};
  for (const int plane : planes) CHECK(plane >= 0);
  const auto n_lines = static_cast<int>(samples.size() / line_samples);
  const std::array<float, 9>& m = state_->rgb_from_xyz;
  std::atomic<std::uint64_t> n_outside{0};
  parallel_for((n_lines + kLinesAtOnce - 1) / kLinesAtOnce, [&](int band) {
    std::vector<std::uint16_t> rgb(3 * width);
    std::vector<float> xyz(3 * width);
    std::uint64_t outside = 0;
    const int end = std::min(n_lines, (band + 1) * kLinesAtOnce);
    for (int y = band * kLinesAtOnce; y < end; ++y) {
      std::uint16_t* line = samples.data() + static_cast<std::size_t>(y) * line_samples;
      for (std::size_t c = 0; c < 3; ++c) {
        const std::uint16_t* from = line + static_cast<std::size_t>(planes[c]) * width;
        for (std::size_t x = 0; x < width; ++x) rgb[3 * x + c] = from[x];
      }
      cmsDoTransform(state_->transform.get(), rgb.data(), xyz.data(),
                     static_cast<cmsUInt32Number>(width));
      for (std::size_t c = 0; c < 3; ++c) {
        std::uint16_t* to = line + static_cast<std::size_t>(planes[c]) * width;
        for (std::size_t x = 0; x < width; ++x) {
          const float light =
              m[3 * c] * xyz[3 * x] + m[3 * c + 1] * xyz[3 * x + 1] + m[3 * c + 2] * xyz[3 * x + 2];
          // What rounding of the table does at the ends is not worth a word.
          if (!(light >= -1e-4F && light <= 1.0001F)) ++outside;
          const float root = light > 0 ? std::sqrt(std::min(light, 1.0F)) : 0;  // NaN as well
          to[x] = static_cast<std::uint16_t>(std::lround(root * 65535));
        }
      }
    }
    n_outside += outside;
  });
  return n_outside;
}

}  // namespace reseau
