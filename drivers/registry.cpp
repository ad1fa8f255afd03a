#include "drivers/registry.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <system_error>
#include <utility>

#include <unistd.h>

#include "core/base/error.h"
#include "drivers/coolscan/coolscan.h"
#include "drivers/coolscan/models.h"
#include "drivers/coolscan/unstick.h"
#include "drivers/families.h"
#include "drivers/fault_sg.h"
#include "drivers/pieusb/models.h"
#include "drivers/scsi/scsi_as_usb.h"
#include "drivers/scsi/scsi_link.h"
#include "drivers/scsi/sg_node.h"
#include "drivers/scsi/sg_scsi.h"
#include "drivers/sim/sim_spec.h"
#include "drivers/sim/simulated_unit.h"
#include "drivers/usb/fault_transport.h"
#include "drivers/usb/libusb_transport.h"
#include "drivers/usb/paced_transport.h"
#include "drivers/usb/recording_transport.h"
#include "drivers/usb/replay_fault.h"
#include "drivers/usb/replay_transport.h"
#include "drivers/utc_time.h"
#include "drivers/virtual_clock.h"

namespace reseau {
namespace {

constexpr std::string_view kUsb = "usb:";
constexpr std::string_view kSim = "sim:";
constexpr std::string_view kSg = "sg:";
constexpr std::string_view kReplay = "replay:";

// What stands behind a name, before anyone has sent a command: one of the two.
struct Link {
  std::unique_ptr<UsbTransport> usb;
  std::unique_ptr<SgNode> sg;
  std::shared_ptr<Clock> clock;
};

[[noreturn]] void throw_unknown(const std::string& name) {
  throw InputError("There is no device called \"" + name +
                   "\". Write usb:04b0:4002 (a unit on the bus), sg:/dev/sg2 (FireWire or SCSI), "
                   "sim:ls5000 (the simulated one) or replay:FILE.pcapng (a recording); `reseau "
                   "list` shows what is there.");
}

std::uint16_t usb_id(const std::string& text, std::size_t at, const std::string& name) {
  std::uint16_t id = 0;
  const char* const begin = text.data() + at;
  const auto parsed = std::from_chars(begin, begin + 4, id, 16);
  if (parsed.ec != std::errc() || parsed.ptr != begin + 4) throw_unknown(name);
  return id;
}

Link open_usb(const std::string& name) {
  const std::string ids = name.substr(kUsb.size());
  constexpr std::size_t kIdsLength = 9;  // "04b0:4002"
  if (ids.size() < kIdsLength || ids[4] != ':' ||
      (ids.size() > kIdsLength && ids[kIdsLength] != ':')) {
    throw_unknown(name);
  }
  const std::uint16_t vendor = usb_id(ids, 0, name);
  const std::uint16_t product = usb_id(ids, 5, name);
  if (trade_name_of(vendor, product).empty()) {
    throw InputError("The program has no driver for the USB device " + ids.substr(0, kIdsLength) +
                     ". `reseau list` shows the scanners that it can use.");
  }
  const std::string serial = ids.size() > kIdsLength ? ids.substr(kIdsLength + 1) : std::string();
  return {open_libusb(vendor, product, serial), nullptr, std::make_shared<SystemClock>()};
}

// Takes "key=value" out of a name's query; empty when it is not there.
std::string take_option(std::string& name, const std::string& key) {
  const std::size_t query = name.find('?');
  for (std::size_t at = query; at != std::string::npos; at = name.find('&', at + 1)) {
    if (name.compare(at + 1, key.size() + 1, key + '=') != 0) continue;
    const std::size_t end = std::min(name.find('&', at + 1), name.size());
    const std::size_t value = at + 1 + key.size() + 1;
    std::string text = name.substr(value, end - value);
    // The mark before the option stays for what follows it, or goes with the last one.
    const bool last = end == name.size();
    name.erase(last ? at : at + 1, last ? std::string::npos : end - at);
    return text;
  }
  return {};
}

// Options of the link, which are not the simulated unit's: pace=real takes the time that a unit
// takes, fault=stall@120 (drivers/usb/fault_transport.h) fails one transfer.
Link open_sim(std::string name) {
  const std::string pace = take_option(name, "pace");
  const std::string fault = take_option(name, "fault");
  if (!pace.empty() && pace != "real" && pace != "fast") {
    throw InputError("The pace of a simulated scanner is real or fast, not \"" + pace + "\".");
  }
  Link link;
  const sim::SimSpec spec = sim::parse_sim_spec(name);
  if (sim::is_scsi_model(spec)) {
    link.sg = sim::open_simulated_sg(spec);
    if (!fault.empty()) link.sg = make_fault_sg(std::move(link.sg), parse_fault(fault));
  } else {
    link.usb = sim::open_simulated_unit(spec);
    if (!fault.empty()) {
      link.usb = std::make_unique<FaultTransport>(std::move(link.usb), parse_fault(fault));
    }
  }
  if (pace == "real") {
    link.clock = std::make_shared<SystemClock>();
    if (link.usb) {
      link.usb =
          std::make_unique<PacedTransport>(std::move(link.usb), kScannerBytesPerSecond, link.clock);
    }
  } else {
    link.clock = std::make_shared<VirtualClock>();
  }
  return link;
}

std::string usb_name(const UsbDeviceInfo& unit) {
  char ids[16];
  std::snprintf(ids, sizeof ids, "%04x:%04x", unsigned{unit.vendor_id}, unsigned{unit.product_id});
  std::string name(kUsb);
  name += ids;
  if (!unit.serial.empty()) name += ':' + unit.serial;
  return name;
}

Link open_link(const std::string& name) {
  if (name.starts_with(kUsb)) return open_usb(name);
  if (name.starts_with(kSim)) return open_sim(name);
  if (!name.starts_with(kSg)) throw_unknown(name);
  Link link;
  link.sg = open_sg_node(name.substr(kSg.size()));
  link.clock = std::make_shared<SystemClock>();
  return link;
}

OpenedScanner open_replay(const std::string& name, const OpenOptions& options) {
  if (!options.record_to.empty()) {
    throw InputError("A replay is a recording already; copy the file instead of recording it.");
  }
  if (!std::isfinite(options.replay_speed) || options.replay_speed < 0) {
    throw InputError("The speed of a replay is a number of times the recorded one, or 0.");
  }
  const auto clock = std::make_shared<VirtualClock>();
  auto replay =
      std::make_unique<ReplayTransport>(name.substr(kReplay.size()), *clock, command_decoder());
  if (options.replay_speed > 0) {
    const auto real = std::make_shared<SystemClock>();
    replay->set_pace(
        [real, start = real->now(), speed = options.replay_speed](Duration since_start) {
          const double us = static_cast<double>(since_start.count()) / speed;
          real->sleep_until(start + Duration(std::llround(us)));
        });
  }
  const SessionHeader header = replay->header();
  OpenedScanner opened;
  opened.recorded_comment = header.comment;
  opened.recorded_at_utc = header.started_at_utc;
  std::unique_ptr<UsbTransport> usb;
  if (options.replay_fault.empty()) {
    usb = std::move(replay);
  } else if (replay->identity().vendor_id == pieusb::kGenesysVendorId) {
    usb = std::make_unique<FaultTransport>(std::move(replay), parse_fault(options.replay_fault));
  } else {
    usb = std::make_unique<ReplayFault>(std::move(replay), parse_fault(options.replay_fault));
  }
  opened.scanner =
      open_family(std::move(usb), clock,
                  {header.device_name.empty() ? name : header.device_name, header.started_at_utc});
  return opened;
}

// No reset is known that such a unit is sure to survive, so it is only asked whether it answers.
UnstickReport unstick_pie(Link link, const std::string& name, const UnstickTalk& talk) {
  try {
    (void)open_family(std::move(link.usb), link.clock, {name, {}});
    talk("asking the scanner what it is", "it answers");
    return UnstickReport::kWasFine;
  } catch (const DeviceError& error) {
    talk("asking the scanner what it is", error.what());
    return UnstickReport::kNeedsPowerSwitch;
  }
}

}  // namespace

std::vector<DeviceEntry> list_devices() {
  std::vector<DeviceEntry> entries;
  for (const UsbDeviceInfo& unit : list_known_units()) {
    DeviceEntry entry;
    entry.name = usb_name(unit);
    entry.description = trade_name_of(unit.vendor_id, unit.product_id) + ", " + unit.speed;
    if (access(unit.node.c_str(), R_OK | W_OK) != 0) {
      entry.problem = "You may not use " + unit.node +
                      ". Install the udev rule 60-reseau.rules, then unplug the scanner and plug "
                      "it in again.";
    }
    entries.push_back(std::move(entry));
  }
  for (const SgDeviceInfo& unit : list_sg_scanners()) {
    const coolscan::Model* const model = coolscan::model_by_product(unit.product);
    if (model == nullptr) continue;
    DeviceEntry entry;
    entry.name = std::string(kSg) + unit.path;
    entry.description = std::string(model->trade_name) + ", SCSI";
    if (access(unit.path.c_str(), R_OK | W_OK) != 0) {
      entry.problem =
          "You may not use " + unit.path +
          ". Install the udev rule 60-reseau.rules, then switch the scanner off and on.";
    }
    entries.push_back(std::move(entry));
  }
  for (const std::string& model : sim::simulated_unit_names()) {
    DeviceEntry entry;
    entry.name = std::string(kSim) + model;
    entry.description = "simulated scanner with a simulated Dufaycolor film";
    entry.simulated = true;
    entries.push_back(std::move(entry));
  }
  return entries;
}

OpenedScanner open_scanner(const std::string& name, const OpenOptions& options) {
  if (name.starts_with(kReplay)) return open_replay(name, options);
  Link link = open_link(name);
  OpenAs open_as{name, {}};
  if (!options.record_to.empty()) {
    // A replay has to write the bytes of this scan, its time included.
    open_as.started_at_utc = utc_now();
    if (link.sg != nullptr) {
      link.usb = std::make_unique<ScsiAsUsb>(sg_scsi_link(std::move(link.sg), *link.clock));
    }
    link.usb = std::make_unique<RecordingTransport>(
        std::move(link.usb), *link.clock, options.record_to,
        SessionHeader{name, open_as.started_at_utc, options.record_comment});
  }
  OpenedScanner opened;
  if (link.usb != nullptr) {
    opened.scanner = open_family(std::move(link.usb), link.clock, std::move(open_as));
  } else {
    ScsiLink scsi = sg_scsi_link(std::move(link.sg), *link.clock);
    opened.scanner =
        std::make_unique<coolscan::Coolscan>(std::move(scsi), link.clock, std::move(open_as));
  }
  return opened;
}

UnstickReport unstick_device(const std::string& name, const UnstickTalk& talk) {
  if (name.starts_with(kReplay)) {
    throw InputError("A recording cannot be stuck. Give the name of a scanner.");
  }
  Link link = open_link(name);
  const std::shared_ptr<Clock> clock = link.clock;
  if (link.usb != nullptr && link.usb->identity().vendor_id == pieusb::kGenesysVendorId) {
    return unstick_pie(std::move(link), name, talk);
  }
  const ScsiLink scsi = link.sg != nullptr ? sg_scsi_link(std::move(link.sg), *clock)
                                           : usb_scsi_link(std::move(link.usb), *clock);
  switch (coolscan::unstick(*scsi.device, *clock, talk)) {
    case coolscan::Unstuck::kWasFine:
      return UnstickReport::kWasFine;
    case coolscan::Unstuck::kMended:
      return UnstickReport::kMended;
    case coolscan::Unstuck::kNeedsPowerSwitch:
      break;
  }
  return UnstickReport::kNeedsPowerSwitch;
}

}  // namespace reseau
