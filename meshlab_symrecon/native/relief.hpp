// Relief: how the surface around a point bends away from its tangent plane.
#pragma once

#include <vector>

#include "crust.hpp"
#include "view.hpp"

namespace symrecon {

// For each point the height of the centroid of its ball above its tangent plane, in radii: positive in
// a hollow, negative on a bump, for outward normals.
std::vector<double> relief(View<Position> points, View<Position> normals, double radius);

}  // namespace symrecon
