#include "drivers/scsi/sense.h"

#include <array>
#include <cstdio>

namespace reseau {
namespace {

constexpr int kAny = -1;

struct Meaning {
  int key, asc, ascq, tsc;  // kAny matches everything
  const char* sentence;
};

// First match wins. Codes: LS-5000 interface specification, sense data; entries that it does not
// list are in the sense table of LS-50 firmware 1.02.
constexpr Meaning kMeanings[] = {
    {0x01, 0x37, 0x00, kAny, "The scanner rounded the resolution that was asked for."},
    {0x01, 0x61, 0x02, kAny,
     "The scanner could not focus: it found no detail at that point of the film. Choose a point "
     "with detail, or give the focus position as a number."},
    {0x02, 0x04, 0x00, kAny,
     "Film was in the scanner when it was switched on, and it has not finished starting up. Wait, "
     "or take the film out."},
    {0x02, 0x04, 0x01, 0x01, "The scanner is loading or ejecting film. Wait until it is done."},
    {0x02, 0x04, 0x01, 0x02,
     "The scanner is measuring its correction data. Wait until it is done."},
    {0x02, 0x04, 0x01, kAny, "The scanner is busy. Wait until it is done."},
    {0x02, 0x04, 0x02, kAny,
     "The scanner's mechanism failed. Switch it off, wait ten seconds and switch it on again."},
    {0x02, 0x04, 0x03, 0x00,
     "No adapter is in the scanner. Push the film adapter in until it locks."},
    {0x02, 0x04, 0x03, 0x01, "The door of the APS adapter is not fully open. Open it."},
    {0x02, 0x04, 0x03, 0x02, "The scanner does not know this adapter. Use another one."},
    {0x02, 0x04, 0x03, 0x03,
     "The film gate at the back of the roll adapter is closed, and the roll has six frames or "
     "more. Open the gate."},
    {0x02, 0x04, 0x03, 0x04,
     "The film adapter was pulled out a little. Push it in until it locks."},
    {0x02, 0x04, 0x03, kAny, "The holder or its mask is not in place. Set it and try again."},
    {0x02, 0x05, 0x00, kAny,
     "The scanner is still starting up. Wait until its lamp stops blinking."},
    {0x02, 0x3A, 0x00, 0x00, "The slide feeder is empty. Fill it."},
    {0x02, 0x3A, 0x00, 0x03,
     "The scanner cannot read this film: its perforations or its length are out of the standard. "
     "Use a slide mount or the film holder."},
    {0x02, 0x3A, 0x00, 0x04, "The film has no frame with that number. Choose an earlier frame."},
    {0x02, 0x3A, kAny, kAny, "No film is in the scanner. Put film in."},
    {0x03, kAny, kAny, kAny,
     "The scanner cannot read the film. Take the film out, check it, and put it in again."},
    {0x04, 0x53, kAny, kAny,
     "The scanner failed to load or eject the film. Do not pull: switch the scanner off, wait ten "
     "seconds and switch it on again."},
    {0x04, 0x60, kAny, kAny,
     "A lamp of the scanner failed. Switch it off and on; if it happens again it needs service."},
    {0x04, 0x62, kAny, kAny,
     "The scan head failed to move. Switch the scanner off and on; if it happens again it needs "
     "service."},
    {0x04, kAny, kAny, kAny,
     "The scanner reports a hardware failure. Switch it off, wait ten seconds and switch it on "
     "again; if it happens again it needs service."},
    {0x05, 0x20, kAny, kAny, "The scanner does not know this command; this model cannot do that."},
    {0x05, 0x26, 0x02, kAny, "The scanner refused this combination of colours."},
    {0x05, 0x2C, 0x02, kAny, "The scanner refused this combination of scan settings."},
    {0x05, 0x2C, kAny, kAny,
     "The scanner refused the command because it is in the middle of something else, often a scan "
     "that another program left open. Try again; if that fails, switch it off and on."},
    {0x05, kAny, kAny, kAny, "The scanner refused a setting that it does not support."},
    {0x06, 0x28, kAny, kAny, "The film was changed. Start again."},
    {0x06, 0x29, kAny, kAny, "The scanner was switched on or reset. Start again."},
    {0x06, 0x2A, kAny, kAny, "Another program changed the scanner's settings. Close it."},
    {0x06, 0x3F, kAny, kAny, "The adapter or the film was changed. Start again."},
    {0x06, kAny, kAny, kAny, "The scanner's state changed. Start again."},
    {0x09, kAny, kAny, kAny, "The scanner asks the program for help with the image data."},
    {0x0B, 0x3E, kAny, kAny,
     "The scanner is still starting up. Wait until its lamp stops blinking."},
    {0x0B, 0x4B, kAny, kAny, "The scanner delivered less data than it had promised. Scan again."},
    {0x0B, kAny, kAny, kAny, "The scanner gave up the command. Scan again."},
};

bool matches(int expected, int actual) { return expected == kAny || expected == actual; }

DeviceError::Kind kind_of(const Sense& sense) {
  if (sense.no_medium()) return DeviceError::Kind::kNoMedium;
  switch (static_cast<SenseKey>(sense.key)) {
    case SenseKey::kNotReady:
      return sense.is(2, 4, 2) ? DeviceError::Kind::kHardware : DeviceError::Kind::kBusy;
    case SenseKey::kMedium:
    case SenseKey::kHardware:
    case SenseKey::kAborted:
      return DeviceError::Kind::kHardware;
    case SenseKey::kIllegalRequest:
      return DeviceError::Kind::kRefused;
    default:
      return DeviceError::Kind::kProtocol;
  }
}

}  // namespace

std::string Sense::code() const {
  std::array<char, 16> text{};
  std::snprintf(text.data(), text.size(), "%02X/%02X/%02X:%02X", unsigned{key}, unsigned{asc},
                unsigned{ascq}, unsigned{tsc});
  return text.data();
}

std::string sentence_of(const Sense& sense) {
  for (const Meaning& meaning : kMeanings) {
    if (matches(meaning.key, sense.key) && matches(meaning.asc, sense.asc) &&
        matches(meaning.ascq, sense.ascq) && matches(meaning.tsc, sense.tsc)) {
      return std::string(meaning.sentence) + " [" + sense.code() + "]";
    }
  }
  return "The scanner answered with a code that this program does not know. [" + sense.code() + "]";
}

DeviceError sense_error(const Sense& sense, const std::string& operation) {
  return {kind_of(sense), sentence_of(sense), operation + " → " + sense.code()};
}

}  // namespace reseau
