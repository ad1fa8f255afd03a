// The records of a profile as JSON. Part of profile_io.
#pragma once

#include <cstddef>

#include "calibration/profile/profile.h"
#include "calibration/profile/profile_fields.h"

namespace reseau::profile {

// Adds "gate", "focus", "offset_sd_px" of a channel where they were measured.
void put_records(const Profile& profile, std::size_t channel, Json& to);
void get_records(const Fields& from, std::size_t channel, Profile& profile);

[[nodiscard]] Json psf_record_to_json(const PsfRecord& record);
[[nodiscard]] PsfRecord psf_record_from(const Fields& from);

}  // namespace reseau::profile
