#include "capture/compare/color_decode.h"

#include <array>
#include <cmath>

#include <lcms2.h>

#include "core/base/check.h"
#include "core/color/adaptation.h"
#include "core/color/rgb_space.h"

namespace reseau::compare {
namespace {

using MatrixF = std::array<double, 9>;

void apply(const MatrixF& m, double r, double g, double b, float* xyz) {
  for (std::size_t k = 0; k < 3; ++k) {
    xyz[k] = static_cast<float>(m[3 * k] * r + m[3 * k + 1] * g + m[3 * k + 2] * b);
  }
}

class Linear final : public ColorDecode {
 public:
  explicit Linear(const Matrix3& matrix) : matrix_(matrix) {}
  void to_xyz(std::span<const float> in, std::span<float> xyz) const override {
    CHECK(in.size() == xyz.size() && in.size() % 3 == 0);
    for (std::size_t i = 0; i < in.size(); i += 3) {
      apply(matrix_, double{in[i]}, double{in[i + 1]}, double{in[i + 2]}, &xyz[i]);
    }
  }

 private:
  MatrixF matrix_;
};

// A curve on 0..1 as a table of all 16-bit values: exact for integers, interpolated between them
// for floats; beyond the ends the function itself.
class Curve final : public ColorDecode {
 public:
  template <typename F>
  Curve(F linear_from_sample, const Matrix3& matrix)
      : function_(linear_from_sample), matrix_(matrix), table_(65537) {
    for (std::size_t i = 0; i < table_.size(); ++i) {
      table_[i] = linear_from_sample(static_cast<double>(i) / 65535.0);
    }
  }
  void to_xyz(std::span<const float> in, std::span<float> xyz) const override {
    CHECK(in.size() == xyz.size() && in.size() % 3 == 0);
    for (std::size_t i = 0; i < in.size(); i += 3) {
      apply(matrix_, linear(in[i]), linear(in[i + 1]), linear(in[i + 2]), &xyz[i]);
    }
  }

 private:
  [[nodiscard]] double linear(float sample) const {
    const double at = double{sample} * 65535.0;
    if (!(at >= 0 && at <= 65535.0)) return function_(double{sample});
    const auto low = static_cast<std::size_t>(at);
    const double share = at - static_cast<double>(low);
    return table_[low] + share * (table_[low + 1] - table_[low]);
  }
  double (*function_)(double) = nullptr;
  MatrixF matrix_;
  std::vector<double> table_;
};

class Gamma final : public ColorDecode {
 public:
  Gamma(double gamma, const Matrix3& matrix) : gamma_(gamma), matrix_(matrix) {}
  void to_xyz(std::span<const float> in, std::span<float> xyz) const override {
    CHECK(in.size() == xyz.size() && in.size() % 3 == 0);
    const auto linear = [this](float v) {
      return std::copysign(std::pow(std::abs(double{v}), gamma_), double{v});
    };
    for (std::size_t i = 0; i < in.size(); i += 3) {
      apply(matrix_, linear(in[i]), linear(in[i + 1]), linear(in[i + 2]), &xyz[i]);
    }
  }

 private:
  double gamma_;
  MatrixF matrix_;
};

class Icc final : public ColorDecode {
 public:
  explicit Icc(cmsHTRANSFORM transform) : transform_(transform) {
    // The connection space of ICC.1 is relative to this D50.
    const Xyz d50{0.9642, 1.0, 0.8249};
    adapt_ = bradford_target_from_source(d50, white_of(Illuminant::kD65));
  }
  ~Icc() override { cmsDeleteTransform(transform_); }
  Icc(const Icc&) = delete;
  Icc& operator=(const Icc&) = delete;
  void to_xyz(std::span<const float> in, std::span<float> xyz) const override {
    CHECK(in.size() == xyz.size() && in.size() % 3 == 0);
    constexpr std::size_t kChunk = 256;
    std::array<double, 3 * kChunk> from{}, to{};
    for (std::size_t i = 0; i < in.size(); i += from.size()) {
      const std::size_t n = std::min(from.size(), in.size() - i);
      for (std::size_t j = 0; j < n; ++j) from[j] = double{in[i + j]};
      cmsDoTransform(transform_, from.data(), to.data(), static_cast<cmsUInt32Number>(n / 3));
      for (std::size_t j = 0; j < n; j += 3) {
        // lcms2 turns NaN into a colour.
        if (std::isfinite(from[j] + from[j + 1] + from[j + 2])) {
          apply(adapt_, to[j], to[j + 1], to[j + 2], &xyz[i + j]);
        } else {
          for (std::size_t k = 0; k < 3; ++k) xyz[i + j + k] = NAN;
        }
      }
    }
  }

 private:
  cmsHTRANSFORM transform_;
  MatrixF adapt_{};
};

}  // namespace

std::unique_ptr<ColorDecode> linear_decode(const Matrix3& xyz_from_samples) {
  return std::make_unique<Linear>(xyz_from_samples);
}

std::unique_ptr<ColorDecode> srgb_curve_decode(const Matrix3& xyz_from_linear) {
  return std::make_unique<Curve>(
      +[](double v) { return srgb_decode(v); }, xyz_from_linear);
}

std::unique_ptr<ColorDecode> gamma_decode(double gamma, const Matrix3& xyz_from_linear) {
  CHECK(gamma > 0);
  return std::make_unique<Gamma>(gamma, xyz_from_linear);
}

std::unique_ptr<ColorDecode> icc_decode(std::span<const std::byte> icc, std::string& why) {
  cmsHPROFILE profile = cmsOpenProfileFromMem(icc.data(), static_cast<cmsUInt32Number>(icc.size()));
  if (profile == nullptr) {
    why = "Its embedded colour profile is damaged and was not used.";
    return nullptr;
  }
  if (cmsGetColorSpace(profile) != cmsSigRgbData) {
    cmsCloseProfile(profile);
    why = "Its embedded colour profile is not one of RGB and was not used.";
    return nullptr;
  }
  cmsHPROFILE xyz = cmsCreateXYZProfile();
  cmsHTRANSFORM transform =
      cmsCreateTransform(profile, TYPE_RGB_DBL, xyz, TYPE_XYZ_DBL, INTENT_RELATIVE_COLORIMETRIC,
                         cmsFLAGS_NOCACHE | cmsFLAGS_NOOPTIMIZE);
  cmsCloseProfile(xyz);
  cmsCloseProfile(profile);
  if (transform == nullptr) {
    why = "Its embedded colour profile leads to no colours and was not used.";
    return nullptr;
  }
  return std::make_unique<Icc>(transform);
}

Matrix3 xyz_from_linear_srgb() { return inverse(srgb_from_xyz_d65()); }

}  // namespace reseau::compare
