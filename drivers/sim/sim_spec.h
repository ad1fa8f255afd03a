// The name of a simulated device, parsed: "sim:ls5000?film=dufay&scene=chart&angle=23". Keys and
// ranges: README.md, or sim_key_help().
#pragma once

#include <string>
#include <string_view>

#include "drivers/sim/film_spec.h"
#include "drivers/sim/optics_spec.h"

namespace reseau::sim {

// Default: the LS-5000 has an SA-30, the other units with adapters an SA-21.
enum class AdapterKind { kDefault, kNone, kSa21, kSa30, kMount, kAps, kFeeder };

// Faults and habits of the simulated unit. Counts are of bulk transfers since opening; 0 = never.
struct UnitSpec {
  AdapterKind adapter = AdapterKind::kDefault;
  bool cold = false;           // still initialising when opened; reports power on afterwards
  int film_arrives_polls = 0;  // film is pushed in after so many TEST UNIT READY
  int busy_polls = 2;          // polls that an asynchronous operation stays busy
  int busy_phases = 0;         // phase queries an image READ answers with "busy"
  int fragment_bytes = 0;      // longest IN transfer, whole packets; 0 = any length
  bool old_lut = false;        // another program left a gamma curve in the LUT (LS-50)
  bool focus_fails = false;    // autofocus ends with an error
  int stale_bytes = 0;         // left in the IN pipe by an earlier program
  int unplug_after = 0;        // from this transfer on the unit is gone
  int stall_after = 0;         // this one transfer stalls
  int silent_after = 0;        // from this transfer on IN times out
  int timeout_after = 0;       // this one transfer gets no answer in time
  int short_after = 0;         // of this one transfer half arrives
  int garbage_after = 0;       // the status of this one is noise
  bool full_speed = false;     // behind a cable or hub of full speed
  bool early_end = false;      // a thumbnail ends with the film
  int lost_commands = 0;       // of so many, the first is answered "busy" and lost (LS-40)
  int feeder_slides = 10;      // in the magazine
  double line_response = 1;    // how far the lines of a sensor differ, as SensorSpec has it
  int again = 0;               // PIE: so many times the first READ of a pass has to come again
  bool bottom_up = false;      // PIE: passes are read with the carriage coming back
};

struct SimSpec {
  std::string model = "ls5000";
  FilmSpec film;
  OpticsSpec optics;
  StageSpec stage;
  SensorSpec sensor;
  UnitSpec unit;
};

// Accepts the name with or without "sim:". Throws InputError with a sentence that lists the nearest
// keys and ranges for an unknown key or a value outside its range. The model is not checked here.
// Reads the picture of image=FILE, unless it is left to load_picture().
enum class ScenePicture { kLoad, kLater };
[[nodiscard]] SimSpec parse_sim_spec(std::string_view name,
                                     ScenePicture picture = ScenePicture::kLoad);
// Reads the picture that was asked for, if any. Throws InputError when it cannot.
void load_picture(FilmSpec& film);

// One line per key: name, range, meaning.
[[nodiscard]] std::string sim_key_help();

}  // namespace reseau::sim
