#pragma once

#include <optional>
#include <string>

#include "drivers/recording/exchange.h"
#include "drivers/scsi/sense.h"

namespace reseau {

// What the status block of a command says; absent where the recording has none.
[[nodiscard]] std::optional<Sense> sense_of(const Exchange& exchange);
// "good", the sentence of its sense, or why there is none.
// "SET WINDOW, 58 bytes [24 …]"
[[nodiscard]] std::string name_of(const Exchange& exchange);
[[nodiscard]] std::string outcome_of(const Exchange& exchange);
// Readable and diffable, two to six lines, each ended: number, packet, seconds since the start,
// phase; the command; what its data says; what the unit answered.
[[nodiscard]] std::string text_of(const Exchange& exchange, std::int64_t start_us);

}  // namespace reseau
