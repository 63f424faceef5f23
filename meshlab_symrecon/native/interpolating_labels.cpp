#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

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

bool has_samples_only(const Quad& cell, std::int32_t samples) {
  return cell[0] < samples && cell[1] < samples && cell[2] < samples && cell[3] < samples;
}

// The ball to which a place has the least power, among those offered.
class LeastPower {
 public:
  LeastPower(const Position& place, const LabelledBalls& balls) : place_(place), balls_(balls) {}

  void offer(std::int32_t pole) {
    if (pole < 0 || pole == pole_) return;
    const Position reach = minus(place_, balls_.centres[pole]);
    const double power = dot(reach, reach) - balls_.radii[pole] * balls_.radii[pole];
    if (power >= least_) return;
    least_ = power;
    pole_ = pole;
  }

  std::int32_t pole() const { return pole_; }  // -1 when none was offered

 private:
  const Position place_;
  const LabelledBalls& balls_;
  double least_ = std::numeric_limits<double>::infinity();
  std::int32_t pole_ = -1;
};

Position centre_of(const Quad& cell, View<Position> sites) {
  return circumcentre(sites[cell[0]], sites[cell[1]], sites[cell[2]], sites[cell[3]]);
}

// Give cells without a pole the best of their neighbours' ones, in rounds from those that have one.
void spread_poles(View<Position> sites, View<Quad> cells, View<Quad> neighbours, const LabelledBalls& balls,
                  std::vector<std::int32_t> without, std::vector<std::int32_t>& poles) {
  std::vector<std::int32_t> found;
  for (std::size_t left = without.size() + 1; without.size() < left;) {
    left = without.size();
    found.clear();
    for (const std::int32_t cell : without) {
      LeastPower best(centre_of(cells[cell], sites), balls);
      for (const std::int32_t next : neighbours[cell])
        if (next >= 0) best.offer(poles[next]);
      found.push_back(best.pole());
    }
    std::size_t kept = 0;
    for (std::size_t place = 0; place < left; ++place) {
      poles[without[place]] = found[place];
      if (found[place] < 0) without[kept++] = without[place];
    }
    without.resize(kept);
  }
}

}  // namespace

std::vector<std::uint8_t> label_cells(View<Position> sites, View<Quad> cells, View<Quad> neighbours,
                                      std::int32_t samples, const LabelledBalls& balls) {
  std::vector<std::int32_t> poles(cells.size(), -1), without;
  std::size_t next_pole = 0;
  for (std::size_t number = 0; number < cells.size(); ++number) {
    const Quad& cell = cells[number];
    const bool is_pole = next_pole < balls.samples.size() && cell == balls.samples[next_pole];
    const std::size_t own = next_pole;
    next_pole += is_pole;
    if (!has_samples_only(cell, samples)) continue;
    if (is_pole) {
      poles[number] = static_cast<std::int32_t>(own);
      continue;
    }
    LeastPower best(centre_of(cell, sites), balls);
    for (const std::int32_t sample : cell)
      for (const std::int32_t pole : balls.of_sample[sample]) best.offer(pole);
    poles[number] = best.pole();
    if (best.pole() < 0) without.push_back(static_cast<std::int32_t>(number));
  }
  if (next_pole < balls.samples.size()) throw std::invalid_argument("a pole without its cell");
  spread_poles(sites, cells, neighbours, balls, std::move(without), poles);
  std::vector<std::uint8_t> sides(cells.size(), outer_side);
  for (std::size_t number = 0; number < cells.size(); ++number)
    if (poles[number] >= 0) sides[number] = balls.sides[poles[number]];
  return sides;
}

}  // namespace symrecon
