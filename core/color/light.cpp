#include "core/color/light.h"

#include <charconv>
#include <cmath>

#include "core/base/error.h"

namespace reseau {
namespace {

// Nominal daylight temperatures stem from an older value of the constant c2 (CIE 15:2018, 3.1).
constexpr double kNominalToTrue = 1.4388 / 1.4380;
// A bare temperature below this is a black body: daylight is not defined there.
constexpr double kCoolestDaylight_k = 4000;

// What lies within 380..780 nm, as far as the tables of lights reach.
Observer visible_part(const Observer& whole) {
  Observer part;
  part.grid = {380, whole.grid.step_nm, static_cast<int>(400 / whole.grid.step_nm) + 1};
  const auto first = static_cast<std::ptrdiff_t>((380 - whole.grid.first_nm) / whole.grid.step_nm);
  const auto cut = [&](const std::vector<double>& values) {
    return std::vector<double>(values.begin() + first, values.begin() + first + part.grid.count);
  };
  part.xbar = cut(whole.xbar);
  part.ybar = cut(whole.ybar);
  part.zbar = cut(whole.zbar);
  return part;
}

[[noreturn]] void throw_unknown(std::string_view word) {
  throw InputError("There is no light '" + std::string(word) +
                   "'; use A, B, C, D50, D55, D65, D75 or E, a temperature from 1000 K, such as "
                   "3200K (below 4000 K a black body, from there to 25000 K daylight), or a black "
                   "body of any temperature as planck:5000.");
}

double temperature(std::string_view text, std::string_view word) {
  if (!text.empty() && (text.back() == 'K' || text.back() == 'k')) text.remove_suffix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) throw_unknown(word);
  return value;
}

std::string in_kelvin(double temperature_k) {
  std::string text = std::to_string(temperature_k);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text + " K";
}

}  // namespace

const Observer& observer_of(SummationStep step) {
  static const Observer fine = visible_part(observer_1nm());
  return step == SummationStep::k1nm ? fine : observer_5nm();
}

SummationStep parse_summation_step(std::string_view word) {
  if (word == "5") return SummationStep::k5nm;
  if (word == "1") return SummationStep::k1nm;
  throw InputError("Spectra are summed in steps of 5 or 1 nm, not '" + std::string(word) + "'.");
}

Light light_of(Illuminant illuminant) {
  constexpr std::array<const char*, 6> kNames{"A", "B", "C", "D50", "D65", "E"};
  return {kNames[static_cast<std::size_t>(illuminant)], illuminant_spectrum(illuminant)};
}

Light daylight(double temperature_k) {
  return {"daylight of " + in_kelvin(temperature_k), daylight_spectrum(temperature_k)};
}

Light planckian(double temperature_k) {
  if (!(temperature_k >= 1000 && temperature_k <= 25000)) {
    throw InputError("Lights are taken from 1000 K to 25000 K; choose a temperature between.");
  }
  constexpr double kC2NmK = 1.4388e7;  // CIE 15:2018
  const auto radiance = [temperature_k](double nm) {
    return std::pow(560 / nm, 5) / std::expm1(kC2NmK / (nm * temperature_k));
  };
  Light light{"black body of " + in_kelvin(temperature_k), {{380, 1, 401}, {}}};
  for (int i = 0; i < light.spectrum.grid.count; ++i) {
    light.spectrum.values.push_back(100 * radiance(light.spectrum.grid.wavelength_nm(i)) /
                                    radiance(560));
  }
  return light;
}

Light parse_light(std::string_view word) {
  for (const std::string_view name : {"A", "B", "C", "D50", "D65", "E"}) {
    if (word == name) return light_of(parse_illuminant(name));
  }
  constexpr std::string_view kPlanck = "planck:", kDaylight = "daylight:";
  if (word.substr(0, kPlanck.size()) == kPlanck) {
    return planckian(temperature(word.substr(kPlanck.size()), word));
  }
  if (word.substr(0, kDaylight.size()) == kDaylight) {
    return daylight(temperature(word.substr(kDaylight.size()), word));
  }
  if (word.size() > 1 && word.front() == 'D') {
    Light light = daylight(temperature(word.substr(1), word) * 100 * kNominalToTrue);
    light.name = word;
    return light;
  }
  const double temperature_k = temperature(word, word);
  return temperature_k < kCoolestDaylight_k ? planckian(temperature_k) : daylight(temperature_k);
}

Spectrum power_on(const Light& light, const WavelengthGrid& grid) {
  return light.spectrum.grid == grid ? light.spectrum : resample(light.spectrum, grid);
}

Xyz white_of(const Light& light, SummationStep step) {
  const Observer& observer = observer_of(step);
  return white_of(power_on(light, observer.grid), observer);
}

}  // namespace reseau
