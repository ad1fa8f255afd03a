#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

namespace reseau {

// From a 16-bit sample to linear light, 65535 = 1.0, one table of 65536 entries per channel in the
// order red, green, blue, infrared. Immutable after construction.
class ToneCurves {
 public:
  // value / 65535.
  static ToneCurves linear();
  // (value / 65535)^gamma. gamma must be finite and in 0.1..10, else InputError.
  static ToneCurves gamma(double gamma);
  // Any four tables of 65536 entries. Throws InputError when one is not finite.
  explicit ToneCurves(std::array<std::vector<float>, 4> tables);

  // True for value / 65535 in all four.
  [[nodiscard]] bool is_linear() const { return linear_; }
  [[nodiscard]] const std::vector<float>& table(int channel) const {
    return *tables_[static_cast<std::size_t>(channel)];
  }

 private:
  using Table = std::shared_ptr<const std::vector<float>>;
  ToneCurves(const Table& all, bool linear);

  std::array<Table, 4> tables_;  // a copy of the curves shares them
  bool linear_ = false;
};

}  // namespace reseau
