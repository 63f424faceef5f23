#include <limits>

#include "crust.hpp"
#include "orthocentres.hpp"

namespace symrecon {
namespace {

constexpr std::size_t kStepsPerReport = 1 << 14;
constexpr std::size_t kAhead = 24;  // cells are fetched that many steps before their turn

double squared_distance(const Position& a, const Position& b) {
  const double x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
  return x * x + y * y + z * z;
}

// Without branches, which a processor could not foresee here.
bool touches(const Quad& ball, std::int32_t sample) {
  return (ball[0] == sample) | (ball[1] == sample) | (ball[2] == sample) | (ball[3] == sample);
}

// The sample that all four balls touch, or -1: its power to each of them is zero.
std::int32_t shared_sample(const Quad (&touched)[4], std::int32_t sample_count) {
  std::int32_t shared = -1;
  for (const std::int32_t sample : touched[0]) {
    const bool by_all = touches(touched[1], sample) & touches(touched[2], sample) &
                        touches(touched[3], sample) & (sample < sample_count);
    shared = by_all ? sample : shared;
  }
  return shared;
}

// Equal distances: the smaller number, so that the order of the balls does not matter.
std::int32_t nearest_sample(const PolarBalls& balls, const Quad (&touched)[4], const Position& point) {
  std::int32_t nearest = -1;
  double least = std::numeric_limits<double>::infinity();
  for (const Quad& ball : touched)
    for (const std::int32_t sample : ball) {
      if (sample >= balls.sample_count) continue;
      const double squared = squared_distance(balls.sites[sample], point);
      if (squared > least || (squared == least && sample >= nearest && nearest >= 0)) continue;
      nearest = sample;
      least = squared;
    }
  return nearest;
}

Position mean_of_samples(const PolarBalls& balls, const Quad& cell) {
  Position sum{0.0, 0.0, 0.0};
  for (const std::int32_t pole : cell)
    for (const std::int32_t sample : balls.samples[pole])
      for (int axis = 0; axis < 3; ++axis) sum[axis] += balls.sites[sample][axis];
  return {sum[0] / 16.0, sum[1] / 16.0, sum[2] / 16.0};
}

Site ball(const PolarBalls& balls, std::int32_t pole) {
  const Position& centre = balls.centres[pole];
  return {centre[0], centre[1], centre[2], balls.radii[pole] * balls.radii[pole]};
}

bool within_reach(const PolarBalls& balls, const Quad& cell, const Position& point, double reach) {
  for (const std::int32_t pole : cell) {
    const double far = reach * balls.radii[pole];
    if (squared_distance(point, balls.centres[pole]) <= far * far) return true;  // not of NaN
  }
  return false;
}

}  // namespace

PowerVertices power_vertices(const PolarBalls& balls, View<Quad> cells, View<std::int32_t> chosen,
                             double reach, const Progress& progress) {
  PowerVertices result;
  result.positions.resize(chosen.size());
  result.nearest.resize(chosen.size());
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    if (i % kStepsPerReport == 0 && progress) progress(double(i) / double(chosen.size()));
    if (i + kAhead < chosen.size()) cells.announce(chosen[i + kAhead]);
    const Quad& cell = cells[chosen[i]];
    Position& position = result.positions[i];
    const Quad touched[4] = {balls.samples[cell[0]], balls.samples[cell[1]], balls.samples[cell[2]],
                             balls.samples[cell[3]]};
    const std::int32_t shared = shared_sample(touched, balls.sample_count);
    if (shared >= 0) {
      position = balls.sites[shared];
      result.nearest[i] = shared;
      continue;
    }
    const Point centre = orthocentre(ball(balls, cell[0]), ball(balls, cell[1]), ball(balls, cell[2]),
                                     ball(balls, cell[3]));
    position = {centre.x, centre.y, centre.z};
    if (!within_reach(balls, cell, position, reach)) position = mean_of_samples(balls, cell);
    result.nearest[i] = nearest_sample(balls, touched, position);
  }
  return result;
}

}  // namespace symrecon
