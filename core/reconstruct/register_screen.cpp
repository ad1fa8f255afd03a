#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/reconstruct/live_registration.h"
#include "core/reconstruct/pattern_evidence.h"
#include "core/reconstruct/reconstruct.h"
#include "core/reconstruct/registration_summary.h"
#include "core/screen/cell_moments.h"
#include "core/screen/follow_screen.h"
#include "core/screen/lattice_search.h"
#include "core/screen/linear_rows.h"
#include "core/screen/screen_description.h"
#include "core/screen/screen_layout.h"

namespace reseau {
namespace {

// A map that leaves more than this has lost its way [px].
constexpr double kLargestResidualPx = 0.4;
constexpr int kSearchRows = 512;  // a réseau is looked for in blocks of so many lines
// More probable than not, or it is not found.
constexpr double kLeastConfidence = 0.5;
// Periods below this do not show three elements [px]; what a scan should give them.
constexpr double kLeastPeriodPx = 2.9, kSafePeriodPx = 3.2;
// A réseau this sure shows itself even where the resolution says that it cannot.
constexpr double kPlain = 0.97;
constexpr int kThoroughBlocks = 2;
// Film that bends within a large tile and is followed right claims 0.03 to 0.07 px rms over the
// frame; a seed of small tiles that misled under a blur of 3 px claimed 0.46 px and was 5 px off.
constexpr double kMostBentClaimPx = 0.2;
constexpr int kTaskRows = 32;  // a multiple of the lines of a cell

double usual_px(ScreenKind kind, double dpi) { return usual_sizes(kind).period_um.y * dpi / 25400; }

// The least resolution that shows a screen, in hundreds.
int dpi_for(ScreenKind kind) {
  return 100 * static_cast<int>(std::ceil(kSafePeriodPx / usual_px(kind, 100)));
}

std::string decimals(double value) {
  const auto hundredths = std::lround(100 * value);
  const std::string rest = std::to_string(std::abs(hundredths) % 100);
  return (hundredths < 0 ? "-" : "") + std::to_string(std::abs(hundredths) / 100) + "." +
         (rest.size() < 2 ? "0" : "") + rest;
}

class Tracker {
 public:
  Tracker(const LineSource& source, const RegisterOptions& options, const ProgressFn& progress,
          const std::stop_token& stop)
      : source_(source),
        options_(options),
        progress_(progress),
        stop_(stop),
        live_(source, options) {}

  Registration run() {
    const LineFormat& format = source_.format();
    const int height = format.n_lines;
    int next_search = 0;
    std::string reason = "No réseau was found: the picture is empty.", grey_reason;
    // Search block by block as lines arrive. A seed that leads nowhere is given up for the next.
    while (next_search < height) {
      int end = std::min(height, next_search + kSearchRows);
      if (height - end < kSearchRows / 2) end = height;
      const int have = wait_for(end);
      if (stop_.stop_requested()) return stopped();
      // The scan ended early: what there is, is all there is.
      if (have < end) end = have;
      if (end - next_search < 16) break;
      const int first = next_search, n = end - next_search;
      next_search = have < end ? height : end;
      // Film that bends within a large tile shows itself to small ones, and plainly.
      for (const int tile_px : {kLargestTilePx, kSmallestTilePx}) {
        const std::optional<LatticeSeed> seed = search(first, n, tile_px, reason);
        if (!seed) break;
        if (tile_px == kSmallestTilePx && (seed->explained < 0.5 || seed->foreign > 0.3)) break;
        // Whatever following it would show, it would not be believed.
        if (1 - doubt(*seed) <= kLeastConfidence) {
          keep_evidence(0.5 * (1 - doubt(*seed)) * seed->confidence, *seed);
          reason =
              "No réseau was found: a weak repeating pattern is there, but something else repeats "
              "more plainly.";
          continue;
        }
        const bool bends = tile_px == kSmallestTilePx;
        Registration result = track(*seed, bends);
        if (bends && result.found && result.uncertainty.rms_px() > kMostBentClaimPx) {
          result.found = false;
          result.confidence = std::min(result.confidence, 0.49);
          result.reason =
              "No réseau was found: a weak repeating pattern is there, but where it lies between "
              "the places that show it stays open.";
        }
        if (result.found || stop_.stop_requested()) return result;
        reason = result.reason;
        // What one channel does show is worth more than what another look at it does not.
        if (seed->grey && grey_reason.empty() && result.n_windows > 0) grey_reason = reason;
        if (result.too_coarse) return result;
        keep_evidence(result.confidence, *seed);
      }
      if (source_.committed() <= next_search) break;
    }
    Registration none = best_none_;
    none.screen = "none";
    none.reason = grey_reason.empty() ? reason : grey_reason;
    const double dpi = source_.format().x_dpi;
    none.too_coarse = dpi > 0 && usual_px(ScreenKind::kDufaycolor, dpi) < kLeastPeriodPx;
    if (none.too_coarse) {
      none.reason += " At " + std::to_string(std::lround(dpi)) +
                     " dpi most réseaux are too fine to be seen: scan at " +
                     std::to_string(dpi_for(ScreenKind::kDufaycolor)) + " dpi or more.";
    }
    return none;
  }

