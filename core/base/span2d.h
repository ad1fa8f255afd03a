// A non-owning view of rows of samples. Row y starts at data + y * stride.
#pragma once

#include <cstddef>
#include <span>
#include <type_traits>

#include "core/base/check.h"

namespace reseau {

template <typename T>
class Span2D {
 public:
  Span2D() = default;
  Span2D(T* data, int width, int height, std::ptrdiff_t stride)
      : data_(data), width_(width), height_(height), stride_(stride) {
    CHECK(width >= 0 && height >= 0 && stride >= width);
  }
  Span2D(T* data, int width, int height) : Span2D(data, width, height, width) {}

  // A view of T converts to a view of const T.
  operator Span2D<const T>() const  // NOLINT(google-explicit-constructor): as std::span does
      requires(!std::is_const_v<T>) {
    return {data_, width_, height_, stride_};
  }

  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  [[nodiscard]] T* data() const { return data_; }
  [[nodiscard]] std::span<T> row(int y) const {
    DCHECK(y >= 0 && y < height_);
    return {data_ + y * stride_, static_cast<std::size_t>(width_)};
  }
  [[nodiscard]] T& operator()(int x, int y) const {
    DCHECK(x >= 0 && x < width_ && y >= 0 && y < height_);
    return data_[y * stride_ + x];
  }

 private:
  T* data_ = nullptr;
  int width_ = 0;
  int height_ = 0;
  std::ptrdiff_t stride_ = 0;
};

}  // namespace reseau
