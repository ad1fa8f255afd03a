#include "drivers/pieusb/sense.h"

#include <array>
#include <cstdio>

namespace reseau::pieusb {
namespace {

constexpr int kEvery = -1;

struct PieMeaning {
  int key, asc, ascq;  // kEvery matches everything
  const char* sentence;
};

// First match wins. Codes: SANE's pieusb backend and s6stkurz/reflecta-rps-7200, docs/protocol.md;
// keys as in every SCSI device.
constexpr PieMeaning kPieMeanings[] = {
    {0x02, 0x04, 0x01, "The scanner's lamp is warming up. Wait a minute or two."},
    {0x02, kEvery, kEvery, "The scanner is not ready. Wait until its lamp stops blinking."},
    {0x03, kEvery, kEvery,
     "The scanner has trouble with the film. Take it out, check it, and put it in again."},
    {0x04, kEvery, kEvery,
     "The scanner reports a hardware failure. Switch it off, wait ten seconds and switch it on "
     "again; if it happens again it needs service."},
    {0x05, 0x20, 0x00,
     "The scanner has no more lines, or does not know the command; this model cannot do that."},
    // A pass cannot be ended from outside without harm (README, Never).
    {0x05, 0x2C, kEvery,
     "The scanner is in the middle of a scan that another program left. Switch it off, wait ten "
     "seconds, switch it on again and repeat the scan."},
    {0x05, kEvery, kEvery, "The scanner refused a setting that it does not support."},
    {0x06, 0x00, 0x06, "The scanner broke off the transfer. Scan again."},
    {0x06, 0x1A, 0x00, "The scanner refused the length of a command. Scan again."},
    {0x06, 0x20, 0x00, "The scanner does not know a command; this model cannot do that."},
    {0x06, 0x26, 0x82,
     "The resolution is too high for this scanner in one pass. Choose a lower one."},
    {0x06, 0x26, 0x83,
     "The resolution is too high for this scanner in one pass. Choose a lower one."},
    {0x06, 0x29, 0x00, "The scanner was switched on or reset. Start again."},
    {0x06, 0x82, 0x00, "The scanner wants to calibrate first. Start again."},
    {0x06, kEvery, kEvery, "The scanner's state changed. Start again."},
    {0x0B, kEvery, kEvery, "The scanner gave up the command. Scan again."},
    {0x0F, kEvery, kEvery,
     "The scanner refused a command, and its reason got lost on the cable. Scan again; if it "
     "happens again, try another cable or port, without a hub."},
};

bool fits(int expected, int actual) { return expected == kEvery || expected == actual; }

std::string pie_code(const Sense& sense) {
  std::array<char, 16> text{};
  std::snprintf(text.data(), text.size(), "%02X/%02X/%02X", unsigned{sense.key},
                unsigned{sense.asc}, unsigned{sense.ascq});
  return text.data();
}

DeviceError::Kind pie_kind(const Sense& sense) {
  switch (sense.key) {
    case 0x02:
      return DeviceError::Kind::kBusy;
    case 0x03:
    case 0x04:
    case 0x0B:
      return DeviceError::Kind::kHardware;
    case 0x05:
      return DeviceError::Kind::kRefused;
    default:
      return DeviceError::Kind::kProtocol;
  }
}

}  // namespace

std::string pie_sentence(const Sense& sense) {
  for (const PieMeaning& meaning : kPieMeanings) {
    if (fits(meaning.key, sense.key) && fits(meaning.asc, sense.asc) &&
        fits(meaning.ascq, sense.ascq)) {
      return std::string(meaning.sentence) + " [" + pie_code(sense) + "]";
    }
  }
  return "The scanner answered with a code that this program does not know. [" + pie_code(sense) +
         "]";
}

DeviceError pie_error(const Sense& sense, const std::string& operation) {
  return {pie_kind(sense), pie_sentence(sense), operation + " → " + pie_code(sense)};
}

}  // namespace reseau::pieusb
