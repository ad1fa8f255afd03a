// The boundary to one SCSI node of the kernel: one command with its data, answered with status,
// sense and what the host adapter says. Behind it stand SG_IO and a simulated unit.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/base/clock.h"
#include "drivers/bytes.h"

namespace reseau {

struct SgExchange {
  // Filled by the caller. At most one of out and in is not empty.
  ByteView cdb;
  ByteView out;
  std::span<std::byte> in;
  Duration timeout{};

  // Filled by the node.
  std::uint8_t status = 0;
  std::array<std::byte, 32> sense{};
  std::size_t sense_bytes = 0;
  std::size_t residual_bytes = 0;  // of the data, not moved
  int host_status = 0;             // SG_IO's: 0 good, 1 no connection, 3 timeout …
};

// Thread-bound.
class SgNode {
 public:
  virtual ~SgNode() = default;
  // Throws DeviceError or std::system_error when the node itself fails.
  virtual void exchange(SgExchange& exchange) = 0;
};

// ioctl(2), or what stands in for it; returns 0, or -1 with errno.
using IoctlCall = std::function<int(int fd, unsigned long request, void* argument)>;

// SG_IO on an open file; closes it in the end.
[[nodiscard]] std::unique_ptr<SgNode> make_sg_node(int fd, IoctlCall call);

// "/dev/sg2". Throws std::system_error that says what permission is missing, DeviceError when it is
// no scanner's node.
[[nodiscard]] std::unique_ptr<SgNode> open_sg_node(const std::string& path);

struct SgDeviceInfo {
  std::string path, vendor, product;
};
// Scanners among the nodes of the kernel, from sysfs. Opens nothing.
[[nodiscard]] std::vector<SgDeviceInfo> list_sg_scanners(
    const std::string& sysfs = "/sys/class/scsi_generic");

}  // namespace reseau
