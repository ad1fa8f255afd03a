#include "capture/bench/registration_cases.h"

#include <fmt/format.h>

namespace reseau {

std::vector<RegistrationCase> registration_bars() {
  std::vector<RegistrationCase> cases;
  const auto add = [&](std::string name, std::string film, double bar, bool lit_only = false) {
    cases.push_back({std::move(name), "width_px=1000&height_px=1000&" + std::move(film), bar,
                     lit_only, "bars"});
  };
  const char* scenes[] = {"chart", "natural"};
  int turn = 0;
  for (const int angle : {-90, -67, -45, -22, 0, 23, 45, 68, 90}) {
    const char* scene = scenes[turn % 2];
    add(fmt::format("flat, {}, {} deg{}", scene, angle, turn % 3 == 1 ? ", mirrored" : ""),
        fmt::format("scene={}&angle={}&mirrored={}&blur_px=0.6&ir_blur_px=0.7&noise=0.006", scene,
                    angle, turn % 3 == 1 ? 1 : 0),
        0.01);
    ++turn;
  }
  for (const char* scene : scenes) {
    add(fmt::format("flat, {}, blur 1.0", scene),
        fmt::format("scene={}&angle=23&blur_px=1.0&ir_blur_px=1.1&noise=0.002", scene), 0.01);
    for (const int angle : {0, 23, 45}) {
      add(fmt::format("flat, {}, blur 1.5, {} deg", scene, angle),
          fmt::format("scene={}&angle={}&blur_px=1.5&ir_blur_px=1.5&noise=0.006", scene, angle),
          0.01);
    }
    add(fmt::format("flat, {}, infrared blurrier", scene),
        fmt::format("scene={}&angle=23&blur_px=1.2&ir_blur_px=1.5&noise=0.004", scene), 0.01);
    add(fmt::format("{}, blur 2.5", scene),
        fmt::format("scene={}&angle=23&blur_px=2.5&ir_blur_px=2.5&noise=0.002", scene), 0.05);
    add(fmt::format("{}, noise 4 %", scene),
        fmt::format("scene={}&angle=23&blur_px=0.6&noise=0.04", scene), 0.05);
    add(fmt::format("{}, bend 2 px / 900 px", scene),
        fmt::format("scene={}&angle=23&warp_px=2&warp_length_px=900", scene), 0.02);
    add(fmt::format("{}, bend 6 px / 700 px, lens", scene),
        fmt::format("scene={}&angle=23&warp_px=6&warp_length_px=700&radial=-0.006", scene), 0.03);
    add(fmt::format("{}, warp 4 px / 90 px", scene),
        fmt::format("scene={}&angle=23&warp_px=4&warp_length_px=90", scene), 0.15);
    add(fmt::format("{}, wobble 0.6 px / 60 lines", scene),
        fmt::format("scene={}&angle=23&wave_px=0.6&wave_lines=60", scene), 0.03);
    add(fmt::format("{}, wobble 0.7 px / 220 lines", scene),
        fmt::format("scene={}&angle=23&wave_px=0.7&wave_lines=220", scene), 0.02);
    add(fmt::format("{}, 2000 ppi", scene),
        fmt::format("scene={}&angle=23&period_u_um=24.8&period_v_um=24.95", scene), 0.02);
    add(fmt::format("{}, 1600 ppi", scene),
        fmt::format("scene={}&angle=23&period_u_um=20&period_v_um=20.1", scene), 0.05);
    add(fmt::format("{}, faded to 10 %, noise 1.2 %", scene),
        fmt::format("scene={}&angle=23&fade=0.9&noise=0.012", scene), 0.08);
    add(fmt::format("{}, dust and scratches", scene),
        fmt::format("scene={}&angle=23&dust=400&dust_um=60&scratches=20", scene), 0.04, true);
  }
  add("chart, 40 % black", "scene=chart&angle=23&border_px=112", 0.04, true);
  return cases;
}

std::vector<RegistrationCase> registration_sweeps() {
  std::vector<RegistrationCase> cases;
  const auto add = [&](const char* group, std::string name, std::string film) {
    cases.push_back({std::move(name), "width_px=800&height_px=800&scene=natural&" + std::move(film),
                     0, false, group});
  };
  for (const double blur : {0.3, 0.6, 1.0, 1.5, 2.0, 2.5, 3.0}) {
    add("blur", fmt::format("blur {} px", blur),
        fmt::format("angle=23&blur_px={0}&ir_blur_px={0}", blur));
  }
  for (const double noise : {0.001, 0.006, 0.012, 0.04, 0.08}) {
    add("noise", fmt::format("noise {} %", 100 * noise), fmt::format("angle=23&noise={}", noise));
  }
  for (const int angle : {-80, -45, -10, 0, 10, 23, 45, 67, 90}) {
    add("angle", fmt::format("{} deg", angle), fmt::format("angle={}", angle));
  }
  for (const double um : {20.0, 25.0, 35.0, 50.0, 80.0, 110.0}) {
    add("period", fmt::format("{:.1f} px", um / 6.35), fmt::format("angle=23&period_um={}", um));
  }
  for (const double fade : {0.0, 0.6, 0.9, 0.95}) {
    add("fading", fmt::format("faded by {:.0f} %", 100 * fade),
        fmt::format("angle=23&fade={}&noise=0.006", fade));
  }
  for (const int border : {12, 90, 180, 250}) {
    const double side = 800.0 - 2 * border;
    add("black", fmt::format("{:.0f} % dark", 100 - side * side / 6400),
        fmt::format("angle=23&border_px={}", border));
  }
  for (const int length : {90, 200, 400, 900}) {
    add("deformation", fmt::format("warp 3 px / {} px", length),
        fmt::format("angle=23&warp_px=3&warp_length_px={}", length));
  }
  for (const double jitter : {0.05, 0.2}) {
    add("jitter", fmt::format("jitter {} px", jitter),
        fmt::format("angle=23&jitter_px={}", jitter));
  }
  for (const int lines : {30, 60, 120, 220}) {
    add("jitter", fmt::format("wobble 0.7 px / {} lines", lines),
        fmt::format("angle=23&wave_px=0.7&wave_lines={}", lines));
  }
  for (const int size : {128, 256, 512, 1600}) {
    cases.push_back({fmt::format("{0} x {0} px", size),
                     fmt::format("width_px={0}&height_px={0}&scene=natural&angle=23", size), 0,
                     false, "size"});
  }
  return cases;
}

}  // namespace reseau
