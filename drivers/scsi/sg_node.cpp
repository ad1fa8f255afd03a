// SG_IO and nothing else: the one file that knows the kernel's structure.
#include "drivers/scsi/sg_node.h"

#include <algorithm>
#include <cerrno>
#include <climits>
#include <filesystem>
#include <fstream>
#include <limits>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <scsi/sg.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include "core/base/error.h"

namespace reseau {
namespace {

// The largest image READ with room to spare; the driver's default buffer is 32 KiB.
constexpr int kReservedBytes = 512 * 1024;

unsigned milliseconds_of(Duration timeout) {
  const auto ms = std::chrono::ceil<std::chrono::milliseconds>(timeout).count();
  return static_cast<unsigned>(std::clamp<std::int64_t>(ms, 1, std::numeric_limits<int>::max()));
}

class IoctlSgNode final : public SgNode {
 public:
  IoctlSgNode(int fd, IoctlCall call) : fd_(fd), call_(std::move(call)) {
    int bytes = kReservedBytes;
    // A kernel that grants less says so at the command that needs more.
    (void)call_(fd_, SG_SET_RESERVED_SIZE, &bytes);
  }
  ~IoctlSgNode() override { close(fd_); }
  IoctlSgNode(const IoctlSgNode&) = delete;
  IoctlSgNode& operator=(const IoctlSgNode&) = delete;

  void exchange(SgExchange& e) override {
    sg_io_hdr_t io{};
    io.interface_id = 'S';
    io.cmd_len = static_cast<unsigned char>(e.cdb.size());
    // The kernel takes pointers to non-const for both directions; it does not write these.
    io.cmdp = const_cast<unsigned char*>(reinterpret_cast<const unsigned char*>(e.cdb.data()));
    io.mx_sb_len = static_cast<unsigned char>(e.sense.size());
    io.sbp = reinterpret_cast<unsigned char*>(e.sense.data());
    io.timeout = milliseconds_of(e.timeout);
    io.dxfer_direction = SG_DXFER_NONE;
    if (!e.out.empty()) {
      io.dxfer_direction = SG_DXFER_TO_DEV;
      io.dxfer_len = static_cast<unsigned>(e.out.size());
      io.dxferp = const_cast<std::byte*>(e.out.data());
    } else if (!e.in.empty()) {
      io.dxfer_direction = SG_DXFER_FROM_DEV;
      io.dxfer_len = static_cast<unsigned>(e.in.size());
      io.dxferp = e.in.data();
    }
    while (call_(fd_, SG_IO, &io) != 0) {
      const int code = errno;
      if (code == EINTR) continue;
      if (code == ENODEV || code == ENXIO) {
        throw DeviceError(DeviceError::Kind::kDisconnected,
                          "The scanner is gone. Check its cable and its power, then start again.",
                          "SG_IO: no device");
      }
      throw std::system_error(code, std::generic_category(),
                              "The kernel refused to pass a command to the scanner (SG_IO)");
    }
    e.status = io.masked_status == 0 ? io.status : static_cast<std::uint8_t>(io.status & 0x7E);
    e.sense_bytes = std::min<std::size_t>(io.sb_len_wr, e.sense.size());
    e.residual_bytes =
        static_cast<std::size_t>(std::clamp(io.resid, 0, static_cast<int>(io.dxfer_len)));
    e.host_status = io.host_status;
  }

 private:
  int fd_;
  IoctlCall call_;
};

std::string first_line(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  line.erase(line.find_last_not_of(" \n") + 1);
  return line;
}

}  // namespace

std::unique_ptr<SgNode> make_sg_node(int fd, IoctlCall call) {
  return std::make_unique<IoctlSgNode>(fd, std::move(call));
}

std::unique_ptr<SgNode> open_sg_node(const std::string& path) {
  const int fd = open(path.c_str(), O_RDWR | O_CLOEXEC | O_NONBLOCK);
  if (fd < 0) {
    const int code = errno;
    std::string what = "The scanner node " + path + " cannot be opened";
    if (code == EACCES || code == EPERM) {
      what =
          "You may not use " + path +
          ". Install the udev rule 60-reseau.rules, or for this once: sudo setfacl -m u:$USER:rw " +
          path;
    } else if (code == ENOENT) {
      what = "There is no " + path +
             ". Switch the scanner on, load the module sg (sudo modprobe sg), and look with "
             "`reseau list`";
    } else if (code == EBUSY) {
      what = "Another program is using " + path + ". Close it and try again";
    }
    throw std::system_error(code, std::generic_category(), what);
  }
  int version = 0;
  if (ioctl(fd, SG_GET_VERSION_NUM, &version) != 0 || version < 30000) {
    close(fd);
    throw DeviceError(DeviceError::Kind::kProtocol,
                      path +
                          " is not a SCSI node of the kernel's sg driver. Give /dev/sgN; "
                          "`reseau list` shows the scanners among them.",
                      "SG_GET_VERSION_NUM");
  }
  return make_sg_node(fd, [](int file, unsigned long request, void* argument) {
    return ioctl(file, request, argument);
  });
}

std::vector<SgDeviceInfo> list_sg_scanners(const std::string& sysfs) {
  std::vector<SgDeviceInfo> found;
  std::error_code none;
  for (const auto& entry : std::filesystem::directory_iterator(sysfs, none)) {
    constexpr const char* kScanner = "6";
    const std::filesystem::path device = entry.path() / "device";
    if (first_line(device / "type") != kScanner) continue;
    found.push_back({"/dev/" + entry.path().filename().string(), first_line(device / "vendor"),
                     first_line(device / "model")});
  }
  std::sort(found.begin(), found.end(),
            [](const SgDeviceInfo& a, const SgDeviceInfo& b) { return a.path < b.path; });
  return found;
}

}  // namespace reseau