 private:
  // Until so many lines are there, or the end; snapshots are made on the way.
  int wait_for(int n_lines) {
    if (!options_.on_snapshot) return source_.wait_committed(n_lines, stop_);
    for (int next = seen_; next < n_lines;) {
      next = std::min(n_lines, next + kSnapshotLines);
      seen_ = source_.wait_committed(next, stop_);
      if (stop_.stop_requested() || seen_ < next) break;
      live_.advance(seen_);
      next = std::max(next, std::min(seen_, n_lines));
    }
    return seen_;
  }

  static Registration stopped() {
    Registration result;
    result.screen = "none";
    result.reason = "Registration was stopped before the last line.";
    return result;
  }

  // Finds a seed in a block of lines; without infrared also the weights that make silver of RGB.
  std::optional<LatticeSeed> search(int first, int n, int tile_px, std::string& reason) {
    LinearReader reader(source_, options_.tone);
    if (options_.allow_grey && !reader.grey()) grey_ = grey_ || all_alike(first, n);
    if (grey_) reader.set_grey();
    LinearRows rows;
    reader.read(first, n, rows);
    // A réseau fills the film: where some blocks with light show none, fewer places of the others
    // are looked at.
    const LatticeSearch found =
        find_lattice(rows, reader.has_infrared(), tile_px,
                     n_lit_blocks_ < kThoroughBlocks ? kMostTiles : kFewTiles);
    if (!found.dark && tile_px == kLargestTilePx) ++n_lit_blocks_;
    if (!found.found) {
      reason = found.reason;
      keep_evidence(0.5 * found.seed.confidence * found.seed.explained, found.seed);
      return std::nullopt;
    }
    if (!found.seed.grey && !silver_weights(found.seed.response, weights_)) {
      reason =
          "No réseau was found: a repeating pattern is there, but its elements cannot be told "
          "apart by colour.";
      return std::nullopt;
    }
    return found.seed;
  }

  // Whether red, green and blue are the same in these lines: a grey scan in the form of a colour
  // one.
  [[nodiscard]] bool all_alike(int first, int n) const {
    const LineFormat& format = source_.format();
    const auto width = static_cast<std::size_t>(format.width_px);
    std::vector<std::uint16_t> line(format.samples_per_line());
    constexpr int kEveryLine = 8;
    for (int y = first; y < first + n; y += kEveryLine) {
      source_.read(y, 1, line);
      const auto plane = [&](Channel channel) {
        return line.begin() + static_cast<std::ptrdiff_t>(
                                  static_cast<std::size_t>(format.plane_of(channel)) * width);
      };
      const auto green = plane(Channel::kGreen);
      for (const Channel channel : {Channel::kRed, Channel::kBlue}) {
        if (!std::equal(green, green + format.width_px, plane(channel))) return false;
      }
    }
    return true;
  }

