#pragma once

#include <string>

namespace reseau {

// Under which name a scanner was opened.
struct OpenAs {
  std::string device_name;  // kept in the context of captures
  // Empty: the time of the day at start(). Recordings and replays fix it, so that a replay writes
  // the bytes of the original.
  std::string started_at_utc;
};

}  // namespace reseau
