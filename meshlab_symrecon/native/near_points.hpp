// Points thinned out to those that have no earlier one near them.
#pragma once

#include <cstdint>
#include <vector>

#include "crust.hpp"
#include "view.hpp"

namespace symrecon {

// For each point the nearest kept point within its reach, or itself when it is kept.  Points are
// taken in the given order; `reach` of a point is at most `widest`.
std::vector<std::int32_t> nearest_kept(View<Position> points, View<double> reach, View<std::int32_t> order,
                                       double widest);

}  // namespace symrecon
