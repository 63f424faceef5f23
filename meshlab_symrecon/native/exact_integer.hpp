// Signed integers of bounded size on the stack, for the determinants that floating point cannot decide.
//
// Sign and magnitude, 32-bit limbs, lowest first. Every operation costs what the limbs in use cost, not the capacity,
// so the short integers of lattice-like input stay cheap. The caller proves that no result needs more than `Capacity`
// limbs (see `exact_frame.hpp`); nothing is checked here.
#pragma once

#include <cmath>
#include <cstdint>

namespace symrecon {

template <int Capacity>
class Integer {
 public:
  Integer() = default;
  Integer(const Integer& other) { copy(other); }
  Integer& operator=(const Integer& other) {
    copy(other);
    return *this;
  }

  // mantissa * 2^shift, shift >= 0
  static Integer scaled(std::int64_t mantissa, int shift) {
    Integer result;
    if (mantissa == 0) return result;
    result.negative_ = mantissa < 0;
    const std::uint64_t magnitude = mantissa < 0 ? std::uint64_t(0) - std::uint64_t(mantissa) : std::uint64_t(mantissa);
    const int whole = shift / 32, rest = shift % 32;
    for (int i = 0; i < whole; ++i) result.limbs_[i] = 0;
    const std::uint64_t low = magnitude << rest;
    const std::uint64_t high = rest == 0 ? 0 : magnitude >> (64 - rest);
    result.limbs_[whole] = std::uint32_t(low);
    result.limbs_[whole + 1] = std::uint32_t(low >> 32);
    result.limbs_[whole + 2] = std::uint32_t(high);
    result.length_ = whole + 3;
    result.trim();
    return result;
  }

  int sign() const { return length_ == 0 ? 0 : (negative_ ? -1 : 1); }

  Integer operator-() const {
    Integer result(*this);
    result.negative_ = !result.negative_ && result.length_ > 0;
    return result;
  }

  friend Integer operator+(const Integer& a, const Integer& b) { return combine(a, b, b.negative_); }
  friend Integer operator-(const Integer& a, const Integer& b) { return combine(a, b, !b.negative_); }

  friend Integer operator*(const Integer& a, const Integer& b) {
    Integer result;
    if (a.length_ == 0 || b.length_ == 0) return result;
    result.length_ = a.length_ + b.length_;
    result.negative_ = a.negative_ != b.negative_;
    for (int i = 0; i < result.length_; ++i) result.limbs_[i] = 0;
    for (int i = 0; i < a.length_; ++i) {
      std::uint64_t carry = 0;
      const std::uint64_t factor = a.limbs_[i];
      for (int j = 0; j < b.length_; ++j) {
        carry += factor * b.limbs_[j] + result.limbs_[i + j];
        result.limbs_[i + j] = std::uint32_t(carry);
        carry >>= 32;
      }
      result.limbs_[i + b.length_] = std::uint32_t(carry);
    }
    result.trim();
    return result;
  }

  // The leading 64 bits as a double and the power of two that belongs to it; relative error below 2^-52.
  double leading(int& exponent) const {
    exponent = 0;
    if (length_ == 0) return 0.0;
    double value = 0.0;
    const int lowest = length_ > 3 ? length_ - 3 : 0;
    for (int i = length_ - 1; i >= lowest; --i) value = value * 4294967296.0 + double(limbs_[i]);
    exponent = 32 * lowest;
    return negative_ ? -value : value;
  }

 private:
  void copy(const Integer& other) {
    length_ = other.length_;
    negative_ = other.negative_;
    for (int i = 0; i < length_; ++i) limbs_[i] = other.limbs_[i];
  }

  void trim() {
    while (length_ > 0 && limbs_[length_ - 1] == 0) --length_;
    if (length_ == 0) negative_ = false;
  }

  static int compare_magnitudes(const Integer& a, const Integer& b) {
    if (a.length_ != b.length_) return a.length_ < b.length_ ? -1 : 1;
    for (int i = a.length_ - 1; i >= 0; --i)
      if (a.limbs_[i] != b.limbs_[i]) return a.limbs_[i] < b.limbs_[i] ? -1 : 1;
    return 0;
  }

  static Integer add_magnitudes(const Integer& longer, const Integer& shorter) {
    Integer result;
    std::uint64_t carry = 0;
    for (int i = 0; i < longer.length_; ++i) {
      carry += longer.limbs_[i];
      if (i < shorter.length_) carry += shorter.limbs_[i];
      result.limbs_[i] = std::uint32_t(carry);
      carry >>= 32;
    }
    result.length_ = longer.length_;
    if (carry != 0) result.limbs_[result.length_++] = std::uint32_t(carry);
    return result;
  }

  static Integer subtract_magnitudes(const Integer& larger, const Integer& smaller) {
    Integer result;
    std::int64_t borrow = 0;
    for (int i = 0; i < larger.length_; ++i) {
      borrow += std::int64_t(larger.limbs_[i]);
      if (i < smaller.length_) borrow -= std::int64_t(smaller.limbs_[i]);
      result.limbs_[i] = std::uint32_t(borrow & 0xffffffff);
      borrow = borrow < 0 ? -1 : 0;
    }
    result.length_ = larger.length_;
    result.trim();
    return result;
  }

  // a plus b, where b counts as negative when `b_negative`
  static Integer combine(const Integer& a, const Integer& b, bool b_negative) {
    if (a.negative_ == b_negative || a.length_ == 0 || b.length_ == 0) {
      Integer result = a.length_ >= b.length_ ? add_magnitudes(a, b) : add_magnitudes(b, a);
      result.negative_ = result.length_ > 0 && (a.length_ == 0 ? b_negative : a.negative_);
      return result;
    }
    const int order = compare_magnitudes(a, b);
    if (order == 0) return Integer();
    Integer result = order > 0 ? subtract_magnitudes(a, b) : subtract_magnitudes(b, a);
    result.negative_ = order > 0 ? a.negative_ : b_negative;
    return result;
  }

  std::uint32_t limbs_[Capacity];
  int length_ = 0;
  bool negative_ = false;
};

}  // namespace symrecon
