// Four floats that the compiler keeps in one register, for loops over pixels. Plain arithmetic in a
// fixed order: the same bytes from every compiler that obeys IEEE 754.
#pragma once

#include <cstring>

namespace reseau {

using Float4 = float __attribute__((vector_size(16)));

// Any alignment.
inline Float4 load4(const float* from) {
  Float4 v;
  std::memcpy(&v, from, sizeof v);
  return v;
}
inline void store4(float* to, Float4 v) { std::memcpy(to, &v, sizeof v); }
inline Float4 all4(float value) { return Float4{value, value, value, value}; }
inline float sum4(Float4 v) { return (v[0] + v[2]) + (v[1] + v[3]); }
// sum4 of each.
inline Float4 sums4(Float4 a, Float4 b, Float4 c, Float4 d) {
  const Float4 ab =
      __builtin_shufflevector(a, b, 0, 4, 1, 5) + __builtin_shufflevector(a, b, 2, 6, 3, 7);
  const Float4 cd =
      __builtin_shufflevector(c, d, 0, 4, 1, 5) + __builtin_shufflevector(c, d, 2, 6, 3, 7);
  return __builtin_shufflevector(ab, cd, 0, 1, 4, 5) + __builtin_shufflevector(ab, cd, 2, 3, 6, 7);
}

using Int4 = int __attribute__((vector_size(16)));

// Towards zero.
inline Int4 truncated(Float4 v) { return __builtin_convertvector(v, Int4); }
inline Float4 as_float(Int4 v) { return __builtin_convertvector(v, Float4); }

}  // namespace reseau
