#include "capture/store/master_xmp.h"

#include <array>
#include <charconv>
#include <utility>
#include <vector>

#include "core/line/channel_name.h"

namespace reseau {
namespace {

constexpr std::string_view kNamespace = "urn:reseau:capture:1#";
constexpr std::array<const char*, 4> kExposureNames = {"exposureRed_us", "exposureGreen_us",
                                                       "exposureBlue_us", "exposureInfrared_us"};
constexpr std::array<std::pair<char, std::string_view>, 5> kEntities = {
    {{'&', "&amp;"}, {'<', "&lt;"}, {'>', "&gt;"}, {'"', "&quot;"}, {'\'', "&apos;"}}};

std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    bool replaced = false;
    for (const auto& [plain, entity] : kEntities) {
      if (c != plain) continue;
      out += entity;
      replaced = true;
    }
    // XML 1.0 has no control characters.
    if (!replaced) out += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
  }
  return out;
}

std::string unescaped(std::string_view text) {
  std::string out;
  while (!text.empty()) {
    bool replaced = false;
    for (const auto& [plain, entity] : kEntities) {
      if (!text.starts_with(entity)) continue;
      out += plain;
      text.remove_prefix(entity.size());
      replaced = true;
      break;
    }
    if (replaced) continue;
    out += text.front();
    text.remove_prefix(1);
  }
  return out;
}

// Shortest text that reads back as the same number.
template <typename Number>
std::string number_text(Number value) {
  std::array<char, 40> buffer{};
  const auto result = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value);
  return {buffer.data(), result.ptr};
}

template <typename Number>
std::optional<Number> number_from(const std::optional<std::string>& text) {
  Number value{};
  if (!text || text->empty()) return std::nullopt;
  const auto result = std::from_chars(text->data(), text->data() + text->size(), value);
  if (result.ec != std::errc() || result.ptr != text->data() + text->size()) return std::nullopt;
  return value;
}

// IPTC digital source types; a film that may be either is left out.
std::string_view source_type(std::string_view film) {
  if (film.empty() || film == "bw" || film == "none") return {};
  if (film == "c41" || film == "negative") {
    return "http://cv.iptc.org/newscodes/digitalsourcetype/negativeFilm";
  }
  return "http://cv.iptc.org/newscodes/digitalsourcetype/positiveFilm";
}

std::optional<std::string> attribute(std::string_view packet, const std::string& name) {
  const std::string key = " reseau:" + name + "=\"";
  const auto begin = packet.find(key);
  if (begin == std::string_view::npos) return std::nullopt;
  const auto value = begin + key.size();
  const auto end = packet.find('"', value);
  if (end == std::string_view::npos) return std::nullopt;
  return unescaped(packet.substr(value, end - value));
}

}  // namespace

std::string make_master_xmp(const LineFormat& format, const CaptureContext& context,
                            const std::string& film) {
  std::vector<std::pair<std::string, std::string>> settings = {
      {"schema", "1"},
      {"transfer", "linear"},
      {"significantBits", number_text(format.significant_bits)},
      {"device", context.device_name},
      {"make", context.make},
      {"model", context.model},
      {"firmware", context.firmware},
      {"serial", context.serial},
      {"holder", context.holder},
      {"startedAt", context.started_at_utc},
      {"film", film}};
  if (context.focus_position) {
    settings.emplace_back("focusPosition", number_text(*context.focus_position));
  }
  for (std::size_t i = 0; i < kExposureNames.size(); ++i) {
    if (context.exposure_us[i]) {
      settings.emplace_back(kExposureNames[i], number_text(*context.exposure_us[i]));
    }
  }

  std::string xmp =
      "<?xpacket begin=\"\xEF\xBB\xBF\" id=\"W5M0MpCehiHzreSzNTczkc9d\"?>\n"
      "<x:xmpmeta xmlns:x=\"adobe:ns:meta/\">\n"
      "<rdf:RDF xmlns:rdf=\"http://www.w3.org/1999/02/22-rdf-syntax-ns#\">\n"
      "<rdf:Description rdf:about=\"\"\n"
      " xmlns:Iptc4xmpExt=\"http://iptc.org/std/Iptc4xmpExt/2008-02-29/\"\n"
      " xmlns:reseau=\"" +
      std::string(kNamespace) + "\"";
  if (const auto type = source_type(film); !type.empty()) {
    xmp += "\n Iptc4xmpExt:DigitalSourceType=\"" + std::string(type) + "\"";
  }
  for (const auto& [name, value] : settings) {
    if (!value.empty()) xmp += "\n reseau:" + name + "=\"" + escaped(value) + "\"";
  }
  xmp += ">\n<reseau:channels><rdf:Seq>";
  for (const Channel channel : format.channels) {
    xmp += "<rdf:li>" + std::string(channel_name(channel)) + "</rdf:li>";
  }
  xmp +=
      "</rdf:Seq></reseau:channels>\n</rdf:Description>\n</rdf:RDF>\n</x:xmpmeta>\n"
      "<?xpacket end=\"r\"?>\n";
  return xmp;
}

std::optional<MasterXmp> read_master_xmp(std::string_view packet) {
  if (packet.find("xmlns:reseau=\"" + std::string(kNamespace) + "\"") == std::string_view::npos) {
    return std::nullopt;
  }
  const auto text = [&](const char* name) { return attribute(packet, name).value_or(""); };
  MasterXmp xmp;
  xmp.film = text("film");
  xmp.context.device_name = text("device");
  xmp.context.make = text("make");
  xmp.context.model = text("model");
  xmp.context.firmware = text("firmware");
  xmp.context.serial = text("serial");
  xmp.context.holder = text("holder");
  xmp.context.started_at_utc = text("startedAt");
  xmp.context.focus_position = number_from<int>(attribute(packet, "focusPosition"));
  for (std::size_t i = 0; i < kExposureNames.size(); ++i) {
    xmp.context.exposure_us[i] = number_from<double>(attribute(packet, kExposureNames[i]));
  }
  return xmp;
}

}  // namespace reseau
