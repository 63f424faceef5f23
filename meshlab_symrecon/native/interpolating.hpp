// The surface through the samples: the boundary of the inner cells of their Delaunay triangulation.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "crust.hpp"
#include "view.hpp"

namespace symrecon {

// Which side of the surface a cell lies on.
enum Side : std::uint8_t { outer_side = 0, inner_side = 1 };

using PolePair = std::array<std::int32_t, 2>;  // balls at a sample, -1 for none

// Polar balls, and what they say about the cells round their samples.
struct LabelledBalls {
  View<Position> centres;
  View<double> radii;
  View<Quad> samples;        // on each ball, as in the cell whose circumcentre is the pole
  View<std::uint8_t> sides;  // of each ball, a Side
  View<PolePair> of_sample;
};

// The side of every cell.  A cell with a site from `samples` on is outer.  A cell whose circumcentre
// is a pole takes its side; any other that of the ball to which its circumcentre has the least
// power, among the balls of its samples, or of its neighbours when those have none.  Poles come in the
// order of their cells; throws std::invalid_argument otherwise.
std::vector<std::uint8_t> label_cells(View<Position> sites, View<Quad> cells, View<Quad> neighbours,
                                      std::int32_t samples, const LabelledBalls& balls);

// Sides whose boundary is a manifold, changed for that as little as need be, without pieces of
// fewer than `smallest` facets, and then as smooth as exchanges of triangles make it.  Cells with a
// site from `samples` on must be outer, and stay so; throws std::invalid_argument otherwise.
std::vector<std::uint8_t> settle_sides(View<Position> sites, View<Quad> cells, View<Quad> neighbours,
                                       std::int32_t samples, View<std::uint8_t> sides, std::int64_t smallest);

}  // namespace symrecon
