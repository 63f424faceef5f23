// What kind of surface a set of triangles is.
#pragma once

#include <cstdint>
#include <vector>

#include "crust.hpp"

namespace symrecon {

struct SurfaceTopology {
  std::int64_t vertices = 0;  // that faces use
  std::int64_t edges = 0;
  std::int64_t boundary = 0;    // edges with one face
  std::int64_t crowded = 0;     // edges with more than two
  std::int64_t misoriented = 0;  // edges with two faces that run through it the same way
  std::int64_t fans = 0;         // fans of faces round all vertices: as many on a manifold
  std::int64_t components = 0;
  std::vector<std::int32_t> piece;  // component of each face
};

SurfaceTopology surface_topology(View<Triangle> faces, std::int32_t vertex_count);

}  // namespace symrecon
