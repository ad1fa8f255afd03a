#include "drivers/sim/unit_model.h"

#include "core/base/error.h"

namespace reseau::sim {
namespace {

constexpr Exposures kLs5000Default{0x010cbf, 0xe4b6, 0xa19a, 0x0484d1};

constexpr std::string_view kC1Ls5000 =
    "06C10053 03 003D 000F 0000 0100 01 01 00 03 31 0FA0 0FA0 005A 00000000 00000000 00000000 "
    "00000F6A 0FA0 0FA0 005A 00000000 00000000 00000000 00001747 00001747 00000000 0061 0061 "
    "28 00 0000 0143 0000 10 0F6A 01 02";
constexpr std::string_view kC1Ls50 =
    "06C10053 03 003A 000F 0000 0040 01 01 00 01 31 0FA0 0FA0 005A 00000000 00000000 00000000 "
    "00000F6A 0FA0 0FA0 005A 00000000 00000000 00000000 00001747 00001747 00000000 0061 0061 "
    "06 00 0000 0143 0000 0E 0F6A 00 01";
constexpr std::string_view kC1Ls40 =
    "06C10051 03 003A 000F 0000 0040 01 01 00 01 31 0B54 0B54 005A 00000000 00000000 00000000 "
    "00000B36 0B54 0B54 005A 00000000 00000000 00000000 000010E0 000010E0 00000000 0061 0061 "
    "06 00 0000 0143 0000 0C 0B36";
constexpr std::string_view kC1FirstGeneration =
    "06C10051 00 003A 000F 0000 0040 01 01 00 01 22 0A8C 0A8C 005A 00000000 00000000 00000000 "
    "00000A70 0A8C 0A8C 005A 00000F3E 00000000 00000000 00000F3F 00000000 00000000 0000 0000 "
    "01 01 0000 01C2 0000 0C 0A70";
constexpr std::string_view kC1Ls8000 =
    "06C10052 01 003A 000F 0000 0100 01 01 10 42 12 0FA0 0FA0 029A 0000270F 00000000 00000000 "
    "00002710 0FA0 0FA0 014D 00003623 00000000 00000000 00003624 00000000 00000000 0053 0053 "
    "00 00 0000 01C2 0000 0E 2710 0C";
constexpr std::string_view kC1Ls9000 =
    "06C10057 01 003A 000F 0000 0100 01 01 18 42 12 0FA0 0FA0 029A 0000270F 00000000 00000000 "
    "00002304 0FA0 0FA0 014D 00008753 00000000 00000000 00003378 00000000 00000000 0053 0053 "
    "00 00 0000 01C2 0000 10 2710 0C 03 00000000";
constexpr std::string_view kE1Ls50 =
    "06E10023 81 04 8C 90 90 DA 73 00 0E 0E 00 00 00 00 0E 00 0300 0000 0100 1900 0300 4500 0000 "
    "0000 0C 04 00";

// Pages that nobody has published (D1 and E1 of LS-40 and LS-4000, all but C1 of LS-8000 and
// LS-9000, everything of LS-30 and LS-2000) are those of the nearest relative with the model's own
// depths.
const std::vector<UnitModel>& models() {
  static const std::vector<UnitModel> table = [] {
    std::vector<UnitModel> t;
    UnitModel ls5000;
    ls5000.name = "ls5000";
    ls5000.product = "LS-5000 ED";
    ls5000.revision = "1.03";
    ls5000.product_id = 0x4002;
    ls5000.bcd_device = 0x0103;
    // UNVERIFIED(page D1 names 16 alone): SANE scans with 8 unless it is told otherwise.
    ls5000.depths_bits = {8, 16};
    ls5000.descriptor_bytes = 53;
    ls5000.descriptor_list_bytes = 61;
    ls5000.window_reply_tag = 0x0fa0;
    ls5000.pitch_rule = PitchRule::kOneOrEven;
    ls5000.scan_modes = 0x52;
    ls5000.interleavings = 0x42;
    ls5000.multi_reading = true;
    ls5000.has_ccd_curves = true;
    ls5000.default_exposure = kLs5000Default;
    ls5000.white_balance_exposure = {0xe27c, 0xbce4, 0x8056, 0x05055a};
    ls5000.sensor_lines = 2;
    ls5000.page_c1 = kC1Ls5000;
    ls5000.page_d1 = "06D10018 03 52 42 46 20 43 20 00 00 00 40 09 04 00000001 03FFFFFF 00 00 00";
    ls5000.page_e1 =
        "06E10023 83 0C 80 B0 90 DA 7B 00 00 00 00 00 00 00 10 00 0300 0000 0100 1900 "
        "0300 4500 0000 0000 0C 04 00";
    ls5000.page_list = "00014041AA5051606162C1D1E1E3F0F8E2FBFC";

    // No exposures of an LS-50 are recorded; the LS-5000's defaults stand in for both.
    UnitModel ls50;
    ls50.name = "ls50";
    ls50.product = "LS-50 ED";
    ls50.revision = "1.02";
    ls50.product_id = 0x4001;
    ls50.bcd_device = 0x0102;
    ls50.adc_bits = 14;
    ls50.depths_bits = {8, 14};
    ls50.has_lut = true;
    ls50.default_exposure = ls50.white_balance_exposure = kLs5000Default;
    ls50.page_c1 = kC1Ls50;
    ls50.page_d1 = "06D10018 03 46 02 46 20 43 12 00 00 00 40 09 04 00000001 03FFFFFF 00 00 00";
    ls50.page_e1 = kE1Ls50;
    ls50.page_list = "00014041AA50516061C1D1E1F0E2F8FBFC";

    UnitModel ls40 = ls50;
    ls40.name = "ls40";
    ls40.product = "LS-40 ED";
    ls40.revision = "1.20";
    ls40.link = LinkKind::kUsbFullSpeed;
    ls40.product_id = 0x4000;
    ls40.bcd_device = 0x0120;
    ls40.adc_bits = 12;
    ls40.depths_bits = {8, 12};
    ls40.optical_dpi = 2900;
    ls40.sensor_px = 2870;
    ls40.frame_height_px = 4320;
    ls40.mount_height_px = 4203;
    ls40.thumbnail_step_px = 30;
    ls40.pulse_px = 5;
    ls40.loses_busy_commands = ls40.hates_status_request = ls40.line_per_transfer = true;
    ls40.page_c1 = kC1Ls40;
    ls40.page_d1 = "06D10018 03 46 02 46 20 43 0A 00 00 00 40 09 04 00000001 03FFFFFF 00 00 00";
    ls40.page_e1 =
        "06E10023 81 04 8C 90 90 DA 73 00 0C 0C 00 00 00 00 0C 00 0300 0000 0100 1900 0300 4500 "
        "0000 0000 0C 04 00";

    UnitModel ls4000 = ls50;
    ls4000.name = "ls4000";
    ls4000.product = "LS-4000 ED";
    ls4000.revision = "1.10";
    ls4000.link = LinkKind::kScsi;
    ls4000.product_id = 0;
    ls4000.scan_modes = 0x56;
    ls4000.multi_reading = true;
    ls4000.page_d1 = "06D10018 03 56 02 46 20 43 12 00 00 00 40 09 04 00000001 03FFFFFF 00 00 00";
    ls4000.page_e1 =
        "06E10023 83 04 8C 90 90 DA 73 00 0E 0E 00 00 00 00 0E 00 0300 0000 0100 1900 0300 4500 "
        "0000 0000 0C 04 00";

    UnitModel ls8000 = ls4000;
    ls8000.name = "ls8000";
    ls8000.product = "LS-8000 ED";
    ls8000.revision = "1.07";
    ls8000.depths_bits = {14};
    ls8000.pitch_rule = PitchRule::kDivisorsOfGap;
    ls8000.scan_modes = 0x16;
    ls8000.interleavings = 0x42;
    ls8000.sensor_px = 10000;
    ls8000.frame_height_px = ls8000.mount_height_px = 13860;
    ls8000.min_dpi = 333;
    ls8000.thumbnail_dpi = 83;
    ls8000.thumbnail_step_px = 48;
    ls8000.focus_max = 450;
    ls8000.sensor_lines = 3;
    ls8000.line_gap = 12;
    ls8000.stage_can_jam = true;
    ls8000.has_adapters = false;
    ls8000.page_c1 = kC1Ls8000;
    ls8000.page_d1 = "06D10018 1B 16 42 06 00 00 10 00 00 00 40 09 04 00000001 03FFFFFF 00 00 00";
    ls8000.page_e1 =
        "06E10022 83 05 AC 90 F0 3A 00 0E 0E 00 00 00 00 0E 00 0300 0600 0100 0900 0200 0100 0000 "
        "0000 02 04 00";
    ls8000.page_list = "000110C1C8D1E1F0F8FBFC";

    UnitModel ls9000 = ls8000;
    ls9000.name = "ls9000";
    ls9000.product = "LS-9000 ED";
    ls9000.revision = "1.01";
    ls9000.adc_bits = 16;
    ls9000.depths_bits = {16};
    ls9000.frame_height_px = ls9000.mount_height_px = 13176;
    ls9000.has_lut = false;
    ls9000.has_ccd_curves = true;
    ls9000.all_windows_only = true;
    ls9000.page_c1 = kC1Ls9000;
    ls9000.page_d1 = "06D10018 1B 16 42 06 00 00 20 00 00 00 40 09 04 00000001 03FFFFFF 00 00 00";
    ls9000.page_e1 =
        "06E10023 83 0D A0 80 F0 BA 48 00 00 00 00 00 00 00 10 00 0300 0600 0100 0900 0200 0100 "
        "0000 0000 02 04 00";
    ls9000.page_list = "000118C1C8D1E1F0F8FBFC";

    UnitModel ls2000;
    ls2000.name = "ls2000";
    ls2000.product = "LS-2000";
    ls2000.revision = "1.31";
    ls2000.link = LinkKind::kScsi;
    ls2000.adc_bits = 12;
    ls2000.depths_bits = {8, 12};
    ls2000.default_exposure = ls2000.white_balance_exposure = kLs5000Default;
    ls2000.optical_dpi = 2700;
    ls2000.sensor_px = 2672;
    ls2000.frame_height_px = ls2000.mount_height_px = 3903;
    ls2000.thumbnail_step_px = 28;
    ls2000.pulse_px = 5;
    ls2000.focus_max = 450;
    ls2000.even_planes = false;
    ls2000.has_adapters = false;
    ls2000.page_c1 = kC1FirstGeneration;
    ls2000.page_list = "00C1";

    UnitModel ls30 = ls2000;
    ls30.name = "ls30";
    ls30.product = "COOLSCANIII";
    ls30.adc_bits = 10;
    ls30.depths_bits = {8, 10};

    t = {ls5000, ls50, ls40, ls4000, ls8000, ls9000, ls2000, ls30};
    return t;
  }();
  return table;
}

}  // namespace

const UnitModel* find_unit_model(std::string_view name) {
  for (const UnitModel& model : models()) {
    if (model.name == name) return &model;
  }
  return nullptr;
}

const UnitModel& unit_model(std::string_view name) {
  std::string known;
  for (const UnitModel& model : models()) {
    if (model.name == name) return model;
    known.append(known.empty() ? "" : ", ").append(model.name);
  }
  throw InputError("There is no simulated model named \"" + std::string(name) +
                   "\". Known models: " + known + ".");
}

std::vector<std::string> unit_model_names() {
  std::vector<std::string> names;
  for (const UnitModel& model : models()) names.emplace_back(model.name);
  return names;
}

}  // namespace reseau::sim
