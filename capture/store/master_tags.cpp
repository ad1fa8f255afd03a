#include <cctype>
#include <cmath>
#include <string>

#include "capture/image/icc.h"
#include "capture/store/master_layout.h"
#include "capture/store/master_xmp.h"
#include "core/line/channel_name.h"

namespace reseau {
namespace {

// "2026-11-22T10:15:00Z" to "2026:11:22 10:15:00"; empty for any other shape.
std::string tiff_date(const std::string& iso) {
  constexpr std::string_view kShape = "dddd-dd-ddTdd:dd:dd";
  if (iso.size() < kShape.size()) return {};
  for (std::size_t i = 0; i < kShape.size(); ++i) {
    const bool fits = kShape[i] == 'd' ? std::isdigit(static_cast<unsigned char>(iso[i])) != 0
                                       : iso[i] == kShape[i];
    if (!fits) return {};
  }
  std::string date = iso.substr(0, kShape.size());
  date[4] = date[7] = ':';
  date[10] = ' ';
  return date;
}

std::string describe(const LineFormat& format) {
  std::string text = "Film scan, linear, " + std::to_string(format.significant_bits) +
                     " significant bits. Samples:";
  const char* separator = " ";
  for (const Channel channel : format.channels) {
    text += separator;
    text += channel_name(channel);
    separator = ", ";
  }
  return text + ".";
}

}  // namespace

MasterTags make_master_tags(const LineFormat& format, const CaptureContext& context,
                            const std::string& film) {
  MasterTags tags;
  tags.description = describe(format);
  tags.make = context.make;
  tags.model = context.model;
  tags.software = "reseau " RESEAU_VERSION;
  tags.date_time = tiff_date(context.started_at_utc);
  tags.xmp = make_master_xmp(format, context, film);
  // A grey scan would contradict a profile of three colours.
  if (format.n_channels() >= 3) tags.icc = linear_scanner_icc();
  return tags;
}

}  // namespace reseau
