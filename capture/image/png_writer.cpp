#include "capture/image/png_writer.h"

#include <array>
#include <cmath>
#include <csetjmp>
#include <cstdio>
#include <system_error>

#include <png.h>

#include "core/base/check.h"

namespace reseau {

// Grain hardly compresses: higher levels cost seconds and save little.
constexpr int kCompressionLevel = 3;

struct PngWriter::State {
  const PartFile& file;
  std::uint64_t position = 0;
  int error = 0;
  std::array<char, 200> message{};
  png_structp png = nullptr;
  png_infop info = nullptr;
  std::size_t row_bytes = 0;

  explicit State(const PartFile& part) : file(part) {}
  ~State() { png_destroy_write_struct(&png, &info); }
  State(const State&) = delete;
  State& operator=(const State&) = delete;

  // libpng is C: it must not be left by an exception, so failures jump to the setjmp of call().
  static void on_write(png_structp png, png_bytep data, png_size_t n) {
    auto* state = static_cast<State*>(png_get_io_ptr(png));
    state->file.write_some_at(state->position, std::as_bytes(std::span(data, n)), state->error);
    if (state->error != 0) png_error(png, "write");
    state->position += n;
  }
  static void on_flush(png_structp /*png*/) {}
  [[noreturn]] static void on_error(png_structp png, png_const_charp text) {
    auto* state = static_cast<State*>(png_get_error_ptr(png));
    std::snprintf(state->message.data(), state->message.size(), "%s", text);
    png_longjmp(png, 1);
  }
  static void on_warning(png_structp /*png*/, png_const_charp /*text*/) {}

  // `action` must own nothing: a jump would not destroy it.
  template <typename Action>
  void call(const Action& action) {
    if (setjmp(png_jmpbuf(png)) == 0) {
      action();
      return;
    }
    if (error != 0) file.throw_write_error(error);
    throw std::system_error(std::make_error_code(std::errc::io_error),
                            std::string("The PNG picture cannot be written: ") + message.data());
  }
};

PngWriter::PngWriter(const PartFile& file, int width_px, int height_px, double dpi)
    : state_(std::make_unique<State>(file)) {
  CHECK(width_px > 0 && height_px > 0);
  State& s = *state_;
  s.row_bytes = static_cast<std::size_t>(width_px) * 3;
  s.png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &s, State::on_error, State::on_warning);
  CHECK(s.png != nullptr);
  s.info = png_create_info_struct(s.png);
  CHECK(s.info != nullptr);
  s.call([&] {
    png_set_write_fn(s.png, &s, State::on_write, State::on_flush);
    png_set_user_limits(s.png, 0x7FFFFFFF, 0x7FFFFFFF);
    png_set_compression_level(s.png, kCompressionLevel);
    png_set_filter(s.png, PNG_FILTER_TYPE_BASE, PNG_FILTER_SUB);
    png_set_IHDR(s.png, s.info, static_cast<png_uint_32>(width_px),
                 static_cast<png_uint_32>(height_px), 8, PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_set_sRGB_gAMA_and_cHRM(s.png, s.info, PNG_sRGB_INTENT_RELATIVE);
    if (dpi > 0) {
      const auto per_metre = static_cast<png_uint_32>(std::lround(dpi / 0.0254));
      png_set_pHYs(s.png, s.info, per_metre, per_metre, PNG_RESOLUTION_METER);
    }
    png_write_info(s.png, s.info);
  });
}

PngWriter::~PngWriter() = default;

void PngWriter::row(std::span<const std::uint8_t> rgb) {
  CHECK(rgb.size() == state_->row_bytes);
  state_->call([&] { png_write_row(state_->png, rgb.data()); });
}

void PngWriter::finish() {
  state_->call([&] { png_write_end(state_->png, state_->info); });
}

}  // namespace reseau
