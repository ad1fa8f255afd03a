// Entry point for whoever opens devices by name.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/scsi/sg_node.h"
#include "drivers/sim/sim_spec.h"
#include "drivers/usb/usb_transport.h"

namespace reseau::sim {

// Every model, of every family: "ls5000", "rps7200" …
[[nodiscard]] std::vector<std::string> simulated_unit_names();

// A simulated unit with the film of the specification under its head. Throws InputError for an
// unknown model, listing those that exist.
[[nodiscard]] std::unique_ptr<UsbTransport> open_simulated_unit(const SimSpec& spec);
// The same from a device name such as "sim:ls5000?film=dufay"; throws InputError.
[[nodiscard]] std::unique_ptr<UsbTransport> open_simulated_unit(std::string_view name);

// Whether the model stands behind the kernel's SCSI node instead of USB.
[[nodiscard]] bool is_scsi_model(const SimSpec& spec);
[[nodiscard]] std::unique_ptr<SgNode> open_simulated_sg(const SimSpec& spec);

}  // namespace reseau::sim
