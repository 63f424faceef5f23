// The closest point of a surface that faces a given way; a face whose corners coincide is a point.
#pragma once

#include <cstdint>
#include <vector>

#include "crust.hpp"
#include "view.hpp"

namespace symrecon {

struct FacingSurface {
  View<Position> points;
  View<Triangle> faces;
  View<Position> normals;  // of the faces, of unit length or zero
};

// Which faces count for a place.
struct FacingRules {
  double least_cosine;  // between the face's normal and the direction at the place
  bool sided;           // otherwise the sign of that cosine does not matter
  double within;        // farther faces do not count
};

struct Feet {
  std::vector<std::int32_t> faces;               // the closest one, the first of several; -1: none counts
  std::vector<std::array<double, 2>> weights;    // of its second and third corner; exactly 0 and 1 on edges and corners
};

// For each place the closest point of the faces that count.
Feet closest_faces(const FacingSurface& surface, View<Position> places, View<Position> directions,
                   const FacingRules& rules);

}  // namespace symrecon