  // What came nearest to a réseau where none was found.
  void keep_evidence(double confidence, const LatticeSeed& seed) {
    const double screen = std::clamp(confidence, 0.0, 0.49);
    if (!(screen > best_none_.runner_up_probability)) return;
    best_none_.runner_up = name_screen({seed.layout, seed.grey ? -1 : seed.special_color,
                                        seed.explained, seed.other_explained, 0})
                               .front()
                               .name;
    best_none_.runner_up_probability = screen;
    best_none_.none_probability = best_none_.screen_probability = 1 - screen;
    best_none_.explained = seed.explained;
  }

  Registration track(const LatticeSeed& seed, bool bends) {
    const LineFormat& format = source_.format();
    CellGrid cells(format.width_px, format.n_lines, seed.carriers, bends ? kSmallCells : CellSize{},
                   bends ? 1 : keep_every_for(format.width_px, format.n_lines, false));
    int done = 0;
    while (done < format.n_lines) {
      const int want = std::min(format.n_lines, done + kTaskRows);
      int have = wait_for(want);
      if (stop_.stop_requested()) return stopped();
      const bool ended = have < want;
      // Whole bands only, but for the end of the frame.
      int end = have == format.n_lines || ended ? have : have / kTaskRows * kTaskRows;
      end = std::min(end, done + 64 * kTaskRows);
      if (ended) end = have / kTaskRows * kTaskRows;
      if (end > done) accumulate(cells, done, end);
      done = std::max(done, end);
      if (progress_) progress_(0.9 * done / format.n_lines);
      if (ended) break;
    }
    return finish(seed, cells);
  }

  void accumulate(CellGrid& cells, int begin, int end) {
    const int n_tasks = (end - begin + kTaskRows - 1) / kTaskRows;
    parallel_for(n_tasks, [&](int task) {
      LinearReader reader(source_, options_.tone);
      if (grey_) reader.set_grey();
      reader.set_silver_from_rgb(weights_);
      LinearRows rows;
      const int first = begin + task * kTaskRows;
      reader.read(first, std::min(kTaskRows, end - first), rows);
      cells.accumulate(rows);
    });
  }

  Registration finish(const LatticeSeed& seed, const CellGrid& cells) {
    Registration result;
    result.screen = "none";
    FollowedScreen followed = follow_screen(cells, seed, options_.check_left_out);
    if (followed.needs_smaller_cells) {
      CellGrid small(cells.width_px(), cells.height_px(), seed.carriers, kSmallCells);
      accumulate(small, 0, source_.committed());
      FollowedScreen again = follow_screen(small, seed, options_.check_left_out);
      if (again.fit.usable && again.coverage > followed.coverage - 0.1 &&
          (!followed.fit.usable || again.fit.residual_px < followed.fit.residual_px ||
           again.coverage > followed.coverage + 0.1)) {
        followed = std::move(again);
      }
    }
    if (followed.fit.usable && followed.cell_px < CellSize{}.width) {
      for (int pass = 0; pass < kMostPassesAlong && !followed.settled; ++pass) {
        CellGrid along(cells.width_px(), cells.height_px(), seed.carriers, followed.fit.map,
                       kSmallCells);
        accumulate(along, 0, source_.committed());
        followed = follow_along(along, seed, followed, options_.check_left_out);
      }
    }
    if (!followed.fit.usable) {
      result.reason =
          "No réseau was found: a repeating pattern was seen in one place but could not be "
          "followed from there.";
      return result;
    }
    fill(result, seed, followed);
    return result;
  }

