// Unevaluated sums of two doubles (Dekker 1971, Knuth 1969), about 106 bits, without fused multiply-add.
//
// Error bounds used by the predicates, u = 2^-53 and no underflow:
//   two_sum, two_difference, two_product   exact
//   product     |error| <= 8 u^2 |a| |b|: dropped low*low u^2, two roundings of cross products u^2 each, of their sum
//               2 u^2, and of the sum with the low part of the leading product 3 u^2
//   sum         |error| <= 8 u^2 (|a| + |b|): rounding of the low parts u^2 and of their sum with the rounding error of
//               the leading sum 2 u^2; a renormalisation after heavy cancellation, where the "low" part may exceed the
//               high one, adds at most 4 u^2
// The sum has no *relative* bound under cancellation; none is needed, since the predicates compare with a permanent.
#pragma once

namespace symrecon {

struct DoubleDouble {
  double high;
  double low;
};

inline DoubleDouble two_sum(double a, double b) {
  const double sum = a + b;
  const double virtual_b = sum - a;
  return {sum, (a - (sum - virtual_b)) + (b - virtual_b)};
}

inline DoubleDouble two_difference(double a, double b) { return two_sum(a, -b); }

inline DoubleDouble renormalised(double high, double low) {
  const double sum = high + low;
  return {sum, low - (sum - high)};
}

inline DoubleDouble two_product(double a, double b) {
  constexpr double splitter = 134217729.0;  // 2^27 + 1
  const double a_scaled = splitter * a, b_scaled = splitter * b;
  const double a_high = a_scaled - (a_scaled - a), b_high = b_scaled - (b_scaled - b);
  const double a_low = a - a_high, b_low = b - b_high;
  const double product = a * b;
  return {product, ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low};
}

inline DoubleDouble operator+(DoubleDouble a, DoubleDouble b) {
  const DoubleDouble sum = two_sum(a.high, b.high);
  return renormalised(sum.high, sum.low + (a.low + b.low));
}

inline DoubleDouble operator-(DoubleDouble a) { return {-a.high, -a.low}; }

inline DoubleDouble operator-(DoubleDouble a, DoubleDouble b) { return a + -b; }

inline DoubleDouble operator*(DoubleDouble a, DoubleDouble b) {
  const DoubleDouble product = two_product(a.high, b.high);
  return renormalised(product.high, product.low + (a.high * b.low + a.low * b.high));
}

}  // namespace symrecon
