#!/usr/bin/env python3
"""The rules of the house that a compiler does not check. Python 3 standard library only.

    house_rules.py ROOT     prints one line per breach, exits 1 when there is one

house_rules_test.py shows that each rule can fail.
"""
import pathlib
import re
import sys

CXX = {".h", ".cpp", ".inc"}
TEXT = CXX | {".py", ".cmake", ".sh", ".js", ".html", ".css"}
MODULES = ("core", "drivers", "calibration", "capture", "tests")
TOP_LEVEL = {"CMakeLists.txt", "LICENSE", "README.md", "calibration", "capture", "core", "drivers",
             "tests", "udev"}
MOST_LINES = 800

# Who may include whom: the first pattern that fits the including file decides.
SEAM_OF_DRIVERS = r"drivers/(scanner|scan_plan|registry|export_unit|sessions)\.h"
INCLUDE_TABLE = [
    (r"tests/", r".*"),
    (r"core/", r"core/"),
    (r"drivers/sim/", r"core/(base|line)/|core/screen/screen_description\.h$|drivers/"),
    (r"drivers/", r"core/(base|line)/|drivers/"),
    (r"calibration/", r"core/|calibration/"),
    (r"capture/(cli/verb_simulate\.cpp$|simulate/|bench/)",
     r"core/|drivers/sim/(simulate|sensor)\.h|" + SEAM_OF_DRIVERS + r"|capture/"),
    (r"capture/cli/", r"core/|" + SEAM_OF_DRIVERS + r"|calibration/|capture/"),
    (r"capture/", r"core/|" + SEAM_OF_DRIVERS + r"|calibration/profile/|capture/"),
]

# Headers of libraries and systems: (header, the files that may include it, the reason).
HEADER_RULES = [
    (r"libusb.*", r"drivers/usb/libusb_(transport|flights)\.cpp$",
     "libusb is used in drivers/usb/libusb_*.cpp only"),
    (r"tbb/.*", r"core/base/parallel\.cpp$", "oneTBB is used in one file only: core/base/parallel.h"),
    (r"(ceres|glog)/.*", r"(calibration/(?!profile/).*\.cpp|tests/.*)$",
     "Ceres is used in .cpp files of calibration only"),
    (r"fstream|iostream|filesystem|fcntl\.h|unistd\.h|stdio\.h|sys/.*",
     r"(drivers|calibration|capture|tests)/", "core reads and writes no files"),
    (r"cstdio", r"(drivers|calibration|capture|tests)/|core/base/check\.h$",
     "core reads and writes no files"),
]

# Lines that no file of these kinds may hold: (files, pattern, the reason).
LINE_RULES = [
    (r"(core|drivers|calibration|capture)/.*\.(h|cpp)$", r"(?<![\w.:])assert\s*\(",
     "use CHECK, which also works in release builds, or DCHECK in loops over pixels"),
    (r"tests/.*\.(h|cpp)$", r"\bthis_thread::sleep_|\busleep\s*\(",
     "tests do not sleep; wait for a condition, or give the code a clock of the test"),
    (r".*(CMakeLists\.txt|\.cmake)$", r"-Ofast|-ffast-math|-march=native",
     "results must be the same on every machine"),
    (r".*\.(h|cpp)$", r"^\s*using namespace (?!std::(chrono|string|numbers)?_?literals)",
     "name what is used"),
]

INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]')


def files_below(root):
    for module in MODULES:
        for path in sorted((root / module).rglob("*")):
            if path.is_file():
                yield path, path.relative_to(root).as_posix()


def includes_of(lines):
    for number, line in enumerate(lines, 1):
        found = INCLUDE.match(line)
        if found:
            yield number, found.group(1), found.group(2)


def check_project_include(root, name, target):
    allowed = next(pattern for who, pattern in INCLUDE_TABLE if re.match(who, name))
    if target.split("/")[0] not in MODULES:
        return f'"{target}" does not start at the top of the project; write "module/folder/file.h"'
    if not re.match(allowed, target):
        return f'"{target}" is not for this module; see the include table in README.md'
    if not target.endswith(".inc") and not (root / target).is_file():
        return f'"{target}" does not exist'
    return None


def check_library_include(name, target):
    for header, allowed, reason in HEADER_RULES:
        if re.fullmatch(header, target) and not re.match(allowed, name):
            return f"<{target}>: {reason}"
    return None


def check_source(root, name, text):
    lines = text.split("\n")
    for number, kind, target in includes_of(lines):
        breach = (check_project_include(root, name, target) if kind == '"'
                  else check_library_include(name, target))
        if breach:
            yield f"{name}:{number}: {breach}"
    if name.endswith(".h") and "#pragma once" not in lines:
        yield f"{name}:1: a header starts with #pragma once"


def check_lines(name, text):
    for files, pattern, reason in LINE_RULES:
        if not re.match(files, name):
            continue
        for number, line in enumerate(text.split("\n"), 1):
            if re.search(pattern, line.split("//")[0]):
                yield f"{name}:{number}: {reason}"


def fenced_blocks(text, language):
    return re.findall(r"^```" + language + r"\n(.*?)^```$", text, re.M | re.S)


def check_readme(root):
    """The two commands a newcomer types stand first; links lead to something."""
    readme = root / "README.md"
    if not readme.is_file():
        yield "README.md: is missing"
        return
    text = readme.read_text(encoding="utf-8")
    commands = fenced_blocks(text, "sh")
    if len(commands) < 2 or "reseau scan" not in commands[0] or "ctest" not in commands[1]:
        yield ("README.md: the first two sh blocks must be the command that makes a picture "
               "(reseau scan) and the command that tests (ctest)")
    for command in commands[:2]:
        if len(command.strip().split("\n")) != 1:
            yield "README.md: each of the first two sh blocks holds exactly one command line"
        for script in re.findall(r"(?<![\w/])\.ci/\w+", command):
            if not (root / script).is_file():
                yield f"README.md: {script} does not exist"
    for target in re.findall(r"\]\(([^)#\s]+)(?:#[^)]*)?\)", text):
        if "://" not in target and not (root / target).exists():
            yield f"README.md: the link to {target} leads nowhere"


def check_top_level(root):
    for path in sorted(root.iterdir()):
        if path.name.startswith(".") or path.name in TOP_LEVEL or path.name.startswith("build"):
            continue
        if path.is_dir() and path.name == "out":  # what the first command of the README writes
            continue
        yield f"{path.name}: does not belong at the top level"


def check(root):
    breaches = list(check_top_level(root)) + list(check_readme(root))
    for path, name in files_below(root):
        if path.suffix not in TEXT and path.name != "CMakeLists.txt":
            continue
        text = path.read_text(encoding="utf-8")
        n_lines = text.count("\n")
        if n_lines > MOST_LINES:
            breaches.append(f"{name}:{n_lines}: a file has at most {MOST_LINES} lines; split it")
        if path.suffix in CXX:
            breaches += check_source(root, name, text)
        breaches += check_lines(name, text)
    return breaches


def main():
    if len(sys.argv) != 2:
        sys.exit("usage: house_rules.py ROOT")
    breaches = check(pathlib.Path(sys.argv[1]))
    for breach in breaches:
        print(breach)
    sys.exit(1 if breaches else 0)


if __name__ == "__main__":
    main()
