// What the drivers read of an image from the simulated wire: bytes of samples per second, from the
// unit's bytes to lines of red, green, blue and infrared. RESEAU_BENCH_DEVICE names a device to
// read from as well, for example usb:04b0:4002 under a USB/IP host.
#include <cstdlib>
#include <memory>
#include <stdexcept>
#include <string>

#include <benchmark/benchmark.h>

#include "drivers/registry.h"

namespace {

using reseau::ReadStatus;

class NoTalk final : public reseau::ScanObserver {
 public:
  void phase(reseau::ScanPhase /*phase*/, const std::string& /*detail*/) override {}
  void note(const std::string& /*sentence*/) override {}
};

void read_image(benchmark::State& state, const std::string& device, int dpi) {
  const reseau::OpenedScanner opened = reseau::open_scanner(device, {});
  reseau::Scanner& scanner = *opened.scanner;
  reseau::ScanRequest request;
  request.resolution_dpi = dpi;
  request.area.height_mm = 4.0;
  request.focus.mode = reseau::FocusRequest::Mode::kKeep;
  request.exposure.mode = reseau::ExposureRequest::Mode::kFixed;
  const reseau::ScanPlan plan = scanner.negotiate(request).plan;
  NoTalk observer;
  std::int64_t n_samples = 0;
  for (auto unused : state) {
    state.PauseTiming();
    if (!scanner.start(plan, observer, {})) throw std::runtime_error("not started");
    state.ResumeTiming();
    reseau::LineBlock block;
    while (scanner.read(block, reseau::Duration(0)) == ReadStatus::kLines) {
      n_samples += static_cast<std::int64_t>(block.used().size());
    }
  }
  state.SetBytesProcessed(2 * n_samples);
}

// Bare light, no noise: as little of the time as can be is the simulation's.
std::string quick(const std::string& model) {
  return "sim:" + model + "?film=none&noise=0&cells=1&busy_polls=0";
}

void unit(benchmark::State& state, const std::string& model, int dpi) {
  read_image(state, quick(model), dpi);
}
void named_device(benchmark::State& state) {
  const char* const name = std::getenv("RESEAU_BENCH_DEVICE");
  if (name == nullptr) return state.SkipWithError("RESEAU_BENCH_DEVICE is not set");
  read_image(state, name, 4000);
}

#define RESEAU_UNIT(model, dpi) \
  BENCHMARK_CAPTURE(unit, model, #model, dpi)->UseRealTime()->Unit(benchmark::kMillisecond)

RESEAU_UNIT(ls5000, 4000);
RESEAU_UNIT(ls50, 4000);
RESEAU_UNIT(ls40, 2900);
RESEAU_UNIT(ls4000, 4000);
RESEAU_UNIT(ls8000, 4000);
RESEAU_UNIT(ls9000, 4000);
RESEAU_UNIT(ls2000, 2700);
RESEAU_UNIT(ls30, 2700);
RESEAU_UNIT(crystalscan3600, 3600);
RESEAU_UNIT(crystalscan7200, 3600);
RESEAU_UNIT(proscan7200, 3600);
RESEAU_UNIT(proscan10t, 5000);
RESEAU_UNIT(digitdia5000, 3600);
RESEAU_UNIT(digitdia6000, 5000);
RESEAU_UNIT(rps7200, 3600);
BENCHMARK(named_device)->UseRealTime()->Unit(benchmark::kMillisecond);

}  // namespace
