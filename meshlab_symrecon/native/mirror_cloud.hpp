// A cloud, mirror images of its points, and where on the cloud they fall.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "crust.hpp"
#include "nearest_field.hpp"
#include "vectors.hpp"
#include "view.hpp"

namespace symrecon {

// All that a comparison needs to know of a point, in one place of memory.
struct SurfacePoint {
  Position place;
  Position normal;         // unit
  double border_distance;  // to the nearest rim of a hole, infinite without one
  bool oriented;           // the normal points outwards
};

struct MirrorCloud {
  const NearestField& field;
  std::vector<SurfacePoint> points;
  bool exact;  // partners are the closest points, not those of the table

  // Where an image falls; beyond the distance `within` any point that far may stand for the closest one.
  const SurfacePoint& partner(const Position& image, double within = std::numeric_limits<double>::infinity()) const {
    return points[exact ? field.closest(image, within) : field.lookup(image)];
  }
};

// The plane  { x : normal . x + offset = 0 }.
struct Plane {
  Position normal;
  double offset;

  double height(const Position& point) const { return dot(normal, point) + offset; }
};

// Where  x - 2 h n  puts a point of height h.
inline Position mirrored(const Position& point, double height, const Position& normal) {
  return {point[0] - 2.0 * height * normal[0], point[1] - 2.0 * height * normal[1],
          point[2] - 2.0 * height * normal[2]};
}

// Cosine between a direction and the mirror image  (I - 2 n n^T) d  of another one.
inline double mirrored_cosine(const Position& direction, const Position& other, const Position& normal) {
  return dot(direction, other) - 2.0 * dot(direction, normal) * dot(other, normal);
}

// 0 up to `none`, 1 from `full` on, linear in between.
inline double ramp(double value, double none, double full) {
  const double share = (value - none) / (full - none);
  return share > 0.0 ? (share < 1.0 ? share : 1.0) : 0.0;
}

}  // namespace symrecon
