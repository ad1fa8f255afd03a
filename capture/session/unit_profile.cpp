#include "capture/session/unit_profile.h"

#include <chrono>
#include <cstddef>
#include <cstdio>
#include <utility>

#include <fmt/format.h>

#include "calibration/profile/profile_io.h"
#include "core/base/error.h"

namespace reseau {
namespace {

std::optional<std::chrono::sys_days> day_of(const std::string& iso) {
  int year = 0;
  unsigned month = 0, day = 0;
  if (std::sscanf(iso.c_str(), "%4d-%2u-%2u", &year, &month, &day) != 3) return std::nullopt;
  const std::chrono::year_month_day date{std::chrono::year(year), std::chrono::month(month),
                                         std::chrono::day(day)};
  if (!date.ok()) return std::nullopt;
  return std::chrono::sys_days(date);
}

// What makes a curve that of another machine or sampling; holder and firmware do not.
std::vector<std::string> reasons_against(const Profile& profile, CaptureContext context,
                                         double dpi) {
  context.holder.clear();
  context.firmware.clear();
  return mismatches(profile, context, dpi);
}

UsedProfile used(const Profile& profile, std::filesystem::path path,
                 const CaptureContext& context) {
  UsedProfile out;
  out.unit.transfer = profile.transfer;
  for (std::size_t c = 0; c < kProfileChannels; ++c) {
    out.levels.dark_level[c] = profile.dark_level[c].value_or(0);
  }
  out.levels.flat_gain = profile.flat_gain;
  for (std::size_t c = 0; profile.psf_model && profile.psf_model->surfaces && c < kProfileChannels;
       ++c) {
    const auto& field = profile.psf_model->field[c];
    if (!field || field->order == 0) continue;
    out.unit.field[c] =
        UnitField{field->coefficients, field->covariance, profile.psf_model->surfaces->frame_px};
  }
  out.path = std::move(path);
  out.measured_at_utc = profile.measured_at_utc;
  out.notes = mismatches(profile, context, 0);
  if (out.unit.empty() && out.levels.empty()) {
    out.notes.emplace_back(
        "The calibration holds nothing that reconstruction can use: calibrate again.");
  }
  const auto then = day_of(profile.measured_at_utc), now = day_of(context.started_at_utc);
  constexpr std::chrono::days kOld{365};
  if (then && now && *now - *then > kOld) {
    out.notes.push_back(fmt::format("The calibration was {} days old when the film was scanned.",
                                    (*now - *then).count()));
  }
  return out;
}

}  // namespace

ProfileChoice parse_profile_choice(const std::string& word) {
  ProfileChoice choice;
  choice.look_for_it = word == "auto";
  if (word == "auto" || word == "none") return choice;
  choice.path = word;
  choice.given = load_profile(choice.path);
  return choice;
}

UsedProfile use_profile(const ProfileChoice& choice, const CaptureContext& context, double dpi) {
  if (choice.given) {
    const std::vector<std::string> against = reasons_against(*choice.given, context, dpi);
    if (!against.empty()) {
      throw InputError(fmt::format("The calibration {} does not fit this scan. {}",
                                   choice.path.string(), fmt::join(against, " ")));
    }
    return used(*choice.given, choice.path, context);
  }
  UsedProfile none;
  if (!choice.look_for_it || context.model.empty()) return none;
  ProfileSearch search =
      find_profile(default_profile_directory(), context.model, context.serial, dpi);
  none.notes = std::move(search.problems);
  if (!search.found) return none;
  const std::vector<std::string> against = reasons_against(search.found->profile, context, dpi);
  if (against.empty()) return used(search.found->profile, search.found->path, context);
  none.notes.insert(none.notes.end(), against.begin(), against.end());
  return none;
}

}  // namespace reseau
