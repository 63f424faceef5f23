#include <cmath>
#include <limits>
#include <stdexcept>

#include "interpolating.hpp"

namespace symrecon {
namespace {

Position minus(const Position& a, const Position& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }

Position cross(const Position& a, const Position& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

double dot(const Position& a, const Position& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

// Plain floating point will do: the centre of a cell so flat that it suffers lies on neither side
// for certain.
Position circumcentre(const Position& origin, const Position& a, const Position& b, const Position& c) {
  const Position u = minus(a, origin), v = minus(b, origin), w = minus(c, origin);
  const Position vw = cross(v, w), wu = cross(w, u), uv = cross(u, v);
  const double scale = 0.5 / dot(u, vw);
  Position centre;
  for (int axis = 0; axis < 3; ++axis)
    centre[axis] = origin[axis] + scale * (dot(u, u) * vw[axis] + dot(v, v) * wu[axis] + dot(w, w) * uv[axis]);
  return centre;
}

}  // namespace

std::vector<std::uint8_t> label_cells(View<Position> sites, View<Quad> cells, std::int32_t samples,
                                      const LabelledBalls& balls) {
  std::vector<std::uint8_t> sides(cells.size(), outer_side);
  std::size_t next_pole = 0;
  for (std::size_t number = 0; number < cells.size(); ++number) {
    const Quad& cell = cells[number];
    const bool is_pole = next_pole < balls.samples.size() && cell == balls.samples[next_pole];
    const std::size_t own = next_pole;
    next_pole += is_pole;
    if (cell[0] >= samples || cell[1] >= samples || cell[2] >= samples || cell[3] >= samples) continue;
    if (is_pole) {
      sides[number] = balls.sides[own];
      continue;
    }
    const Position centre = circumcentre(sites[cell[0]], sites[cell[1]], sites[cell[2]], sites[cell[3]]);
    double least = std::numeric_limits<double>::infinity();
    for (const std::int32_t sample : cell)
      for (const std::int32_t pole : balls.of_sample[sample]) {
        if (pole < 0) continue;
        const Position reach = minus(centre, balls.centres[pole]);
        const double power = dot(reach, reach) - balls.radii[pole] * balls.radii[pole];
        if (power < least) {
          least = power;
          sides[number] = balls.sides[pole];
        }
      }
  }
  if (next_pole < balls.samples.size()) throw std::invalid_argument("a pole without its cell");
  return sides;
}

}  // namespace symrecon
