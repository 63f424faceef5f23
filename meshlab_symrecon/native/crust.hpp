// The crust: polygons dual to the mixed edges of a regular triangulation, and their clean-up.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace symrecon {

using Quad = std::array<std::int32_t, 4>;
using Triangle = std::array<std::int32_t, 3>;
using Position = std::array<double, 3>;

// Polygons of the power diagram that part an inner cell from an outer one.
struct Polygons {
  std::vector<std::int64_t> offsets;  // polygon k has the corners offsets[k] .. offsets[k + 1]
  std::vector<std::int32_t> corners;  // regular cells, whose orthocentres are the corners
  std::vector<std::int32_t> inner;    // the inner pole of each polygon
  std::vector<std::int32_t> outer;    // the outer pole of each polygon
};

// Walk round every edge that joins an inner and an outer site.  Corners run counter-clockwise seen
// from the outer site.  Inner sites must not lie on the hull; throws std::invalid_argument.
Polygons mixed_edge_polygons(const std::vector<Quad>& cells, const std::vector<Quad>& neighbours,
                             const std::vector<std::uint8_t>& inside);

// A triangle surface while its edges are contracted.
struct Contraction {
  std::vector<Position> points;
  std::vector<Triangle> faces;       // of the surviving vertices
  std::vector<std::int32_t> origin;  // surviving vertex -> one of the vertices it was made of
  std::int64_t refused = 0;          // edges kept because contracting them would pinch the surface
};

// Contract edges of a closed manifold where the link condition holds (so that it stays one):
// first edges whose ends carry the same anchor >= 0 (they meet at the anchor's position), then edges
// shorter than `shortest` of their ends, unless a face would turn over.
Contraction contract_edges(std::vector<Position> points, std::vector<Triangle> faces,
                           const std::vector<std::int32_t>& anchor,
                           const std::vector<Position>& anchor_points,
                           const std::vector<double>& shortest);

}  // namespace symrecon
