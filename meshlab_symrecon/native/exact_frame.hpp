// Sites as integers in one common unit, so that determinants of them can be evaluated exactly.
//
// Every finite double is m * 2^e with odd m. With e0 the least exponent of the coordinates, and no more than half the
// least exponent of the weights, x * 2^-e0 and w * 4^-e0 are integers for all the sites involved.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "exact_integer.hpp"
#include "site.hpp"

namespace symrecon {

struct OddMantissa {
  std::int64_t mantissa = 0;
  int exponent = 0;

  explicit OddMantissa(double value) {
    if (value == 0.0) return;
    const double fraction = std::frexp(value, &exponent);
    mantissa = std::int64_t(std::ldexp(fraction, 53));
    exponent -= 53;
    while ((mantissa & 1) == 0) {
      mantissa /= 2;
      ++exponent;
    }
  }
};

// The unit 2^exponent of some sites, and the number of bits that the largest determinant needs.
class ExactFrame {
 public:
  ExactFrame(const Site* const* sites, int count, bool weighted) {
    constexpr int nothing = 1 << 16;
    int highest = -nothing, highest_weight = -4 * nothing, lowest = nothing;
    for (int i = 0; i < count; ++i) {
      for (double coordinate : {sites[i]->x, sites[i]->y, sites[i]->z}) widen(coordinate, 1, lowest, highest);
      if (weighted) widen(sites[i]->weight, 2, lowest, highest_weight);
    }
    if (lowest == nothing) lowest = 0;  // all zero
    exponent = lowest;
    const int coordinate_bits = std::max(0, highest - lowest) + 1;  // of a difference
    const int weight_bits = std::max(0, highest_weight - 2 * lowest) + 1;
    const int lift_bits = std::max(2 * coordinate_bits + 2, weight_bits) + 1;
    // a minor of three rows has 6 products (3 bits), the power determinant 4 of those times a lift (2 bits)
    bits = 3 * coordinate_bits + 3 + lift_bits + 2;
  }

  template <int Capacity>
  Integer<Capacity> coordinate(double value) const {
    const OddMantissa parts(value);
    return Integer<Capacity>::scaled(parts.mantissa, parts.mantissa == 0 ? 0 : parts.exponent - exponent);
  }

  template <int Capacity>
  Integer<Capacity> weight(double value) const {
    const OddMantissa parts(value);
    return Integer<Capacity>::scaled(parts.mantissa, parts.mantissa == 0 ? 0 : parts.exponent - 2 * exponent);
  }

  int exponent;
  int bits;

 private:
  static void widen(double value, int power, int& lowest, int& highest) {
    if (value == 0.0) return;
    const OddMantissa parts(value);
    const int floored = parts.exponent >= 0 ? parts.exponent / power : -((power - 1 - parts.exponent) / power);
    lowest = std::min(lowest, floored);
    int top;
    std::frexp(value, &top);
    highest = std::max(highest, top);
  }
};

// Limbs for determinants of everyday input, and of any finite doubles: coordinates span at most 2098 bits, so a
// determinant needs at most 10 520 bits. Two limbs are spare for the padding of Integer::scaled.
constexpr int everyday_limbs = 32;
constexpr int all_limbs = 340;

inline bool is_everyday(const ExactFrame& frame) { return frame.bits <= 32 * (everyday_limbs - 3); }

}  // namespace symrecon
