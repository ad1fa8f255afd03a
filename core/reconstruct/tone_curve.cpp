#include "core/reconstruct/tone_curve.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "core/base/check.h"
#include "core/base/error.h"

namespace reseau {
namespace {
constexpr std::size_t kEntries = 65536;

std::shared_ptr<const std::vector<float>> power_table(double gamma) {
  auto table = std::make_shared<std::vector<float>>(kEntries);
  for (std::size_t i = 0; i < kEntries; ++i) {
    (*table)[i] = static_cast<float>(std::pow(static_cast<double>(i) / 65535.0, gamma));
  }
  return table;
}

bool is_linear(const std::vector<float>& table) {
  for (std::size_t i = 0; i < kEntries; ++i) {
    if (table[i] != static_cast<float>(static_cast<double>(i) / 65535.0)) return false;
  }
  return true;
}
}  // namespace

ToneCurves::ToneCurves(std::array<std::vector<float>, 4> tables) : linear_(true) {
  for (std::size_t channel = 0; channel < tables.size(); ++channel) {
    auto& table = tables[channel];
    CHECK(table.size() == kEntries);
    if (!std::ranges::all_of(table, [](float v) { return std::isfinite(v); })) {
      throw InputError("The tone curve of the scan holds values that are not numbers.");
    }
    linear_ = linear_ && reseau::is_linear(table);
    tables_[channel] = std::make_shared<const std::vector<float>>(std::move(table));
  }
}

ToneCurves::ToneCurves(const Table& all, bool linear)
    : tables_{all, all, all, all}, linear_(linear) {}

ToneCurves ToneCurves::linear() {
  static const ToneCurves kLinear(power_table(1.0), true);
  return kLinear;
}

ToneCurves ToneCurves::gamma(double gamma) {
  if (!(gamma >= 0.1 && gamma <= 10.0)) {
    throw InputError(
        "The gamma must lie between 0.1 and 10: 1 is a linear scan, 2.2 a usual encoded one.");
  }
  return gamma == 1.0 ? linear() : ToneCurves(power_table(gamma), false);
}

}  // namespace reseau
