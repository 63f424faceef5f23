// Real numbers as whole ones, whatever they are.
#pragma once

#include <cmath>
#include <cstdint>

namespace symrecon {

// The largest whole number that is not larger; 2^60 for what is beyond it, of either sign, so that a few steps from
// there are still numbers; the lower end for what is no number.
inline std::int64_t floored(double number) {
  constexpr double most = 0x1p60;
  const double whole = std::floor(number);
  const double bounded = whole > -most ? (whole < most ? whole : most) : -most;
  return static_cast<std::int64_t>(bounded);
}

}  // namespace symrecon
