// Triangles of a surface that may be far from the samples it was made from.
#pragma once

#include <cstdint>
#include <vector>

#include "view.hpp"
#include "crust.hpp"

namespace symrecon {

// Faces with a place that is farther than `multiple` times the local spacing from the samples nearest
// to their corners.  The places are corners, middles of sides and the centre; the spacing is the
// largest at those samples.
std::vector<std::int32_t> far_faces(View<Position> points, View<Triangle> faces, View<std::int32_t> nearest,
                                    View<Position> samples, View<double> spacing, double multiple);

}  // namespace symrecon
