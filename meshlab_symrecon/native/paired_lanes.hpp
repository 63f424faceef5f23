// Four numbers at a time, each as an unevaluated sum of a double and its error ("pair arithmetic": Lange and Rump,
// "Faithfully rounded floating-point computations", 2020). Unlike double-doubles the sums are not renormalised, so that
// the compiler can keep four of them in the lanes of one register; the errors grow with the depth of the formula:
//
//   a pair (high, low) for a value v, with p the value's formula with every term made positive, u = 2^-53:
//   |low| <= lambda u p,  |high + low - v| <= delta u^2 p  (factors 1 + O(u) are left to the slack of the final bound)
//   difference of doubles  lambda = 1, delta = 0
//   product                lambda = la + lb + 1    delta = da + db + la lb + 3 (la + lb) + 1
//                          (the leading product is exact; dropped: low * low; rounded: two cross products, their sum,
//                          and its sum with the error of the leading product)
//   sum                    lambda = max(l) + 1     delta = max(d) + 2 max(l) + 1
//                          (the leading sum is exact; rounded: the sum of the lows, and its sum with the leading error)
//
// `Machine` says how to get the error of a product: Dekker's splitting and a fused multiply-add both give it exactly, so
// the results are the same to the last bit (as long as nothing underflows).
#pragma once

namespace symrecon {

#if defined(__GNUC__) || defined(__clang__)
#define SYMRECON_INLINE inline __attribute__((always_inline))

typedef double Lanes __attribute__((vector_size(32)));  // with arithmetic built in

template <int Step>
SYMRECON_INLINE Lanes turned(const Lanes& a) {
  return Lanes{a[Step & 3], a[(Step + 1) & 3], a[(Step + 2) & 3], a[(Step + 3) & 3]};
}
#else
#define SYMRECON_INLINE inline

struct Lanes {
  double lane[4];
  double operator[](int i) const { return lane[i]; }
};

inline Lanes operator+(const Lanes& a, const Lanes& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3]}; }
inline Lanes operator-(const Lanes& a, const Lanes& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2], a[3] - b[3]}; }
inline Lanes operator*(const Lanes& a, const Lanes& b) { return {a[0] * b[0], a[1] * b[1], a[2] * b[2], a[3] * b[3]}; }

template <int Step>
inline Lanes turned(const Lanes& a) {
  return {a[Step & 3], a[(Step + 1) & 3], a[(Step + 2) & 3], a[(Step + 3) & 3]};
}
#endif

struct Splitting {
  static SYMRECON_INLINE Lanes error_of_product(const Lanes& a, const Lanes& b, const Lanes& product) {
    constexpr double factor = 134217729.0;  // 2^27 + 1
    const Lanes splitter = {factor, factor, factor, factor};
    const Lanes a_scaled = splitter * a, b_scaled = splitter * b;
    const Lanes a_high = a_scaled - (a_scaled - a), b_high = b_scaled - (b_scaled - b);
    const Lanes a_low = a - a_high, b_low = b - b_high;
    return ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low;
  }
};

template <class Machine>
struct Pairs {
  Lanes high, low;

  friend SYMRECON_INLINE Pairs operator+(const Pairs& a, const Pairs& b) {
    const Lanes sum = a.high + b.high, part = sum - a.high;
    return {sum, ((a.high - (sum - part)) + (b.high - part)) + (a.low + b.low)};
  }

  friend SYMRECON_INLINE Pairs operator-(const Pairs& a, const Pairs& b) {
    const Lanes sum = a.high - b.high, part = sum - a.high;
    return {sum, ((a.high - (sum - part)) - (b.high + part)) + (a.low - b.low)};
  }

  friend SYMRECON_INLINE Pairs operator*(const Pairs& a, const Pairs& b) {
    const Lanes product = a.high * b.high;
    return {product, Machine::error_of_product(a.high, b.high, product) + (a.high * b.low + a.low * b.high)};
  }
};

template <class Machine>
SYMRECON_INLINE Pairs<Machine> difference(const Lanes& a, const Lanes& b) {
  const Lanes sum = a - b, part = sum - a;
  return {sum, (a - (sum - part)) - (b + part)};
}

template <int Step, class Machine>
SYMRECON_INLINE Pairs<Machine> turned(const Pairs<Machine>& a) {
  return {turned<Step>(a.high), turned<Step>(a.low)};
}

}  // namespace symrecon
