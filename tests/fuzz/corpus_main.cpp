// corpus_main FOLDER: runs the fuzz target over every file of its corpus, over every beginning of
// each, and over a fixed row of damaged copies, where no libFuzzer is at hand. Prints the count.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

using Input = std::vector<std::uint8_t>;

Input read_file(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

long run_damaged(const Input& input, std::mt19937& random) {
  constexpr int kCopies = 300;
  long n = 0;
  for (; n < kCopies && !input.empty(); ++n) {
    Input copy = input;
    const auto at = [&](std::size_t size) { return static_cast<std::size_t>(random()) % size; };
    for (std::size_t flips = 1 + at(4); flips > 0; --flips) {
      copy[at(copy.size())] = static_cast<std::uint8_t>(random());
    }
    LLVMFuzzerTestOneInput(copy.data(), copy.size());
  }
  return n;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(argv[1])) {
    files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  std::mt19937 random(1);
  long n = 0;
  for (const auto& file : files) {
    const Input input = read_file(file);
    // Long ones at a step, so that a corpus stays a matter of seconds.
    const std::size_t step = 1 + input.size() / 500;
    for (std::size_t size = 0; size <= input.size(); size += step, ++n) {
      const Input beginning(input.begin(), input.begin() + static_cast<std::ptrdiff_t>(size));
      LLVMFuzzerTestOneInput(beginning.data(), beginning.size());
    }
    n += run_damaged(input, random);
  }
  std::printf("%ld inputs\n", n);
  return files.empty() ? 1 : 0;
}
