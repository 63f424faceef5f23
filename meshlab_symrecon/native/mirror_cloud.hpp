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

  // The point an image falls on; beyond the distance `within` any point that far may stand for the closest one.
  std::int32_t partner(const Position& image, double within) const {
    return exact ? field.closest(image, within) : field.lookup(image);
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

// The mirror image of a query.
struct Image {
  double height;  // of the query above the plane
  Position place;
  std::int32_t partner;  // point of the cloud it falls on
};

// The images of all queries. They are made before any of them is judged, since a processor can wait for many entries of
// a table at once.
inline void cast_images(const Plane& plane, const MirrorCloud& cloud, View<SurfacePoint> queries, double within,
                        std::vector<Image>& images) {
  images.resize(queries.size());
  for (std::size_t i = 0; i < queries.size(); ++i) {
    const double height = plane.height(queries[i].place);
    const Position place = mirrored(queries[i].place, height, plane.normal);
    images[i] = {height, place, cloud.partner(place, within)};
  }
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
