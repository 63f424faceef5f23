#include "far_faces.hpp"

#include <algorithm>
#include <array>

#include "vectors.hpp"

namespace symrecon {
namespace {

Position middle(const Position& a, const Position& b) {
  return {0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1]), 0.5 * (a[2] + b[2])};
}

}  // namespace

std::vector<std::int32_t> far_faces(View<Position> points, View<Triangle> faces, View<std::int32_t> nearest,
                                    View<Position> samples, View<double> spacing, double multiple) {
  std::vector<std::int32_t> far;
  for (std::size_t face = 0; face < faces.size(); ++face) {
    std::array<Position, 7> places;
    std::array<Position, 3> near;
    double widest = 0.0;
    for (int k = 0; k < 3; ++k) {
      const std::int32_t vertex = faces[face][k], sample = nearest[vertex];
      places[k] = points[vertex];
      near[k] = samples[sample];
      widest = std::max(widest, spacing[sample]);
    }
    for (int k = 0; k < 3; ++k) places[3 + k] = middle(places[k], places[(k + 1) % 3]);
    for (int axis = 0; axis < 3; ++axis) places[6][axis] = (places[0][axis] + places[1][axis] + places[2][axis]) / 3.0;
    const double limit = multiple * widest;
    const bool is_far = std::any_of(places.begin(), places.end(), [&](const Position& place) {
      return std::all_of(near.begin(), near.end(), [&](const Position& sample) {
        const Position apart = minus(place, sample);
        return dot(apart, apart) > limit * limit;
      });
    });
    if (is_far) far.push_back(static_cast<std::int32_t>(face));
  }
  return far;
}

}  // namespace symrecon
