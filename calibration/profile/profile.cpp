#include "calibration/profile/profile.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "core/base/error.h"

namespace reseau {
namespace {

void require(bool good, const std::string& field, const char* what) {
  if (!good) throw InputError("The field '" + field + "' of the calibration profile " + what + ".");
}

std::string of_channel(const char* field, std::size_t channel) {
  std::string name(field);
  return name.append(".").append(kProfileChannelNames[channel]);
}

bool finite_and_positive(double value) { return std::isfinite(value) && value > 0; }
bool finite_not_negative(double value) { return std::isfinite(value) && value >= 0; }

void validate_channel(const Profile& profile, std::size_t c) {
  if (const auto& psf = profile.psf[c]) {
    require(finite_and_positive(psf->sigma_px), of_channel("psf", c),
            "must have a sigma_px above 0");
    require(finite_not_negative(psf->sd_px), of_channel("psf", c),
            "must have an sd_px of 0 or more");
  }
  double last_f = -1;
  for (const TransferPoint& point : profile.transfer[c]) {
    require(std::isfinite(point.f_cy_per_px) && point.f_cy_per_px > last_f,
            of_channel("transfer", c), "must have growing frequencies of 0 or more");
    require(
        std::isfinite(point.value) && std::abs(point.value) <= 2 && finite_not_negative(point.sd),
        of_channel("transfer", c), "must have values from -2 to 2 and deviations of 0 or more");
    last_f = point.f_cy_per_px;
  }
  if (const auto& offset = profile.offset_from_green_px[c]) {
    require(std::isfinite(offset->x) && std::isfinite(offset->y),
            of_channel("offset_from_green_px", c), "must be finite");
  }
  if (const auto& dark = profile.dark_level[c]) {
    require(finite_not_negative(*dark) && *dark < 1, of_channel("dark_level", c),
            "must lie between 0 and 1");
  }
  for (const double gain : profile.flat_gain[c]) {
    require(finite_and_positive(gain), of_channel("flat_gain", c), "must have gains above 0 only");
  }
  if (const auto& noise = profile.noise[c]) {
    require(finite_not_negative(noise->a) && finite_not_negative(noise->b), of_channel("noise", c),
            "must have a and b of 0 or more");
  }
}

void validate_records(const Profile& profile, std::size_t c) {
  const auto good = [](const std::optional<Measured>& m) {
    return !m || (std::isfinite(m->value) && finite_not_negative(m->sd));
  };
  if (const auto& gate = profile.gate[c]) {
    const auto not_negative = [](const std::optional<double>& v) {
      return !v || finite_not_negative(*v);
    };
    bool all = not_negative(gate->dark_level_sd) && not_negative(gate->flat_gain_sd) &&
               not_negative(gate->pixel_gain_rms) && not_negative(gate->lamp_rms) &&
               (!gate->shading || std::isfinite(*gate->shading)) && good(gate->nonlinearity);
    for (const Measured& gain : gate->line_gains) all = all && good(gain);
    for (const auto& leakage : gate->leakage) all = all && good(leakage);
    if (gate->noise_covariance) {
      for (const double v : *gate->noise_covariance) all = all && std::isfinite(v);
    }
    require(all, of_channel("gate", c), "must have finite numbers and deviations of 0 or more");
  }
  if (const auto& focus = profile.focus[c]) {
    bool all = std::isfinite(focus->f_cy_per_px) && std::isfinite(focus->depth_share) &&
               good(focus->best_steps) && good(focus->from_green_steps) &&
               good(focus->half_depth_steps);
    for (const auto& point : focus->curve) {
      for (const double v : point) all = all && std::isfinite(v);
    }
    require(all, of_channel("focus", c), "must have finite numbers and deviations of 0 or more");
  }
  if (const auto& sd = profile.offset_sd_px[c]) {
    require(finite_not_negative(sd->x_px) && finite_not_negative(sd->y_px),
            of_channel("offset_sd_px", c), "must be 0 or more");
  }
}

void validate_psf_model(const PsfRecord& model) {
  const std::size_t n = model.names.size();
  const auto finite = [](const std::vector<double>& values) {
    return std::ranges::all_of(values, [](double v) { return std::isfinite(v); });
  };
  require(model.values.size() == n && model.sd.size() == n && model.determined.size() == n &&
              model.covariance.size() == n * n && finite(model.values) && finite(model.sd) &&
              finite(model.covariance) && std::isfinite(model.chi2_per_freedom),
          "psf_model", "must have finite numbers, one for each of its names");
  for (const auto& field : model.field) {
    if (!field) continue;
    require(finite(field->coefficients) && finite(field->covariance), "psf_model.field",
            "must have finite numbers");
  }
}

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", value);
  return text;
}

void compare(std::vector<std::string>& out, const char* what, const std::string& calibrated,
             const std::string& scanned) {
  if (calibrated.empty() || scanned.empty() || calibrated == scanned) return;
  std::string sentence("The calibration is of ");
  out.push_back(sentence.append(what)
                    .append(" '")
                    .append(calibrated)
                    .append("', the scan of '")
                    .append(scanned)
                    .append("'."));
}

}  // namespace

void validate(const Profile& profile) {
  require(!profile.model.empty(), "model", "is empty");
  require(finite_and_positive(profile.resolution_dpi), "resolution_dpi", "must be above 0");
  for (std::size_t c = 0; c < kProfileChannels; ++c) {
    validate_channel(profile, c);
    validate_records(profile, c);
  }
  if (profile.psf_model) validate_psf_model(*profile.psf_model);
}

std::vector<std::string> mismatches(const Profile& profile, const CaptureContext& context,
                                    double dpi) {
  std::vector<std::string> out;
  compare(out, "make", profile.make, context.make);
  compare(out, "model", profile.model, context.model);
  compare(out, "serial number", profile.serial, context.serial);
  compare(out, "firmware", profile.firmware, context.firmware);
  compare(out, "holder", profile.holder, context.holder);
  // Files round the resolution to a few digits.
  if (dpi > 0 && std::abs(dpi - profile.resolution_dpi) > 0.01 * profile.resolution_dpi) {
    out.push_back("The calibration was measured at " + number(profile.resolution_dpi) +
                  " dpi, the scan has " + number(dpi) + " dpi.");
  }
  return out;
}

}  // namespace reseau
