// The crust: polygons dual to the mixed edges of a regular triangulation, as a lean triangle surface.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "regular_triangulation.hpp"
#include "view.hpp"

namespace symrecon {

using Quad = std::array<std::int32_t, 4>;
using Triangle = std::array<std::int32_t, 3>;
using Position = std::array<double, 3>;

// Polygons of the power diagram that part an inner cell from an outer one.
struct Polygons {
  std::vector<std::int32_t> cells;    // the regular cells with inner and outer sites, in rising order
  std::vector<std::int32_t> offsets;  // polygon k has the corners offsets[k] .. offsets[k + 1]
  std::vector<std::int32_t> corners;  // places in `cells`, whose orthocentres are the corners
};

// Walk round every edge that joins an inner and an outer site.  Corners run counter-clockwise seen
// from the outer site.  Inner sites must not lie on the hull; throws std::invalid_argument.
Polygons mixed_edge_polygons(View<Quad> cells, View<Quad> neighbours, View<std::uint8_t> inside,
                             const Progress& progress);

// Polar balls, each through four samples; sites from `sample_count` on are no samples.
struct PolarBalls {
  View<Position> centres;
  View<double> radii;
  View<Quad> samples;
  View<Position> sites;
  std::int32_t sample_count;
};

struct PowerVertices {
  std::vector<Position> positions;
  std::vector<std::int32_t> nearest;  // of the samples on the polar balls that meet at the vertex
};

// The points where the four balls of each chosen cell have equal power.  Where all four pass through
// one sample, that is the point, to the last bit.  A point farther than `reach` radii from the centre
// of every ball comes from a nearly flat cell, and is put at the mean of the samples on the balls.
PowerVertices power_vertices(const PolarBalls& balls, View<Quad> cells, View<std::int32_t> chosen,
                             double reach, const Progress& progress);

// Samples, and the distance of each to the next one.
struct Samples {
  View<Position> positions;
  View<double> spacing;
};

// Triangles whose vertices know the sample next to them.
struct SampledSurface {
  std::vector<Position> points;
  std::vector<std::int32_t> nearest;
  std::vector<Triangle> faces;
};

// Triangulate polygons and make one vertex of those at a sample, where they form a disc and the
// triangles round it stay a surface.
SampledSurface join_at_samples(View<Position> positions, View<std::int32_t> nearest,
                               View<std::int32_t> offsets, View<std::int32_t> corners,
                               View<Position> samples, const Progress& progress);

// How far edges are contracted, in spacings of the sample next to a vertex.
struct Leanness {
  double weld;  // shorter edges go
  double flat;  // a vertex goes whose removal moves the surface by less
};

// Contract edges of a closed manifold where the link condition holds (so that it stays one), no
// triangle turns over, and no vertex at a sample moves.
SampledSurface contract_edges(View<Position> points, View<Triangle> faces, View<std::int32_t> nearest,
                              const Samples& samples, const Leanness& leanness, const Progress& progress);

}  // namespace symrecon
