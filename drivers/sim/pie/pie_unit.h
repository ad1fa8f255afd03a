// The commands of a simulated PIE unit. Source: as pie_model.h.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "drivers/sim/film.h"
#include "drivers/sim/pie/pie_model.h"
#include "drivers/sim/pie/pie_sensor.h"
#include "drivers/sim/pie/pie_stream.h"
#include "drivers/sim/wire_bytes.h"

namespace reseau::sim::pie {

struct PieSense {
  std::uint8_t key = 0, code = 0, qualifier = 0;
  [[nodiscard]] bool good() const { return key == 0; }
};

struct PieReply {
  enum class Next { kDone, kDataIn, kDataOut };
  Next next = Next::kDone;
  PieSense sense{};           // of kDone; not good: check condition
  Bytes in{};                 // kDataIn
  std::size_t out_bytes = 0;  // kDataOut
  int busy_polls = 0;         // status "busy" comes so often first
  bool again = false;         // not taken: the command has to come again
  bool silent = false;        // data is promised and never sent
};

// Thread-bound. Time does not pass: what takes time ends after a number of polls.
class PieUnit {
 public:
  PieUnit(const PieModel& model, const SimSpec& spec);

  [[nodiscard]] PieReply command(ByteView cdb);
  // The data that the last kDataOut asked for.
  [[nodiscard]] PieSense data_out(ByteView data);
  // A unit that was treated as it must not be treated answers nothing until it is switched off.
  [[nodiscard]] bool hung() const { return hung_; }
  void hang() { hung_ = true; }

  [[nodiscard]] const PieModel& model() const { return model_; }

 private:
  struct Frame {
    int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  };
  struct Mode {
    int dpi = 0;
    bool infrared = false;
    bool two_bytes = true;
    std::uint16_t quality = 0;
  };

  [[nodiscard]] std::optional<PieSense> refusal(std::uint8_t opcode);
  [[nodiscard]] PieReply check(const PieSense& sense);
  [[nodiscard]] PieReply inquiry(std::size_t length);
  [[nodiscard]] PieReply read_state(std::size_t length);
  [[nodiscard]] PieReply read_gain(std::size_t length);
  [[nodiscard]] PieReply mask(std::size_t length);
  [[nodiscard]] PieReply parameters(std::size_t length);
  [[nodiscard]] PieReply read(int length);
  [[nodiscard]] PieReply scan(int flag);
  [[nodiscard]] PieSense write(ByteView data);
  [[nodiscard]] PieSense mode_select(ByteView data);
  [[nodiscard]] PieSense slide(ByteView data);
  void start_image();
  void begin_calibrated_image();
  void queue_calibration(int n_lines, bool with_dark);
  [[nodiscard]] std::array<double, 4> levels() const;
  [[nodiscard]] ScanWindow window() const;
  [[nodiscard]] bool pass_open() const { return stream_ != nullptr || calibration_lines_ > 0; }

  const PieModel& model_;
  SimSpec spec_;
  std::shared_ptr<const Film> film_;
  PieSensor sensor_;
  bool hung_ = false;
  bool film_present_;
  bool power_on_notice_ = false;
  int warm_polls_ = 0;  // READ STATE and TEST UNIT READY until the lamp is warm
  int again_left_ = 0;  // of the READ that comes next
  PieSense sense_;      // waits for REQUEST SENSE

  std::uint8_t out_op_ = 0;  // the command that waits for data
  std::size_t out_bytes_ = 0;
  bool info_prepared_ = false, frame_set_ = false, frame_confirmed_ = false, mode_set_ = false;
  bool calibrated_ = false;
  Frame frame_;
  Mode mode_;
  std::array<std::uint16_t, 4> exposure_{};
  std::array<std::uint8_t, 4> gain_{};

  int frame_counter_ = 0, frame_target_ = 0, frame_polls_ = 0;
  double fine_move_mm_ = 0;

  std::unique_ptr<PieStream> stream_;
  Bytes calibration_;  // lines; those before calibration_at_ were read
  std::size_t calibration_at_ = 0;
  int calibration_lines_ = 0;
  std::uint64_t n_passes_ = 0;
};

}  // namespace reseau::sim::pie
