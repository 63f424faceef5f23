// Centres of the balls orthogonal to the four weighted sites of a cell: circumcentres when the weights are equal.
#pragma once

#include "site.hpp"

namespace symrecon {

struct Point {
  double x, y, z;
};

// p_0 + u with 2 (p_i - p_0) . u = |p_i - p_0|^2 - w_i + w_0, i = 1..3. The error of u is below 1e-12 |u| in every
// coordinate, however flat the cell. NaN for four sites in one plane; infinite when no double is large enough.
Point orthocentre(const Site& a, const Site& b, const Site& c, const Site& d);

}  // namespace symrecon
