#!/usr/bin/env python3
"""Shows that each rule of house_rules.py lets a clean tree pass and reports a breach."""
import pathlib
import tempfile
import unittest

import house_rules

README = """# reseau

```sh
.ci/install build && build/bin/reseau scan -d sim:ls5000 -o out
```

```sh
.ci/install build test && ctest --test-dir build
```

[core](core/base/a.h)
"""

CLEAN = {
    "README.md": README,
    "CMakeLists.txt": "project(x)\n",
    ".ci/install": "#!/bin/sh\n",
    "core/base/a.h": "#pragma once\n#include <vector>\n",
    "core/base/check.h": "#pragma once\n#include <cstdio>\n",
    "core/screen/b.h": '#pragma once\n#include "core/base/a.h"\n',
    "drivers/scanner.h": '#pragma once\n#include "core/base/a.h"\n',
    "drivers/usb/usb_transport.h": "#pragma once\n",
    "drivers/usb/libusb_transport.cpp":
        '#include "drivers/usb/usb_transport.h"\n#include <libusb.h>\n',
    "calibration/profile/profile.h": '#pragma once\n#include "core/screen/b.h"\n',
    "calibration/edge/fit.h": "#pragma once\n",
    "calibration/edge/fit.cpp": "#include <ceres/ceres.h>\n",
    "capture/session/s.h":
        '#pragma once\n#include "drivers/scanner.h"\n#include "calibration/profile/profile.h"\n',
    "capture/cli/main.cpp": '#include "calibration/edge/fit.h"\n#include <fstream>\n',
    "tests/unit/t.cpp": '#include "drivers/usb/usb_transport.h"\n',
    "tests/CMakeLists.txt": "",
    "udev/70-x.rules": "",
}


class HouseRules(unittest.TestCase):
    def breaches(self, changes):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            for name, text in {**CLEAN, **changes}.items():
                (root / name).parent.mkdir(parents=True, exist_ok=True)
                (root / name).write_text(text, encoding="utf-8")
            return house_rules.check(root)

    def expect_breach(self, name, text, word):
        found = self.breaches({name: text})
        self.assertEqual(len(found), 1, found)
        self.assertTrue(found[0].startswith(name), found)
        self.assertIn(word, found[0])

    def test_a_clean_tree_passes(self):
        self.assertEqual(self.breaches({}), [])

    def test_core_includes_core_only(self):
        self.expect_breach("core/base/x.cpp", '#include "drivers/scanner.h"\n', "include table")
        self.expect_breach("core/x.cpp", '#include "calibration/edge/fit.h"\n', "include table")

    def test_drivers_know_no_film(self):
        self.expect_breach("drivers/sim/x.cpp", '#include "core/screen/b.h"\n', "include table")

    def test_calibration_knows_no_driver(self):
        self.expect_breach("calibration/x.cpp", '#include "drivers/scanner.h"\n', "include table")

    def test_capture_sees_the_seam_of_drivers_only(self):
        self.expect_breach("capture/cli/x.cpp", '#include "drivers/usb/usb_transport.h"\n',
                           "include table")

    def test_only_the_command_line_sees_the_fits(self):
        self.expect_breach("capture/session/x.cpp", '#include "calibration/edge/fit.h"\n',
                           "include table")

    def test_includes_start_at_the_top(self):
        self.expect_breach("core/base/x.cpp", '#include "a.h"\n', "top of the project")

    def test_includes_exist(self):
        self.expect_breach("core/base/x.cpp", '#include "core/base/gone.h"\n', "does not exist")

    def test_libusb_has_one_home(self):
        self.expect_breach("drivers/usb/x.cpp", "#include <libusb.h>\n", "libusb_*.cpp")
        self.expect_breach("tests/unit/x.cpp", "#include <libusb-1.0/libusb.h>\n", "libusb_*.cpp")

    def test_ceres_stays_in_source_files_of_calibration(self):
        self.expect_breach("calibration/edge/x.h", "#pragma once\n#include <ceres/ceres.h>\n",
                           "Ceres")
        self.expect_breach("calibration/profile/x.cpp", "#include <ceres/ceres.h>\n", "Ceres")
        self.expect_breach("core/x.cpp", "#include <ceres/jet.h>\n", "Ceres")

    def test_core_has_no_files(self):
        for header in ("fstream", "filesystem", "cstdio", "iostream", "sys/mman.h"):
            self.expect_breach("core/x.cpp", f"#include <{header}>\n", "no files")

    def test_headers_are_guarded(self):
        self.expect_breach("core/x.h", "int x;\n", "pragma once")

    def test_files_stay_small(self):
        self.assertEqual(self.breaches({"core/x.cpp": "\n" * 800}), [])
        self.expect_breach("core/x.cpp", "\n" * 801, "800")
        self.expect_breach("tests/x.py", "\n" * 801, "800")

    def test_no_assert(self):
        self.expect_breach("core/x.cpp", "assert(x > 0);\n", "CHECK")
        self.assertEqual(self.breaches({"core/x.cpp": "static_assert(true);\n// assert(x)\n"}), [])

    def test_no_sleep_in_tests(self):
        self.expect_breach("tests/x.cpp", "std::this_thread::sleep_for(1s);\n", "sleep")

    def test_no_machine_dependent_arithmetic(self):
        self.expect_breach("tests/CMakeLists.txt", "add_compile_options(-ffast-math)\n", "machine")

    def test_no_using_namespace(self):
        self.expect_breach("core/x.cpp", "using namespace std;\n", "name what")
        self.assertEqual(
            self.breaches({"core/x.cpp": "using namespace std::chrono_literals;\n"}), [])

    def test_top_level_is_closed(self):
        found = self.breaches({"docs/x.md": ""})
        self.assertEqual(found, ["docs: does not belong at the top level"])

    def test_readme_holds_its_two_commands(self):
        self.expect_breach("README.md", "# reseau\n", "two sh blocks")
        self.expect_breach("README.md", README.replace("ctest", "ctest \\\n  "), "one command line")
        self.expect_breach("README.md", README.replace(".ci/install build test",
                                                       ".ci/gone build test"), ".ci/gone does not exist")

    def test_readme_links_lead_somewhere(self):
        self.expect_breach("README.md", README + "[x](core/gone.md)\n", "leads nowhere")


if __name__ == "__main__":
    unittest.main()