  void fill(Registration& result, const LatticeSeed& seed, const FollowedScreen& followed) const {
    const LineFormat& format = source_.format();
    const MapFit& fit = followed.fit;
    const double coverage = followed.coverage;
    result.map =
        options_.exchange ? fit.map.shifted(layout_sites(seed.layout).pair_shift) : fit.map;
    result.lines_alone = seed.layout == ScreenLayout::kLines;
    result.residual_px = fit.residual_px;
    result.n_windows = fit.n_used;
    result.n_outliers = fit.n_outliers;
    const Mat2 mean = describe_lattice(result, format, format.n_lines);
    result.uncertainty =
        MapUncertainty(fit.map, fit.placed, fit.error_model, format.width_px, format.n_lines);
    result.left_out_px = followed.left_out_px;
    describe_certainty(result, mean);
    result.explained = seed.explained;
    result.response = seed.response;
    result.silver_from_rgb = weights_;
    const double worst_period = std::min(result.period_px[0], result.period_px[1]);
    const double tightness = std::exp(-std::pow(fit.residual_px / (0.12 * worst_period), 2));
    result.confidence =
        (1 - doubt(seed)) * seed.confidence * tightness * (-std::expm1(-coverage / 0.15));
    const std::string coarse = why_too_coarse(seed, worst_period, result.confidence);
    result.too_coarse = !coarse.empty();
    result.found = result.confidence > kLeastConfidence && fit.n_used >= 6 &&
                   fit.residual_px < kLargestResidualPx && coarse.empty() &&
                   !folds(fit.map, mean, format);
    const std::string dim = result.found ? why_too_dim(seed, result) : std::string();
    result.found = result.found && dim.empty();
    if (!result.found) result.confidence = std::min(result.confidence, 0.49);
    result.none_probability = 1 - std::min(result.confidence, 1 - 1e-6);
    if (result.found) {
      std::vector<PatternEvidence> patterns;
      if (!seed.grey && !result.lines_alone)
        patterns = patterns_of(result, kinds_of(seed.layout, seed.special_color));
      describe_names(result, seed, patterns);
      if (!seed.grey && is_dufaycolor(screen_kind(result.screen)))
        describe_printing(result, patterns_of(result, dufaycolor_printings()));
      take_by_hand(result, seed);
    } else if (!coarse.empty()) {
      result.reason = coarse;
    } else if (!dim.empty()) {
      result.reason = dim;
    } else {
      result.reason =
          "No réseau was found: a weak repeating pattern is there, but it does not hold together "
          "over the picture.";
    }
  }

  [[nodiscard]] std::vector<PatternEvidence> patterns_of(
      const Registration& result, const std::vector<ScreenKind>& kinds) const {
    return pattern_evidence(source_, options_.tone, result.map,
                            std::max(result.period_px[0], result.period_px[1]), kinds);
  }

  // Whether the two like elements differ by some part of what all three do.
  [[nodiscard]] static bool pair_shows(const LatticeSeed& seed) {
    constexpr double kLeastPairShare = 0.15;
    const std::array<int, 3> colors = site_colors(seed.layout, seed.special_color);
    const LayoutSites sites = layout_sites(seed.layout);
    const auto light = [&](int site) {
      return seed.response[static_cast<std::size_t>(colors[static_cast<std::size_t>(site)])][0];
    };
    const auto [least, most] = std::minmax({light(0), light(1), light(2)});
    return std::abs(light(sites.pair[0]) - light(sites.pair[1])) > kLeastPairShare * (most - least);
  }

  // A sentence where one channel alone does not show the elements plainly. Green film followed
  // right explains 0.58 and more, claims 0.05 px at most and misses what was left out by 0.06 px
  // (wrong maps of red and blue: 0.12 px and more); in red, where the squares between red lines are
  // alike, u is lost, and in infrared only saturated places show anything.
  [[nodiscard]] static std::string why_too_dim(const LatticeSeed& seed,
                                               const Registration& result) {
    constexpr double kPlainInGrey = 0.45, kLeastCertainPx = 0.1, kLargestLeftOutPx = 0.1;
    if (!seed.grey) return {};
    if (seed.explained < kPlainInGrey) {
      return "No réseau was found: a pattern repeats every " + decimals(result.period_px[1]) +
             " px, but this channel does not show it plainly enough to be followed. Scan in "
             "colour.";
    }
    const std::optional<Vec2>& missed = result.left_out_px;
    const bool holds = !missed || std::max(missed->x, missed->y) < kLargestLeftOutPx;
    if (holds && result.uncertainty.rms_px() < kLeastCertainPx && pair_shows(seed)) return {};
    return "No réseau was found: lines repeat every " + decimals(result.period_px[1]) + " px at " +
           decimals(result.angle_deg) +
           " degrees, but this channel does not show where the elements along them lie. Scan in "
           "colour, or give the green channel.";
  }

