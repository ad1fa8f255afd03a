#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <system_error>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "capture/cli/develop_choice.h"
#include "capture/cli/export_run.h"
#include "capture/cli/verbs.h"
#include "capture/session/receipt.h"
#include "capture/simulate/truth_files.h"
#include "capture/store/master_writer.h"
#include "core/base/error.h"
#include "drivers/sim/simulate.h"

namespace reseau::cli {

namespace {

struct SimulateArguments {
  std::vector<std::string> keys, settings;
  std::optional<std::uint64_t> seed;
  std::string film, scene, screen, image, output, truth, model, usbip;
  // Text, so that the check and the sentence are those of the settings.
  std::string width, height, angle, blur, noise;
};

// The device's name of everything that was asked for; what is said later wins.
std::string device_name_of(const SimulateArguments& options) {
  // The unit of --model, else that of a device's name.
  std::string model = options.model;
  for (const std::string& key : options.keys) {
    if (model.empty() && key.rfind("sim:", 0) == 0) model = key.substr(4, key.find('?') - 4);
  }
  std::string name = "sim:" + (model.empty() ? "ls5000" : model);
  char separator = '?';
  const auto add = [&](const std::string& pair) {
    name += separator + pair;
    separator = '&';
  };
  for (const std::string& key : options.keys) {
    if (key.rfind("sim:", 0) == 0) {
      const std::size_t mark = key.find('?');
      if (mark != std::string::npos) add(key.substr(mark + 1));
    } else {
      add(key);
    }
  }
  for (const std::string& pair : options.settings) add(pair);
  const std::pair<const char*, const std::string&> direct[] = {
      {"film", options.film},   {"scene", options.scene},    {"screen", options.screen},
      {"image", options.image}, {"width_px", options.width}, {"height_px", options.height},
      {"angle", options.angle}, {"blur_px", options.blur},   {"noise", options.noise}};
  for (const auto& [key, value] : direct) {
    if (value.find('&') != std::string::npos) {
      throw InputError(
          fmt::format("'{}' cannot be used for {}; use --set for more settings.", value, key));
    }
    if (!value.empty()) add(fmt::format("{}={}", key, value == "chart24" ? "chart" : value));
  }
  if (options.seed) add(fmt::format("seed={}", *options.seed));
  return name;
}

// Part of a simulated film is of no use: unlike a scan it can be had again.
void discard(MasterWriter& writer, ScanEnd end) {
  writer.end(end);
  std::error_code left;
  if (!writer.result().path.empty()) std::filesystem::remove(writer.result().path, left);
}

// Rendered and written a band of lines at a time. False when it was stopped; then there is no file.
bool write_scan(const sim::WindowRender& render, const std::filesystem::path& path, Work& work) {
  MasterOptions options;
  options.path = path;
  MasterWriter writer(options);
  CaptureContext context;
  context.device_name = "sim";
  context.model = "simulated film";
  writer.begin(render.format(), context);
  const int n_lines = render.format().n_lines;
  LineBlock block;
  block.width_px = render.format().width_px;
  block.n_channels = render.format().n_channels();
  const std::size_t per_line = render.format().samples_per_line();
  work.reporter.phase("render", path.string());
  try {
    for (int y = 0; y < n_lines; y += render.band_lines()) {
      block.first_line = y;
      block.n_lines = std::min(render.band_lines(), n_lines - y);
      block.samples.resize(static_cast<std::size_t>(block.n_lines) * per_line);
      render.lines(y, block.n_lines, block.samples);
      writer.lines(block);
      work.reporter.progress("render", {double(y + block.n_lines) / n_lines, 1, "", 0});
      if (work.signals.stop().stop_requested()) {
        discard(writer, ScanEnd::kCancelled);
        return false;
      }
    }
  } catch (...) {
    discard(writer, ScanEnd::kFailed);
    throw;
  }
  writer.end(ScanEnd::kComplete);
  if (writer.result().error) std::rethrow_exception(writer.result().error);
  return true;
}

// Picture, elements, spread functions, then the parameters that tell of them.
void write_truth(const sim::SimSpec& spec, const simulate::KnownScan& scan,
                 const std::string& scan_name, const simulate::TruthNames& names, Work& work) {
  work.reporter.phase("truth", names.picture.string());
  const bool whole = simulate::write_truth_picture(scan, names.picture, [&work](double fraction) {
    work.reporter.progress("truth", {fraction, 1, "", 0});
    return !work.signals.stop().stop_requested();
  });
  if (!whole) return;
  nlohmann::ordered_json object = simulate::truth_to_json(spec, scan);
  object["files"] = {{"scan", std::filesystem::path(scan_name).filename().string()},
                     {"picture", names.picture.filename().string()},
                     {"psf", names.psf.filename().string()}};
  simulate::write_psf_grid(spec, names.psf);
  if (scan.truth.has_screen()) {
    const simulate::FirstPeriod first = simulate::write_element_samples(scan, names.elements);
    object["files"]["elements"] = names.elements.filename().string();
    object["elements"] = {{"first_u", first.u}, {"first_v", first.v}};
  }
  write_json_file(object, names.parameters);
}

ExitCode run_simulate(const SimulateArguments& options, Work& work) {
  const std::string device_name =
      as_failure(Doing::kReadingOptions, [&] { return device_name_of(options); });
  if (!options.usbip.empty()) {
    if (!options.output.empty() || !options.truth.empty()) {
      throw Failure(kExitUsage,
                    "--usbip serves a unit and writes no file; leave -o and --truth out.");
    }
    return run_export(device_name, options.usbip, work);
  }
  if (options.output.empty()) {
    throw Failure(kExitUsage, "Say where the scan goes with -o, or export the unit with --usbip.");
  }
  sim::SimSpec spec = as_failure(Doing::kReadingOptions, [&] {
    sim::SimSpec asked = sim::parse_sim_spec(device_name, sim::ScenePicture::kLater);
    sim::check_model(asked);
    return asked;
  });
  const simulate::TruthNames names = simulate::truth_names(options.truth);
  std::vector<std::filesystem::path> files{options.output};
  if (!options.truth.empty()) {
    if (names.picture == names.parameters) {
      throw Failure(kExitUsage, "The truth is an EXR; give --truth a name that ends in .exr.");
    }
    files.insert(files.end(), {names.picture, names.parameters, names.elements, names.psf});
  }
  for (const std::filesystem::path& file : files) {
    refuse_existing(file);
    const auto parent = file.parent_path();
    if (!parent.empty()) prepare_directory(parent);
  }
  as_failure(spec.film.picture.empty() ? Doing::kReadingOptions : Doing::kReadingInput,
             [&] { sim::load_picture(spec.film); });
  work.reporter.say(fmt::format("{} × {} px, seed {}, to {}", spec.film.frame.width_px,
                                spec.film.frame.height_px, spec.film.seed, options.output));
  const sim::ScanWindow window = sim::frame_window(spec);
  const sim::WindowRender render =
      as_failure(Doing::kReadingOptions, [&] { return sim::WindowRender(spec, window); });
  as_failure(Doing::kWriting, [&] {
    if (write_scan(render, options.output, work) && !options.truth.empty()) {
      write_truth(spec, {render.format(), sim::truth_of(spec, window)}, options.output, names,
                  work);
    }
  });
  if (work.signals.count() > 0) {
    work.reporter.warning("Stopped.");
    return kExitCancelled;
  }
  work.reporter.event("file", {{"role", "scan"}, {"path", options.output}});
  if (!options.truth.empty()) {
    work.reporter.event("file", {{"role", "truth"}, {"path", options.truth}});
    work.reporter.event("file", {{"role", "parameters"}, {"path", names.parameters.string()}});
  }
  work.reporter.result_line(options.output);
  return kExitOk;
}

}  // namespace

void add_simulate(Program& program) {
  auto options = std::make_shared<SimulateArguments>();
  CLI::App* app = program.add_verb(
      "simulate",
      "Renders the simulated film straight to a TIFF: the samples that the simulated unit sends at "
      "its\nwhite-balance exposures, without the wire. --truth NAME.exr writes what is known "
      "beside "
      "it:\nR, G, B (process RGB: 1 = clear film behind that element) and u, v (periods of the "
      "réseau) of\nevery pixel; NAME.elements.exr, the same of every element; NAME.psf.exr, the "
      "spread "
      "functions;\nNAME.json, all parameters. The same settings and seed give the same files.\n\n"
      "--usbip exports the whole unit with its film as a USB device instead, until Ctrl-C, so that "
      "any\nprogram can scan with it.\n\n"
      "Settings, as words, with --set, or in the name of a device "
      "(sim:ls5000?angle=10&noise=0):\n" +
          sim::sim_key_help(),
      "reseau simulate --film dufay --scene chart24 -o scan.tif --truth truth.exr\n"
      "reseau simulate --width 800 --height 600 --scene natural --set fade=0.3 --seed 7 -o "
      "film.tif\n"
      "reseau simulate --usbip tcp:127.0.0.1:3240 --model ls5000 --film dufay --scene natural",
      [options](Work& work) { return run_simulate(*options, work); });
  app->add_option("KEY=VALUE", options->keys, "Settings of film, optics, stage and sensor");
  app->add_option("--set", options->settings, "One more setting, KEY=VALUE")
      ->allow_extra_args(false);
  app->add_option("--film", options->film, "dufay (default), another screen, none or empty");
  app->add_option("--screen", options->screen, "The réseau: dufay, paget, joly …");
  app->add_option("--scene", options->scene, "What the camera saw: chart24 …, or an image file");
  app->add_option("--image", options->image, "An image file that the camera saw");
  app->add_option("--width", options->width, "Pixels of the frame across");
  app->add_option("--height", options->height, "Pixels of the frame down");
  app->add_option("--angle", options->angle, "Of the red lines from the y axis [degree]");
  app->add_option("--blur", options->blur, "Standard deviation of red, green and blue [px]");
  app->add_option("--noise", options->noise, "Standard deviation at full scale, fraction of it");
  app->add_option("--seed", options->seed, "Seed of scene and noise");
  app->add_option("-o,--output", options->output, "The TIFF; must not exist");
  app->add_option("--truth", options->truth, "The EXR with what is known; must not exist");
  app->add_option("--model", options->model,
                  "The unit whose scan it is, or that --usbip exports; default ls5000");
  app->add_option("--usbip", options->usbip,
                  "Export over USB/IP at tcp:127.0.0.1:3240, tcp:PORT or unix:/path");
}

}  // namespace reseau::cli
