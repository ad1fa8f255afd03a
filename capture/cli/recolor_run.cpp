#include "capture/cli/recolor_run.h"

#include <array>
#include <filesystem>
#include <fstream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "capture/cli/develop_choice.h"
#include "capture/cli/event_log.h"
#include "capture/color/color_record.h"
#include "capture/session/json_number.h"
#include "capture/session/receipt.h"
#include "capture/session/recolor.h"
#include "capture/store/sha256.h"

namespace reseau::cli {

namespace {

using nlohmann::ordered_json;

ordered_json receipt_of(const RecolorRequest& request, const Recolored& done,
                        const PictureNames& names) {
  ordered_json settings = color_to_json(done.color);
  if (request.neutral) settings["neutral"] = request.neutral->text();
  settings["view_gamut"] = request.view_gamut == ViewGamut::kClip ? "clip" : "perceptual";
  settings["threads"] = request.n_threads;
  ordered_json timings = ordered_json::object();
  put_number(timings, "reading_s", done.seconds_reading);
  put_number(timings, "colour_s", done.seconds_color);
  put_number(timings, "writing_s", done.seconds_writing);
  put_number(timings, "all_s", done.seconds);
  ordered_json files = ordered_json::array();
  const auto add = [&files](const char* role, const std::filesystem::path& path,
                            const std::string& sha256) {
    files.push_back({{"role", role},
                     {"name", path.filename().string()},
                     {"bytes", std::filesystem::file_size(path)},
                     {"sha256", sha256}});
  };
  add("reconstruction", names.exr, done.picture.exr_sha256);
  if (request.view) {
    add("view", names.png, sha256_of_file(names.png));
    add("view16", names.view_tiff, sha256_of_file(names.view_tiff));
  }
  return {{"schema", "reseau-receipt/1"},
          {"program", {{"name", "reseau"}, {"version", RESEAU_VERSION}}},
          {"verb", request.verb},
          {"written_at_utc", utc_now(false)},
          {"recoloured_from", std::filesystem::path(request.file).filename().string()},
          {"output_from_picture", matrix_json(done.output_from_picture)},
          {"settings", settings},
          {"timings", timings},
          {"files", files},
          {"notes",
           {"Only the colours were made anew; all else is said by the receipt of the picture that "
            "they were made from."}}};
}

}  // namespace

bool is_exr(const std::string& file) {
  constexpr std::array<char, 4> kMagic{0x76, 0x2F, 0x31, 0x01};
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(file, ignored)) return false;
  std::array<char, 4> head{};
  std::ifstream stream(file, std::ios::binary);
  stream.read(head.data(), head.size());
  return stream.gcount() == 4 && head == kMagic;
}

ExitCode run_recolor(const RecolorRequest& request, Work& work) {
  Reporter& reporter = work.reporter;
  const std::filesystem::path directory(request.output);
  const PictureNames names =
      picture_names(directory, std::filesystem::path(request.file).stem().string());
  refuse_existing(names.exr);
  refuse_existing(names.receipt);
  if (request.view) {
    refuse_existing(names.png);
    refuse_existing(names.view_tiff);
  }
  RecolorOptions options;
  options.source = request.file;
  options.color = request.color;
  options.neutral = request.neutral;
  options.view_gamut = request.view_gamut;
  options.n_threads = request.n_threads;
  options.exr = names.exr;
  if (request.view) {
    options.png = names.png;
    options.tiff = names.view_tiff;
  }
  // What cannot be read is refused before a folder is made.
  as_failure(Doing::kReadingInput, [&] {
    static_cast<void>(output_from_process_of(ExrReader(request.file), request.file));
  });
  prepare_directory(directory);
  reporter.phase("colour", request.color.primaries.name);
  const Recolored done = as_failure(Doing::kReadingInput, [&] {
    return recolor(
        options,
        [&reporter](double fraction) {
          reporter.progress("colour", {100 * fraction, 100, "", 0});
        },
        work.signals.stop());
  });
  if (!done.written) {
    reporter.warning("Stopped; nothing was written.");
    return kExitCancelled;
  }
  write_json_file(receipt_of(request, done, names), names.receipt);
  reporter.event("file", {{"role", "reconstruction"}, {"path", names.exr.string()}});
  reporter.event("file", {{"role", "receipt"}, {"path", names.receipt.string()}});
  reporter.say(fmt::format(
      "Time      {:.2f} s: {:.2f} s to write, {:.2f} s for the colours, and beside that "
      "{:.2f} s to read",
      done.seconds, done.seconds_writing, done.seconds_color, done.seconds_reading));
  if (request.view) reporter.say("To look at  " + names.png.string());
  reporter.result_line(names.exr.string());
  return kExitOk;
}

}  // namespace reseau::cli
