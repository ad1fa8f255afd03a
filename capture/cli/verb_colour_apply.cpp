#include <memory>
#include <string>

#include "capture/cli/color_choice.h"
#include "capture/cli/recolor_run.h"
#include "capture/cli/verb_colour.h"

namespace reseau::cli {

namespace {

struct ColourApplyArguments {
  std::string file;
  std::string output = ".";
  std::string neutral;
  std::string view_gamut = "clip";
  ColorChoice color;
  int n_threads = 0;
  bool no_view = false;
};

ExitCode run(const ColourApplyArguments& options, Work& work) {
  RecolorRequest request;
  request.verb = "colour apply";
  request.file = options.file;
  request.output = options.output;
  request.n_threads = options.n_threads;
  request.view = !options.no_view;
  as_failure(Doing::kReadingOptions, [&] {
    request.view_gamut = parse_view_gamut(options.view_gamut);
    if (!options.neutral.empty()) request.neutral = parse_neutral_area(options.neutral);
    request.color = options.color.resolve(work.reporter);
  });
  return run_recolor(request, work);
}

}  // namespace

void add_colour_apply(Program& program, CLI::App* group) {
  auto options = std::make_shared<ColourApplyArguments>();
  CLI::App* app = program.add_verb_below(
      group, "apply",
      "Gives a reconstruction other colours, without doing anything else again. FILE is an EXR "
      "that\n'scan' or 'reconstruct' wrote, in any space; it says how its colours were made. "
      "Writes NAME.exr,\nNAME.json and the view copies to the folder; refuses when one exists.",
      "reseau colour apply pictures/box3_07.exr --primaries neblette-1952 -o neblette\n"
      "reseau colour apply box3_07.exr --light 3200K --space aces-ap0 --no-view -o graded",
      [options](Work& work) { return run(*options, work); });
  app->add_option("FILE", options->file, "A reconstruction: an EXR of this program")->required();
  app->add_option("-o,--output", options->output, "Folder for the files; default here")
      ->group("Files");
  options->color.add_to(*app);
  app->add_option("--neutral", options->neutral,
                  "Make neutral: auto (the picture on average), or an area in pixels as x,y,w,h")
      ->group("Picture");
  app->add_option("--view-gamut", options->view_gamut,
                  "Colours outside sRGB in the view copies: clip (default) or perceptual")
      ->group("Picture");
  app->add_option("--threads", options->n_threads, "Threads; 0 = all cores (default)")
      ->check(CLI::Range(0, 1024))
      ->group("Picture");
  app->add_flag("--no-view", options->no_view, "Only the EXR, no PNG and TIFF copies for viewing")
      ->group("Picture");
}

}  // namespace reseau::cli
