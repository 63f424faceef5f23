// Pairs of points that may be mirror images of each other.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "crust.hpp"
#include "view.hpp"

namespace symrecon {

// All pairs i < j farther apart than `shortest` whose plane maps the normal of one onto that of the other, to a cosine
// above `least_cosine`; the sign of normals that are not oriented does not count. In the order of i, then j.
std::vector<std::array<std::int32_t, 2>> mirror_pairs(View<Position> points, View<Position> normals,
                                                      View<std::uint8_t> oriented, double shortest,
                                                      double least_cosine);

}  // namespace symrecon
