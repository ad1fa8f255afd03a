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

}  // namespace reseau