  // What the person knows better.
  void take_by_hand(Registration& result, const LatticeSeed& seed) const {
    if (seed.grey) result.identity = "unknown";
    if (options_.exchange) {
      const std::array<int, 3> colors =
          site_colors(seed.layout, seed.grey ? 0 : seed.special_color);
      const LayoutSites sites = layout_sites(seed.layout);
      const auto color = [&](std::size_t k) {
        return static_cast<std::size_t>(colors[static_cast<std::size_t>(sites.pair[k])]);
      };
      std::swap(result.response[color(0)], result.response[color(1)]);
      result.identity = "given";
    }
    if (options_.screen.empty()) return;
    const std::string found = result.screen;
    const double probability = result.screen_probability;
    const ScreenKind kind = screen_kind(options_.screen);
    result.screen = screen_names()[static_cast<std::size_t>(kind)].name;
    result.identity = "given";
    if (layout_of(kind) != seed.layout) {
      result.found = false;
      result.reason = "The pattern of this scan is not that of " + result.screen +
                      ": it looks like " + found + ". Leave out the screen, or give another.";
      result.screen = "none";
      return;
    }
    result.screen_probability = 1 - result.none_probability;
    if (found != result.screen) {
      result.runner_up = found;
      result.runner_up_probability = probability;
    }
  }

  // A sentence where a scan is too coarse for its réseau: the elements of a period are not all
  // sampled, or what repeats is the beat of a réseau with the pixels. Of the latter the resolution
  // must tell, which a file may state wrongly: what shows its elements plainly is believed.
  [[nodiscard]] std::string why_too_coarse(const LatticeSeed& seed, double period_px,
                                           double confidence) const {
    const double dpi = source_.format().x_dpi;
    const ScreenGuess guess = name_screen({seed.layout, seed.grey ? -1 : seed.special_color,
                                           seed.explained, seed.other_explained, 0})
                                  .front();
    const ScreenKind kind = screen_kind(guess.name);
    const double expected_px = dpi > 0 ? usual_px(kind, dpi) : kLeastPeriodPx;
    const bool beats = expected_px < kLeastPeriodPx && period_px > 1.5 * expected_px;
    if (period_px >= kLeastPeriodPx && !(beats && confidence < kPlain)) return {};
    // What a period seems to measure may be a beat itself: the finest réseau decides.
    return "No réseau was found: this scan is too coarse for one. Scan at " +
           std::to_string(std::max(dpi_for(kind), dpi_for(ScreenKind::kDufaycolor))) +
           " dpi or more.";
  }

  // A lattice that explains little while something else repeats as plainly is a halftone, a fabric,
  // a texture. Simulated films, blurred, noisy or faded, show 0 to 0.5 of foreign power; pictures
  // without a réseau that got so far 0.95 and more, and at most 0.13 explained.
  static double doubt(const LatticeSeed& seed) {
    return 1 / (1 + std::exp(-12 * (seed.foreign - 0.75))) /
           (1 + std::exp(40 * (seed.explained - 0.2)));
  }

  const LineSource& source_;
  const RegisterOptions& options_;
  const ProgressFn& progress_;
  const std::stop_token& stop_;
  std::array<double, 3> weights_{1.0 / 3, 1.0 / 3, 1.0 / 3};
  Registration best_none_;
  LiveRegistration live_;
  int seen_ = 0, n_lit_blocks_ = 0;
  bool grey_ = source_.format().plane_of(Channel::kRed) < 0;
};

}  // namespace

Registration register_screen(const LineSource& source, const RegisterOptions& options,
                             const ProgressFn& progress, const std::stop_token& stop) {
  const LineFormat& format = source.format();
  if (!options.screen.empty()) static_cast<void>(screen_kind(options.screen));
  for (const Channel channel : {Channel::kRed, Channel::kGreen, Channel::kBlue}) {
    if (format.plane_of(channel) < 0 && !options.allow_grey) {
      throw InputError(
          "The scan has no red, green and blue channels; a réseau cannot be told apart in it.");
    }
  }
  const auto start = std::chrono::steady_clock::now();
  Registration result;
  with_threads(options.n_threads, [&] { result = Tracker(source, options, progress, stop).run(); });
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (progress) progress(1.0);
  return result;
}

}  // namespace reseau
