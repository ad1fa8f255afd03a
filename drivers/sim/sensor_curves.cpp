#include "drivers/sim/sensor_curves.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"

namespace reseau::sim {
namespace {

constexpr std::array<std::string_view, 4> kCurveData{
    "005300d7015601d7025602d405530a4a0cc7192d32364b8a651a7ed498a2b288cc75e667f35b005400d9015a01db02"
    "5c02dc05630a650ce5196b32894bc665257eb79870b235cc32e625f30e005800af0111017e01f0026904d309c90c44"
    "18c331ff4b6464fb7ea6988bb270cc74e661f362005900ac0106016901d0023e0489096b0beb187731cd4b4564da7e"
    "889854b22acc22e61bf32d",
    "005300d7015401d3025202d0054e0a430cbd191a321c4b6e64f27ea2987cb270cc6fe66df36a005200da015901da02"
    "5c02db05640a600cea197b32a84bfe65797f2e98fbb2e1ccf9e70df419005600ad0110017b01ee026704ce09c00c3a"
    "18b531db4b4364d67e919879b261cc64e66cf35d005500ad0106016a01d1023f048c09720bef189031f54b8665227e"
    "fd98d3b2d0ccece714f435",
    "005400d7015501d6025102d2054b0a3b0cb5191132064b5364d97e88986cb25bcc63e65ef358005200db015f01df02"
    "5c02db05650a670cea197932a44bf2657b7f2498fcb2e4ccfde728f445005500ad0110017e01ef026604cf09bd0c34"
    "18ac31cc4b2964b87e7f985bb257cc5ee66df364005300ad0109016901d30242048f09740bf5188d31f24b6c651d7e"
    "fc98d3b2e5cd0ee72df466",
    "005300d1014f01cf024e02ce05520a4c0ccb193c32554bb8653a7ef598bbb297cc77e64bf342005300cc014f01cf02"
    "5102d0055b0a6a0cf1199032e04c4765d37f88995bb34acd42e756f45b005900ab010c017701eb026304d209ca0c4a"
    "18d7321b4b8d65237ed498b2b28ecc72e65ef33f005800a70101016401c90235048409730bf218a632284bc965847f"
    "5e994cb345cd4ee76df477"};

constexpr std::size_t kType = 1;  // the type that record 7 of a two-line scan names

}  // namespace

std::string_view recorded_curves(std::size_t channel) {
  CHECK(channel < kCurveData.size());
  return kCurveData[channel];
}

Bytes curve_data(std::size_t channel, int sensor_lines, int types, double strength) {
  const Bytes recorded = from_hex(recorded_curves(channel));
  Bytes data;
  for (int line = 0; line < sensor_lines; ++line) {
    const double share = line == 0 ? 0 : line == 1 ? strength : strength / 2;
    for (int type = 0; type < types; ++type) {
      for (std::size_t k = 0; k < kCurvePoints; ++k) {
        const std::size_t at = 2 * (static_cast<std::size_t>(type % 2) * kCurvePoints + k);
        const double first = get16(recorded, at);
        const double second = get16(recorded, at + 4 * std::size_t{kCurvePoints});
        put16(data, static_cast<std::uint32_t>(std::lround(first + share * (second - first))));
      }
    }
  }
  return data;
}

LineResponse::LineResponse(std::size_t channel, int line, double strength)
    : share_(static_cast<float>(line == 0   ? 0.0
                                : line == 1 ? strength
                                            : strength / 2)) {
  const Bytes bytes = from_hex(recorded_curves(channel));
  for (std::size_t k = 0; k < kCurvePoints; ++k) {
    const std::size_t first = 2 * (kType * kCurvePoints + k);
    const std::size_t second = 2 * ((2 + kType) * kCurvePoints + k);
    from_[k] = static_cast<float>(get16(bytes, first)) / 65535;
    to_[k] = static_cast<float>(get16(bytes, second)) / 65535;
  }
}

float LineResponse::operator()(float value) const {
  if (share_ == 0 || value <= from_[0]) return value;
  const auto above = std::ranges::upper_bound(from_, value);
  float answer = 0;
  if (above == from_.end()) {
    answer = value * to_.back() / from_.back();
  } else {
    const auto k = static_cast<std::size_t>(above - from_.begin());
    const float t = (value - from_[k - 1]) / (from_[k] - from_[k - 1]);
    answer = to_[k - 1] + t * (to_[k] - to_[k - 1]);
  }
  return value + share_ * (answer - value);
}

}  // namespace reseau::sim
