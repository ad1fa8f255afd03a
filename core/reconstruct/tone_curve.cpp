#include "core/reconstruct/tone_curve.h"

#include <cmath>
#include <utility>

#include "core/base/check.h"
#include "core/base/error.h"

namespace reseau {
namespace {
constexpr std::size_t kEntries = 65536;

std::vector<float> power_table(double gamma) {
  std::vector<float> table(kEntries);
  for (std::size_t i = 0; i < kEntries; ++i) {
    table[i] = static_cast<float>(std::pow(static_cast<double>(i) / 65535.0, gamma));
  }
  return table;
}
}  // namespace

ToneCurves::ToneCurves(std::array<std::vector<float>, 4> tables) : tables_(std::move(tables)) {
  linear_ = true;
  for (const auto& table : tables_) {
    CHECK(table.size() == kEntries);
    for (std::size_t i = 0; i < kEntries; ++i) {
      if (!std::isfinite(table[i])) {
        throw InputError("The tone curve of the scan holds values that are not numbers.");
      }
      linear_ = linear_ && table[i] == static_cast<float>(static_cast<double>(i) / 65535.0);
    }
  }
}

ToneCurves ToneCurves::linear() { return gamma(1.0); }

ToneCurves ToneCurves::gamma(double gamma) {
  if (!(gamma >= 0.1 && gamma <= 10.0)) {
    throw InputError(
        "The gamma must lie between 0.1 and 10: 1 is a linear scan, 2.2 a usual encoded one.");
  }
  const auto table = power_table(gamma);
  return ToneCurves({table, table, table, table});
}

}  // namespace reseau
