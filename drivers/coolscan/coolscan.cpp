#include "drivers/coolscan/coolscan.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/check.h"
#include "core/base/error.h"
#include "drivers/coolscan/frame_finder.h"
#include "drivers/coolscan/metering_pass.h"
#include "drivers/coolscan/window.h"

namespace reseau::coolscan {
namespace {

using namespace std::chrono_literals;

// 7 s on an LS-50, 26 s on an LS-5000.
constexpr Duration kFocusTimeout = 180s;
// 14 to 57 s were seen.
constexpr Duration kEjectTimeout = 180s;

}  // namespace

Coolscan::Coolscan(ScsiLink link, std::shared_ptr<Clock> clock, OpenAs open_as)
    : clock_(std::move(clock)),
      link_(std::move(link)),
      unit_(*link_.device, *clock_),
      open_as_(std::move(open_as)) {
  unit_.annotate("open");
  const Model* const model = identify();
  if (model == nullptr) {
    throw DeviceError(DeviceError::Kind::kProtocol,
                      "This is not a scanner that the program knows: \"" +
                          description_.inquiry.vendor + " " + description_.inquiry.product + "\".",
                      "INQUIRY");
  }
  description_.infrared = model->infrared;
  description_.errata = model->errata;
  unit_.apply(model->errata);
  description_.serial = link_.serial;
  description_.link = link_.description;
  read_film_state();
  unit_.reserve();
  if (description_.addresses.max_dpi > 0) {
    unit_.set_units_per_inch(description_.addresses.max_dpi);
  }
  read_curves();
}

const Model* Coolscan::identify() {
  constexpr int kAttempts = 3;
  for (int attempt = 1;; ++attempt) {
    try {
      description_.inquiry = parse_standard_inquiry(unit_.read_inquiry());
      const Model* const model = model_by_product(description_.inquiry.product);
      if (model != nullptr || attempt == kAttempts) return model;
    } catch (const DeviceError& error) {
      // A unit answers this command in every state.
      const bool answered = error.kind() != DeviceError::Kind::kTimeout &&
                            error.kind() != DeviceError::Kind::kDisconnected;
      if (!answered || attempt == kAttempts) throw;
    }
    // What a program that died left in the pipe comes as the answer to the first command.
    link_.device->resynchronise();
  }
}

Coolscan::~Coolscan() {
  stop();
  try {
    unit_.annotate("close");
    unit_.release();
  } catch (const std::exception&) {
    // Nobody is left to tell; an unplugged unit needs no release.
  }
}

void Coolscan::read_film_state() {
  description_.film_present = unit_.wait_ready(kColdStart) == Unit::Ready::kGood;
  do {
    describe_unit();
  } while (unit_.take_attention());
  capabilities_ = capabilities_of(description_);
}

void Coolscan::describe_unit() {
  const std::vector<std::uint8_t> pages =
      parse_page_list(unit_.read_page(kPageList).value_or(Bytes{}));
  const auto listed = [&](std::uint8_t code) {
    return std::find(pages.begin(), pages.end(), code) != pages.end();
  };
  const auto page = [&](std::uint8_t code) -> Bytes {
    // A unit of the first generation may have no list.
    if (!listed(code) && !(pages.empty() && code == kAddresses)) return {};
    return unit_.read_page(code).value_or(Bytes{});
  };
  description_.addresses = parse_addresses(page(kAddresses));
  description_.windows = parse_window_abilities(page(kWindowAbilities));
  description_.duties = parse_duties(page(kDuties));
  if (description_.errata.only_addresses) {
    // Without page E1: focus by point and by number, eject.
    description_.duties.operations = {0x03, 0, 0x01, 0, 0x03, 0x01, 0, 0};
    description_.windows.interleavings = static_cast<std::uint8_t>(Interleaving::kLine);
  }
  const AddressPage& a = description_.addresses;
  description_.adapter = parse_name_page(page(kAdapterName));
  const auto holder_page = static_cast<std::uint8_t>(a.holder_id);
  if (listed(holder_page) && holder_page >= 0x10) {
    const std::string holder = parse_name_page(page(holder_page));
    if (!holder.empty()) description_.adapter += (description_.adapter.empty() ? "" : " ") + holder;
  }
  unit_.bound({a.max_width_px, a.x_end_px(), a.y_origin_min_px,
               a.y_origin_max_px > 0 ? a.y_origin_max_px + 1 : 0, a.focus_min, a.focus_max});

  description_.holder =
      a.has_frame_page ? parse_frame_page(page(kFrames)) : std::vector<FrameRectangle>{};
  description_.strip.clear();
  description_.frames_found = false;
  if (description_.film_present && description_.duties.frame_table) {
    const std::optional<Bytes> table = unit_.read_data(DataType::kFrameTable, Colour::kRed);
    if (table) description_.strip = parse_frame_table(*table);
  }
  table_in_unit_ = description_.strip;
}

void Coolscan::read_curves() {
  if (!description_.duties.ccd_curves) return;
  // An LS-9000 answers this page although its list does not name it.
  const std::optional<CurvePage> page =
      parse_curve_page(unit_.read_page(kCurves).value_or(Bytes{}));
  if (!page) return;
  const int lines = sensor_lines(description_.addresses, description_.windows);
  for (std::size_t i = 0; i < kColours.size(); ++i) {
    const std::optional<Bytes> data = unit_.read_data(DataType::kCcdCurves, kColours[i]);
    if (data) curves_[i] = CcdCurves::parse(*data, *page, lines);
  }
}

Negotiated Coolscan::negotiate(const ScanRequest& request) const {
  return coolscan::negotiate(request, description_);
}

void Coolscan::enter(ScanObserver& observer, ScanPhase phase, const std::string& detail) {
  unit_.annotate(detail);
  observer.phase(phase, detail);
}

bool Coolscan::start(const ScanPlan& plan, ScanObserver& observer, const std::stop_token& stop) {
  CHECK(!pass_);
  try {
    if (prepare(plan, observer, stop)) return true;
  } catch (...) {
    this->stop();
    throw;
  }
  this->stop();
  return false;
}

bool Coolscan::prepare(const ScanPlan& plan, ScanObserver& observer, const std::stop_token& stop) {
  enter(observer, ScanPhase::kWarmUp, "waiting for the scanner");
  const Unit::Ready ready = unit_.wait_ready(kColdStart, stop);
  if (ready == Unit::Ready::kStopped) return false;
  if (ready == Unit::Ready::kNoMedium) {
    throw sense_error(unit_.last_sense(), test_unit_ready().describe());
  }
  if (unit_.take_attention() || !description_.film_present) read_film_state();
  if (!still_fits(plan, description_)) {
    throw DeviceError(DeviceError::Kind::kRefused,
                      "The film or the adapter was changed after the scan was prepared, and the "
                      "scan no longer fits. Start again.",
                      plan.describe());
  }

  context_ = begin_context(capabilities_, open_as_);
  constexpr int kStripHolder = 0x15;
  const std::string_view warning = description_.errata.frame_warning;
  if (!warning.empty() && description_.addresses.holder_id == kStripHolder) {
    observer.note(std::string(warning));
  }
  send_frames(plan);
  send_tables(plan.infrared);
  if (stop.stop_requested()) return false;
  focus(plan, observer);
  if (stop.stop_requested()) return false;
  const std::optional<Exposures> exposures = settle_exposures(plan, observer, stop);
  if (!exposures || stop.stop_requested()) return false;

  enter(observer, ScanPhase::kScan, "scan");
  format_ = plan.format;
  next_line_ = 0;
  overview_ = plan.overview;
  overview_samples_.clear();
  pass_.emplace(unit_, pass_of(plan, description_.addresses, *exposures), pass_rules(), curves_);
  return true;
}

PassRules Coolscan::pass_rules() const {
  return {link_.packet_bytes, !description_.errata.odd_colours,
          link_.packet_bytes > 0 || description_.addresses.whole_lines};
}

void Coolscan::send_frames(const ScanPlan& plan) {
  if (plan.overview) return;
  const DutyPage& duties = description_.duties;
  const auto index = static_cast<std::size_t>(plan.frame - 1);
  if (duties.set_frame_table && index < description_.strip.size()) {
    std::vector<FrameRecord> table = description_.strip;
    if (plan.frame_offset_px != 0) {
      table[index] = moved_on_film(description_, table[index], plan.frame_offset_px);
    }
    if (table == table_in_unit_) return;
    unit_.annotate("frames");
    unit_.send_data(DataType::kFrameTable, Colour::kDefault, frame_table_data(table));
    table_in_unit_ = std::move(table);
  } else if (duties.frame_rectangles) {
    // Without it every window would let the stage go home first.
    std::vector<FrameRectangle> frames = frames_of(description_);
    frames.at(index).top_px += plan.frame_offset_px;
    unit_.annotate("frames");
    unit_.send_data(DataType::kFrameRectangles, Colour::kDefault, frame_rectangle_data(frames));
  }
}

void Coolscan::finish_overview() {
  overview_ = false;
  const AddressPage& a = description_.addresses;
  const bool strip = a.film_addresses && description_.duties.set_frame_table;
  const auto width = static_cast<std::size_t>(format_.width_px);
  const std::vector<std::uint16_t> samples = std::exchange(overview_samples_, {});
  // The unit has something to say: it counted the frames.
  unit_.wait_ready(kColdStart);
  if (unit_.take_attention()) read_film_state();
  if (!strip || width == 0) return;

  const Overview overview{samples, format_.width_px,
                          static_cast<int>(samples.size() / (3 * width))};
  const double line_px = a.max_dpi / format_.y_dpi;
  const std::vector<FoundFrame> found =
      find_frames(overview, a.max_height_px / line_px, capabilities_.n_frames);
  const std::optional<Bytes> counts =
      description_.duties.perforations ? unit_.read_data(DataType::kPerforations, Colour::kDefault)
                                       : std::nullopt;
  const std::optional<std::vector<int>> places =
      counts ? parse_perforations(*counts, a.max_dpi) : std::nullopt;
  std::vector<FrameRecord> table;
  bool any = false;
  for (const FoundFrame& frame : found) {
    double top_px = frame.top_line * line_px;
    const auto line = static_cast<std::size_t>(std::max(frame.top_line, 0.0));
    if (places && line < places->size()) {
      top_px = (*places)[line] + (frame.top_line - std::floor(frame.top_line)) * line_px;
    }
    table.push_back(moved_on_film(description_, {}, static_cast<int>(std::lround(top_px))));
    any = any || frame.on_the_film;
  }
  if (!any) return;
  description_.strip = std::move(table);
  description_.frames_found = true;
  description_.addresses.frames_present = static_cast<int>(description_.strip.size());
  capabilities_ = capabilities_of(description_);
}

void Coolscan::eject(ScanObserver& observer) {
  CHECK(!pass_);
  if (!capabilities_.can_eject) return Scanner::eject(observer);
  enter(observer, ScanPhase::kLoad, "ejecting the film");
  // Accepted before it happens, and never to be sent twice.
  const bool begun = unit_.begin(Operation::kUnload, {});
  if (!begun || !unit_.wait_for_film(false, kEjectTimeout)) {
    throw DeviceError(DeviceError::Kind::kHardware,
                      "The scanner accepted the command to eject, but the film is still in it. Do "
                      "not pull: switch the scanner off, wait ten seconds and switch it on again.",
                      "D0: film still present");
  }
  read_film_state();
}

void Coolscan::load(ScanObserver& observer) {
  CHECK(!pass_);
  if (!capabilities_.can_load) return Scanner::load(observer);
  enter(observer, ScanPhase::kLoad, "loading film");
  (void)unit_.begin(Operation::kLoad, {});
  if (!unit_.wait_for_film(true, kEjectTimeout)) {
    throw sense_error(unit_.last_sense(), test_unit_ready().describe());
  }
  read_film_state();
}

void Coolscan::send_tables(bool infrared) {
  const DutyPage& duties = description_.duties;
  if (!duties.look_up_table || duties.table_in_bits < 1 || duties.table_in_bits > 16) return;
  // The table survives between programs; another one may have left a curve.
  const Bytes table =
      identity_table(duties.table_in_bits, std::clamp(duties.table_out_bits, 1, 16));
  for (const Colour colour : kColours) {
    if (colour != Colour::kInfrared || infrared) unit_.send_table(colour, table);
  }
}

void Coolscan::focus(const ScanPlan& plan, ScanObserver& observer) {
  if (plan.focus.mode == FocusRequest::Mode::kPosition) {
    enter(observer, ScanPhase::kFocus, "moving the focus");
    unit_.perform(Operation::kMoveFocus, {static_cast<std::uint32_t>(plan.focus.position), 0},
                  kFocusTimeout);
  } else if (plan.focus.mode == FocusRequest::Mode::kAuto) {
    enter(observer, ScanPhase::kFocus, "autofocus");
    const Unit::Ready ready = unit_.perform(
        Operation::kAutofocus,
        {static_cast<std::uint32_t>(plan.focus_x_px), static_cast<std::uint32_t>(plan.focus_y_px)},
        kFocusTimeout);
    if (ready == Unit::Ready::kOutOfFocus) {
      observer.note(
          "Autofocus found no detail at that point of the film; the scan goes on with the focus as "
          "it stands. Choose a point with detail, or give the focus position as a number. "
          "[01/61/02]");
      unit_.wait_ready(kFocusTimeout);
    }
  }
  context_.focus_position = static_cast<int>(unit_.get_parameters(Operation::kMoveFocus).first);
}

ReadStatus Coolscan::read(LineBlock& block, Duration /*timeout*/) {
  if (!pass_) return ReadStatus::kEndOfScan;
  const int n = pass_->read(block.samples);
  if (n == 0) {
    pass_.reset();
    if (overview_) finish_overview();
    return ReadStatus::kEndOfScan;
  }
  block.first_line = next_line_;
  block.n_lines = n;
  block.width_px = format_.width_px;
  block.n_channels = format_.n_channels();
  next_line_ += n;
  if (overview_) {
    const std::span<const std::uint16_t> lines = block.used();
    overview_samples_.insert(overview_samples_.end(), lines.begin(), lines.end());
  }
  return ReadStatus::kLines;
}

void Coolscan::stop() noexcept {
  pass_.reset();
  overview_ = false;
  try {
    if (unit_.scan_open()) unit_.annotate("stop");
    unit_.abort_open_scan();
  } catch (const std::exception&) {
    // The unit is gone or silent; the next command tells the person.
  }
}

}  // namespace reseau::coolscan
