// Planes moved to where the mirrored cloud fits the cloud itself, point to plane, by Gauss-Newton.
#pragma once

#include <cstdint>
#include <vector>

#include "mirror_cloud.hpp"
#include "view.hpp"

namespace symrecon {

// The Python module `refinement` gives the numbers and their reasons.
struct RefinementRules {
  double reach;           // tolerances within which a partner counts
  double no_direction;    // cosine of normals up to which it does not,
  double full_direction;  // and from which on it does so fully
  double point_share;     // of point-to-point distance
  double ridge;           // of the trace
  double largest_turn;    // radians a step
  double settled;         // turn and shift of a step after which nothing moves any more
  std::int32_t fewest;    // partners
};

// Fits the mirror image of the points `queries`, one plane at a time. `tolerances` has a row of `steps` numbers a
// plane. A plane stays where it is once it has too few partners.
std::vector<Plane> refine(View<Plane> planes, const MirrorCloud& cloud, View<std::int32_t> queries,
                          View<double> tolerances, std::size_t steps, const RefinementRules& rules);

}  // namespace symrecon
