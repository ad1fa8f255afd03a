// A simulated scanner as its commands see it; the USB wrapper is wire.h. Source: LS-5000 interface
// specification; recorded Nikon Scan session; LS-50 firmware 1.02.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "drivers/sim/frame_table.h"
#include "drivers/sim/image_stream.h"
#include "drivers/sim/operations.h"
#include "drivers/sim/pages.h"
#include "drivers/sim/sense.h"
#include "drivers/sim/sim_spec.h"
#include "drivers/sim/unit_model.h"
#include "drivers/sim/windows.h"
#include "drivers/sim/wire_bytes.h"

namespace reseau::sim {

// Where autofocus ends, as a unit reported it.
inline constexpr int kBestFocus = 209;

// How a command goes on: with its status, with data from the host, or with data to it.
struct CommandReply {
  enum class Next { kStatus, kDataOut, kDataIn };
  Next next = Next::kStatus;
  std::size_t out_bytes = 0;   // kDataOut: how many the CDB announced
  Bytes in{};                  // kDataIn
  Sense sense{};               // kStatus, kDataIn
  std::size_t line_bytes = 0;  // of an image
  int busy_phases = 0;         // phase queries to answer with "busy" first

  static CommandReply status(const Sense& sense) { return {.sense = sense}; }
};

// Thread-bound. Time does not pass: operations end after a number of polls.
class Unit {
 public:
  // Throws InputError for an unknown model.
  // packet_bytes: of the link, 0 without packets.
  Unit(const SimSpec& spec, int packet_bytes);

  // cdb: 6 or 10 bytes.
  [[nodiscard]] CommandReply command(ByteView cdb);
  // The data that the last kDataOut asked for.
  [[nodiscard]] Sense data_out(ByteView data);

  [[nodiscard]] const UnitModel& model() const { return *model_; }

 private:
  // An operation that outlives its command.
  struct Operation {
    Sense busy;
    int polls_left = 0;
    std::uint8_t code = 0;  // what happens at its end; 0 nothing
  };

  // unit.cpp
  [[nodiscard]] std::optional<Sense> refusal(std::uint8_t opcode, ByteView cdb);
  [[nodiscard]] CommandReply dispatch(ByteView cdb);
  [[nodiscard]] Sense poll();
  [[nodiscard]] Sense poll_start_up();
  [[nodiscard]] CommandReply inquiry(ByteView cdb) const;
  [[nodiscard]] CommandReply request_sense(ByteView cdb) const;
  [[nodiscard]] CommandReply mode_sense(ByteView cdb) const;
  [[nodiscard]] CommandReply mode_select(ByteView cdb) const;
  [[nodiscard]] Sense mode_select_data(ByteView data);
  [[nodiscard]] CommandReply get_window(ByteView cdb) const;
  void abort_all();
  void attend(const Sense& attention);
  void power_on();

  // unit_operations.cpp
  [[nodiscard]] CommandReply set_parameter(ByteView cdb);
  [[nodiscard]] CommandReply get_parameter(ByteView cdb) const;
  [[nodiscard]] Sense execute();
  void finish_operation(std::uint8_t code);
  void insert_film();
  [[nodiscard]] FrameTable new_frames() const;
  [[nodiscard]] Sense without_film() const;

  // unit_scan.cpp
  [[nodiscard]] Sense scan(ByteView ids);
  [[nodiscard]] Sense start_scan(const ScanLayout& layout);
  [[nodiscard]] CommandReply read(ByteView cdb);
  [[nodiscard]] CommandReply read_image(std::size_t length);
  [[nodiscard]] std::optional<Bytes> read_data(std::uint8_t type, int colour, std::size_t length);
  [[nodiscard]] CommandReply send(ByteView cdb) const;
  [[nodiscard]] Sense send_data(std::uint8_t type, int colour, ByteView data);
  // Units whose READ may end anywhere.
  [[nodiscard]] CommandReply read_any_length(std::size_t length);
  void end_scan();

  SimSpec spec_;
  const UnitModel* model_;
  int packet_bytes_;
  std::shared_ptr<const Film> film_;
  AdapterState adapter_;
  WindowStore windows_;
  FrameTable frames_;
  LookupTables luts_;
  Bytes rectangles_;     // data type 88, as sent
  bool jammed_ = false;  // the stage stands against its stop
  int slides_left_ = 0;
  int mud_ = 1200;  // measurement units per inch

  int start_up_polls_ = 0;  // until power-on initialisation ends
  int film_polls_ = 0;      // until the film is pushed in
  std::deque<Sense> attentions_;
  std::optional<Operation> operation_;
  Sense deferred_error_;  // what SEND DIAGNOSTIC will tell
  Sense last_sense_;

  int focus_ = 0;
  std::uint32_t stage_ = 0, focus_x_ = 0, focus_y_ = 0;
  std::uint32_t unload_seconds_ = 600, unload_on_ = 1, focus_at_load_ = 1;
  std::optional<OperationParameters> parameters_;  // set, not yet executed

  std::vector<int> scan_ids_;
  std::deque<CooperationRequest> requests_;  // not yet raised
  std::optional<CooperationRequest> raised_;
  bool requests_open_ = false;
  std::unique_ptr<ImageStream> stream_;
  Bytes unread_;  // of a record that a READ ended in
  std::uint64_t n_passes_ = 0;

  Bytes pending_cdb_;  // of the command that waits for data
};

}  // namespace reseau::sim
