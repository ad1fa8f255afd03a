// What `reseau bench` measures, one function per kind.
#pragma once

#include <CLI/App.hpp>

#include "capture/cli/program.h"

namespace reseau::cli {

void add_bench_reconstruction(Program& program, CLI::App* bench);
void add_bench_speed(Program& program, CLI::App* bench);
void add_bench_stress(Program& program, CLI::App* bench);

}  // namespace reseau::cli
