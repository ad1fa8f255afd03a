// 3x3 matrices and 3-vectors of the colour path, double precision. Pure functions, reentrant.
#pragma once

#include <array>

namespace reseau {

using Vector3 = std::array<double, 3>;
using Matrix3 = std::array<double, 9>;  // row-major; acts on column vectors

inline constexpr Matrix3 kIdentity3{1, 0, 0, 0, 1, 0, 0, 0, 1};

[[nodiscard]] Vector3 multiply(const Matrix3& m, const Vector3& v);
[[nodiscard]] Matrix3 multiply(const Matrix3& a, const Matrix3& b);
// The same matrix with column j multiplied by factors[j].
[[nodiscard]] Matrix3 scale_columns(const Matrix3& m, const Vector3& factors);
[[nodiscard]] Matrix3 scale(const Matrix3& m, double factor);
[[nodiscard]] Vector3 column(const Matrix3& m, int index);
[[nodiscard]] Matrix3 from_columns(const Vector3& c0, const Vector3& c1, const Vector3& c2);
[[nodiscard]] double determinant(const Matrix3& m);

// The inverse; the matrix must be regular (CHECK): ask condition_number() first where it comes from
// a person.
[[nodiscard]] Matrix3 inverse(const Matrix3& m);

// Largest over smallest singular value: how much a relative error can grow when the matrix is
// inverted. Infinity for a singular matrix or one with an entry that is not finite.
[[nodiscard]] double condition_number(const Matrix3& m);

}  // namespace reseau
