// Owners of what lcms2 hands out, and the bytes of a profile without the time of its making.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include <lcms2.h>

namespace reseau {

struct CloseLcmsProfile {
  void operator()(void* profile) const { cmsCloseProfile(profile); }
};
using LcmsProfile = std::unique_ptr<void, CloseLcmsProfile>;

struct FreeLcmsCurve {
  void operator()(cmsToneCurve* curve) const { cmsFreeToneCurve(curve); }
};
using LcmsCurve = std::unique_ptr<cmsToneCurve, FreeLcmsCurve>;

struct DeleteLcmsTransform {
  void operator()(void* transform) const { cmsDeleteTransform(transform); }
};
using LcmsTransform = std::unique_ptr<void, DeleteLcmsTransform>;

// The profile as a file, its date a constant, its ID computed after that.
[[nodiscard]] std::vector<std::byte> reproducible_icc(const LcmsProfile& profile);

// Sets a text in English; ASCII.
void write_icc_text(const LcmsProfile& profile, cmsTagSignature tag, const std::string& text);

}  // namespace reseau
