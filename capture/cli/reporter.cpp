#include "capture/cli/reporter.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace reseau::cli {

using namespace std::chrono_literals;

std::string human_seconds(double seconds) {
  const auto whole = static_cast<long>(std::ceil(std::max(0.0, seconds)));
  if (whole < 60) return fmt::format("{} s", whole);
  if (whole < 3600) return fmt::format("{} min {:02} s", whole / 60, whole % 60);
  return fmt::format("{} h {:02} min", whole / 3600, whole % 3600 / 60);
}

std::string human_bytes(double bytes) {
  if (bytes < 1e6) return fmt::format("{:.1f} kB", bytes / 1e3);
  if (bytes < 1e9) return fmt::format("{:.1f} MB", bytes / 1e6);
  return fmt::format("{:.2f} GB", bytes / 1e9);
}

std::optional<double> eta_seconds(double done, double total, double elapsed_s) {
  // Half a second or half a per cent is too little to extrapolate from.
  if (!(done > 0) || !(total > 0) || elapsed_s < 0.5 || done < 0.005 * total) return std::nullopt;
  return std::max(0.0, elapsed_s * (total - done) / done);
}

namespace {

nlohmann::ordered_json error_fields(const Failure& failure) {
  nlohmann::ordered_json fields = {{"code", exit_word(failure.code())},
                                   {"exit", int{failure.code()}},
                                   {"message", failure.what()}};
  if (failure.remedy().empty()) {
    fields["try"] = nullptr;
  } else {
    fields["try"] = failure.remedy();
  }
  if (!failure.detail().empty()) fields["detail"] = failure.detail();
  return fields;
}

}  // namespace

Reporter::Reporter(const ReportOptions& options, const std::string& verb, std::ostream& out,
                   std::ostream& talk, bool terminal, Now now)
    : out_(out),
      talk_(talk),
      json_(options.json || options.json_result),
      quiet_(options.quiet),
      bar_(terminal && !options.plain),
      color_(options.color == ReportOptions::Color::kAlways ||
             (options.color == ReportOptions::Color::kAuto && terminal && !options.plain)),
      now_(now) {
  if (options.json) events_ = std::make_unique<EventLog>(out, verb);
}

Reporter::~Reporter() {
  const std::lock_guard lock(mutex_);
  clear_bar();
}

void Reporter::phase(const std::string& name, const std::string& detail, bool background) {
  const std::lock_guard lock(mutex_);
  if (events_) {
    nlohmann::ordered_json fields = {{"phase", name}};
    if (!detail.empty()) fields["detail"] = detail;
    events_->write("phase", fields);
  }
  if (background) {
    background_ = name;
    back_ = {now_(), std::nullopt, std::nullopt};
    return;
  }
  foreground_ = name;
  front_ = {now_(), std::nullopt, std::nullopt};
  if (quiet_) return;
  clear_bar();
  talk_ << styled("1", name) << (detail.empty() ? "" : ": ") << detail << '\n' << std::flush;
  front_.shown = front_.began;
}

void Reporter::progress(const std::string& phase, const Progress& progress) {
  const std::lock_guard lock(mutex_);
  if (phase != foreground_ && phase != background_) return;
  const bool in_front = phase == foreground_;
  Pace& pace = in_front ? front_ : back_;
  const Time now = now_();
  const double elapsed_s = std::chrono::duration<double>(now - pace.began).count();
  const auto eta_s = eta_seconds(progress.done, progress.total, elapsed_s);
  const bool finished = progress.total > 0 && progress.done >= progress.total;
  if (events_ && (finished || !pace.logged || now - *pace.logged >= 200ms)) {
    pace.logged = now;
    nlohmann::ordered_json fields = {{"phase", phase}};
    if (progress.unit == "lines") {
      fields["rows_done"] = static_cast<long>(progress.done);
      fields["rows"] = static_cast<long>(progress.total);
    } else {
      fields["fraction"] = progress.total > 0 ? progress.done / progress.total : 0.0;
    }
    if (progress.bytes > 0) fields["bytes"] = static_cast<long long>(progress.bytes);
    if (progress.bytes > 0 && elapsed_s > 0) {
      fields["rate"] = std::round(progress.bytes / elapsed_s);
    }
    if (eta_s) {
      fields["eta_s"] = std::round(*eta_s * 10) / 10;
    } else {
      fields["eta_s"] = nullptr;
    }
    events_->write("progress", fields);
  }
  if (quiet_ || !in_front) return;
  const auto every = bar_ ? 100ms : 10'000ms;
  if (pace.shown && now - *pace.shown < every && !(bar_ && finished)) return;
  pace.shown = now;
  if (bar_) {
    draw_bar(progress, eta_s);
  } else {
    plain_line(progress, eta_s);
  }
}

