// The server over real sockets, with a client that shares no code with it.
#include "drivers/usbip/server.h"

#include <array>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "core/base/error.h"
#include "tests/support/temp_dir.h"
#include "tests/support/usbip_host/usbip_client.h"
#include "tests/unit/usbip/fake_unit.h"

namespace reseau::usbip {
namespace {

using ::reseau::testing::TransferReply;
using ::reseau::testing::UsbipClient;
using Words = std::vector<std::uint8_t>;

class UsbipServer : public ::testing::Test {
 protected:
  UsbipServer()
      : thread_([this](const std::stop_token& stop) { serve(listener_, device_, stop, say_); }) {}

  [[nodiscard]] const std::string& address() const { return listener_.address(); }
  // Sends four bytes and expects them back.
  static void expect_echo(UsbipClient& client, std::uint32_t sequence) {
    const Words sent{1, 2, 3, static_cast<std::uint8_t>(sequence)};
    client.submit(sequence, false, 1, 4, sent);
    client.submit(sequence + 1, true, 2, 512);
    EXPECT_EQ(client.reply().sequence, sequence);
    const TransferReply in = client.reply();
    EXPECT_EQ(in.sequence, sequence + 1);
    ASSERT_EQ(in.length, 4U);
    Words got(4);
    ASSERT_TRUE(client.receive(got));
    EXPECT_EQ(got, sent);
  }

  FakeUnit unit_;
  ExportedDevice device_{some_device(), unit_};
  ListenSocket listener_{"tcp:0"};
  std::function<void(const std::string&)> say_ = [](const std::string&) {};
  std::jthread thread_;
};

TEST_F(UsbipServer, ListsAndGivesItsDevice) {
  EXPECT_EQ(UsbipClient(address()).count_devices(), 1U);
  UsbipClient client(address());
  const auto device = client.import("1-1");
  ASSERT_TRUE(device);
  EXPECT_EQ(device->speed, 3U);
  Words descriptor(18);
  EXPECT_EQ(client.control_in({0x80, 6, 0, 1, 0, 0, 18, 0}, descriptor), 18);
  EXPECT_EQ(descriptor[8], 0xB0);
  expect_echo(client, 10);
}

TEST_F(UsbipServer, OnlyOneClientAtATimeAndTheNextOneAfterIt) {
  for (int cycle = 0; cycle < 5; ++cycle) {
    UsbipClient client(address());
    ASSERT_TRUE(client.import("1-1")) << cycle;
    EXPECT_FALSE(UsbipClient(address()).import("1-1")) << "taken";
    EXPECT_EQ(UsbipClient(address()).count_devices(), 1U);
    expect_echo(client, 1);
    client.submit(5, true, 2, 512);  // waits when the client goes
    std::array<std::uint8_t, 1> end{};
    if (cycle == 4) break;
    UsbipClient other(address());
    static_cast<void>(other.import("9-9"));
    EXPECT_FALSE(other.receive(end)) << "a bus id that does not exist ends the connection";
  }
}

TEST_F(UsbipServer, UnlinkReachesAWaitingRead) {
  UsbipClient client(address());
  ASSERT_TRUE(client.import("1-1"));
  client.submit(1, true, 2, 512);
  client.unlink(2, 1);
  const TransferReply reply = client.reply();
  EXPECT_TRUE(reply.unlink);
  EXPECT_EQ(reply.status, -104);
  expect_echo(client, 10);
}

TEST_F(UsbipServer, HostileClientsHarmNobody) {
  UsbipClient good(address());
  ASSERT_TRUE(good.import("1-1"));
  const std::vector<Words> streams = {{1},
                                      {1, 0x11, 0x80},
                                      Words(8, 0xFF),
                                      {1, 0x11, 0x80, 3, 0, 0, 0, 0, '1'},
                                      Words(100000, 0x41)};
  for (const Words& stream : streams) {
    UsbipClient bad(address());
    try {
      bad.send(stream);
    } catch (const std::runtime_error&) {
      // closed while it was being sent
    }
  }
  std::vector<std::unique_ptr<UsbipClient>> idle;
  for (int i = 0; i < 40; ++i) idle.push_back(std::make_unique<UsbipClient>(address()));
  expect_echo(good, 20);
  EXPECT_EQ(UsbipClient(address()).count_devices(), 1U);
}

TEST_F(UsbipServer, AnAttachedClientThatBreaksTheProtocolLosesItsPlace) {
  {
    UsbipClient bad(address());
    ASSERT_TRUE(bad.import("1-1"));
    bad.send(Words(48, 0xEE));
    std::array<std::uint8_t, 1> end{};
    EXPECT_FALSE(bad.receive(end));
  }
  UsbipClient next(address());
  ASSERT_TRUE(next.import("1-1"));
  expect_echo(next, 1);
}

TEST_F(UsbipServer, ManyReadsInFlightComeBackInOrder) {
  UsbipClient client(address());
  ASSERT_TRUE(client.import("1-1"));
  for (std::uint32_t i = 0; i < 200; ++i) client.submit(1000 + i, true, 2, 512);
  for (std::uint32_t i = 0; i < 200; ++i) {
    const Words sent{static_cast<std::uint8_t>(i)};
    client.submit(i, false, 1, 1, sent);
    EXPECT_EQ(client.reply().sequence, i);
    EXPECT_EQ(client.reply().sequence, 1000 + i);
    Words got(1);
    ASSERT_TRUE(client.receive(got));
    EXPECT_EQ(got, sent);
  }
}

TEST(ListenSocket, UnderstandsAddressesAndRefusesTheRest) {
  EXPECT_FALSE(ListenSocket("tcp:0").open_to_others());
  EXPECT_EQ(ListenSocket("tcp:localhost:0").address().rfind("tcp:127.0.0.1:", 0), 0U);
  EXPECT_TRUE(ListenSocket("tcp:0.0.0.0:0").open_to_others());
  for (const char* wrong : {"", "tcp:", "unix:", "udp:1", "tcp:127.0.0.1:99999", "tcp:1:2:3",
                            "tcp:example.org:1", "3240", "tcp:-1"}) {
    EXPECT_THROW(ListenSocket{wrong}, InputError) << wrong;
  }
  EXPECT_THROW(ListenSocket("unix:" + std::string(200, 'x')), InputError);
  const ListenSocket first("tcp:0");
  EXPECT_THROW(ListenSocket{first.address()}, std::system_error);
}

TEST(ListenSocket, ASocketFileIsTakenOverOnlyFromTheDead) {
  const test::TempDir dir;
  const std::string path = (dir.path() / "scanner.sock").string();
  {
    const ListenSocket live("unix:" + path);
    EXPECT_THROW(ListenSocket{"unix:" + path}, std::system_error);
  }
  EXPECT_FALSE(std::filesystem::exists(path)) << "it goes with its owner";
  const int fd = ::socket(AF_UNIX, SOCK_STREAM, 0);
  sockaddr_un name{};
  name.sun_family = AF_UNIX;
  path.copy(name.sun_path, sizeof name.sun_path - 1);
  ASSERT_EQ(::bind(fd, reinterpret_cast<const sockaddr*>(&name), sizeof name), 0);
  ::close(fd);
  ASSERT_TRUE(std::filesystem::exists(path));
  EXPECT_NO_THROW(ListenSocket{"unix:" + path});
  test::write_bytes(path, "a letter");
  EXPECT_THROW(ListenSocket{"unix:" + path}, std::system_error);
  EXPECT_EQ(test::file_bytes(path), "a letter");
}

}  // namespace
}  // namespace reseau::usbip
