#include "capture/image/lcms_handles.h"

#include <array>
#include <cstdint>

#include "core/base/check.h"

namespace reseau {
namespace {

std::vector<std::byte> saved_icc(const LcmsProfile& profile) {
  cmsUInt32Number size = 0;
  CHECK(cmsSaveProfileToMem(profile.get(), nullptr, &size));
  std::vector<std::byte> out(size);
  CHECK(cmsSaveProfileToMem(profile.get(), out.data(), &size));
  return out;
}

}  // namespace

// lcms2 puts the time of creation into bytes 24-35 of the header (ICC.1, header fields): replaced
// by a constant, six big-endian 16-bit numbers, and the profile ID (MD5) is computed after that.
std::vector<std::byte> reproducible_icc(const LcmsProfile& profile) {
  constexpr std::array<std::uint8_t, 12> kDate = {0x07, 0xEA, 0, 1, 0, 1, 0, 0, 0, 0, 0, 0};
  auto bytes = saved_icc(profile);
  CHECK(bytes.size() > 128);
  for (std::size_t i = 0; i < kDate.size(); ++i) bytes[24 + i] = std::byte{kDate[i]};
  const LcmsProfile dated(
      cmsOpenProfileFromMem(bytes.data(), static_cast<cmsUInt32Number>(bytes.size())));
  CHECK(dated != nullptr && cmsMD5computeID(dated.get()));
  return saved_icc(dated);
}

void write_icc_text(const LcmsProfile& profile, cmsTagSignature tag, const std::string& text) {
  cmsMLU* mlu = cmsMLUalloc(nullptr, 1);
  CHECK(mlu != nullptr && cmsMLUsetASCII(mlu, "en", "US", text.c_str()) &&
        cmsWriteTag(profile.get(), tag, mlu));
  cmsMLUfree(mlu);
}

}  // namespace reseau
