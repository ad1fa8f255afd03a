#include <exception>
#include <iostream>

#include <unistd.h>

#include "capture/cli/program.h"
#include "capture/cli/signals.h"
#include "capture/cli/verbs.h"

int main(int argc, char** argv) {
  try {
    reseau::cli::SignalWatcher signals;
    reseau::cli::Program program(signals, std::cout, std::cerr, ::isatty(STDERR_FILENO) == 1);
    reseau::cli::add_all_verbs(program);
    return program.run(argc, argv);
  } catch (const std::exception& error) {
    std::cerr << "reseau: " << error.what() << '\n';
    return reseau::cli::kExitInternal;
  }
}