void Reporter::note(const std::string& sentence) {
  const std::lock_guard lock(mutex_);
  if (events_) events_->write("note", {{"message", sentence}});
  if (quiet_) return;
  clear_bar();
  talk_ << sentence << '\n' << std::flush;
}

void Reporter::warning(const std::string& sentence) {
  const std::lock_guard lock(mutex_);
  if (events_) events_->write("warning", {{"message", sentence}});
  clear_bar();
  talk_ << styled("33", "Note: ") << sentence << '\n' << std::flush;
}

void Reporter::say(const std::string& text) {
  const std::lock_guard lock(mutex_);
  if (quiet_) return;
  clear_bar();
  talk_ << text << '\n' << std::flush;
}

void Reporter::error(const Failure& failure) {
  const std::lock_guard lock(mutex_);
  if (events_) events_->write("error", error_fields(failure));
  if (json_ && !events_) {
    nlohmann::ordered_json object = {{"schema", "reseau-error/1"}};
    object.update(error_fields(failure));
    out_ << object.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) << '\n'
         << std::flush;
  }
  clear_bar();
  talk_ << styled("31", "reseau: ") << failure.what() << '\n';
  if (!failure.remedy().empty()) talk_ << "  Try: " << failure.remedy() << '\n';
  talk_ << std::flush;
}

void Reporter::event(const std::string& name, nlohmann::ordered_json fields) {
  if (events_) events_->write(name, std::move(fields));
}

void Reporter::result_line(const std::string& line) {
  const std::lock_guard lock(mutex_);
  if (json_) return;
  clear_bar();
  talk_ << std::flush;
  out_ << line << '\n' << std::flush;
}

void Reporter::result_json(const nlohmann::ordered_json& object) {
  const std::lock_guard lock(mutex_);
  if (!json_) return;
  clear_bar();
  out_ << object.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) << '\n'
       << std::flush;
}

void Reporter::clear_bar() {
  if (bar_width_ == 0) return;
  talk_ << '\r' << std::string(bar_width_, ' ') << '\r';
  bar_width_ = 0;
}

void Reporter::draw_bar(const Progress& progress, std::optional<double> eta_s) {
  constexpr int kCells = 30;
  const double fraction =
      progress.total > 0 ? std::clamp(progress.done / progress.total, 0.0, 1.0) : 0.0;
  const int filled = static_cast<int>(fraction * kCells);
  std::string line = fmt::format(
      "{:<12}[{}{}] {:3.0f} %", foreground_, std::string(static_cast<std::size_t>(filled), '#'),
      std::string(static_cast<std::size_t>(kCells - filled), '-'), 100 * fraction);
  if (progress.bytes > 0) line += "  " + human_bytes(progress.bytes);
  if (eta_s) line += "  " + human_seconds(*eta_s) + " left";
  const std::size_t old = bar_width_;
  bar_width_ = line.size();
  if (line.size() < old) line.append(old - line.size(), ' ');
  talk_ << '\r' << line << std::flush;
}

void Reporter::plain_line(const Progress& progress, std::optional<double> eta_s) {
  std::string line = foreground_ + ": ";
  if (progress.unit.empty()) {
    line +=
        fmt::format("{:.0f} %", progress.total > 0 ? 100 * progress.done / progress.total : 0.0);
  } else {
    line += fmt::format("{:.0f} of {:.0f} {}", progress.done, progress.total, progress.unit);
  }
  if (eta_s) line += ", " + human_seconds(*eta_s) + " left";
  talk_ << line << '\n' << std::flush;
}

std::string Reporter::styled(const char* code, const std::string& text) const {
  if (!color_) return text;
  return fmt::format("\x1b[{}m{}\x1b[0m", code, text);
}

}  // namespace reseau::cli
