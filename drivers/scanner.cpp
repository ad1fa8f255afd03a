#include "drivers/scanner.h"

#include "core/base/error.h"

namespace reseau {

void Scanner::eject(ScanObserver& /*observer*/) {
  throw InputError(
      "This scanner or its adapter has no motor that ejects film. Take it out by hand.");
}

void Scanner::load(ScanObserver& /*observer*/) {
  throw InputError("This scanner or its adapter has no motor that loads film. Put it in by hand.");
}

}  // namespace reseau
