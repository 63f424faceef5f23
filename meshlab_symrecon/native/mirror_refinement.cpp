#include "mirror_refinement.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace symrecon {
namespace {

constexpr double tiny = std::numeric_limits<double>::min();

// Unknowns of a step are small turns a, b of the normal towards two tangents and a shift of the plane along the normal:
//   n <- n + a u + b v,  h <- h + a (u . p) + b (v . p) - shift,  image = p - 2 h n.
struct Frame {
  Position normal, first, second;
};

Position unit(const Position& vector) {
  const double length = std::sqrt(dot(vector, vector));
  return {vector[0] / length, vector[1] / length, vector[2] / length};
}

Frame frame_of(const Position& normal) {
  int least = 0;
  for (int axis = 1; axis < 3; ++axis)
    if (std::abs(normal[axis]) < std::abs(normal[least])) least = axis;
  Position helper{0.0, 0.0, 0.0};
  helper[least] = 1.0;
  const Position first = unit(cross(normal, helper));
  return {normal, first, cross(normal, first)};
}

// Weighted least squares in three unknowns; the upper half of the symmetric matrix.
struct NormalEquations {
  double xx = 0.0, xy = 0.0, xz = 0.0, yy = 0.0, yz = 0.0, zz = 0.0;
  Position gradient{0.0, 0.0, 0.0};
  std::int32_t partners = 0;

  void add(const Position& slope, double residual, double weight) {
    const Position weighted = {weight * slope[0], weight * slope[1], weight * slope[2]};
    xx += weighted[0] * slope[0];
    xy += weighted[0] * slope[1];
    xz += weighted[0] * slope[2];
    yy += weighted[1] * slope[1];
    yz += weighted[1] * slope[2];
    zz += weighted[2] * slope[2];
    for (int k = 0; k < 3; ++k) gradient[k] += weighted[k] * residual;
  }

  // The step to the minimum, by Cholesky factors; `ridge` of the trace keeps a direction without any slope still.
  Position step(double ridge) const {
    const double more = ridge * (xx + yy + zz) + tiny;
    const double a = std::sqrt(xx + more), b = xy / a, c = xz / a;
    const double d = std::sqrt(yy + more - b * b), e = (yz - b * c) / d;
    const double f = std::sqrt(zz + more - c * c - e * e);
    const double r = gradient[0] / a, s = (gradient[1] - b * r) / d, t = (gradient[2] - c * r - e * s) / f;
    const double z = t / f, y = (s - e * z) / d, x = (r - b * y - c * z) / a;
    return {-x, -y, -z};
  }
};

// An image that landed on the surface.
struct Pair {
  Position query;
  double height;   // of the query
  Position gap;    // from the partner to the image
  Position normal;  // of the partner
  double weight;
};

// Derivatives of  target . image  by the two turns and the shift.
Position slope(const Pair& pair, const Position& target, const Frame& frame) {
  const double along = dot(target, frame.normal);
  return {-2.0 * (pair.height * dot(target, frame.first) + dot(frame.first, pair.query) * along),
          -2.0 * (pair.height * dot(target, frame.second) + dot(frame.second, pair.query) * along), 2.0 * along};
}

void add_point_to_plane(const Pair& pair, const Frame& frame, NormalEquations& sums) {
  sums.add(slope(pair, pair.normal, frame), dot(pair.gap, pair.normal), pair.weight);
}

// Point to point is point to plane along each axis of the frame.
void add_point_to_point(const Pair& pair, const Frame& frame, double share, NormalEquations& sums) {
  const double weight = share * pair.weight, turn = -2.0 * pair.height;
  sums.add({-2.0 * dot(frame.first, pair.query), -2.0 * dot(frame.second, pair.query), 2.0},
           dot(pair.gap, frame.normal), weight);
  sums.xx += weight * turn * turn;
  sums.yy += weight * turn * turn;
  sums.gradient[0] += weight * turn * dot(pair.gap, frame.first);
  sums.gradient[1] += weight * turn * dot(pair.gap, frame.second);
}

// Near partners whose normals agree; normals of either sign.
double pair_weight(double square, double cosine, double tolerance, const RefinementRules& rules) {
  const double relative = square / (tolerance * tolerance);
  if (relative > rules.reach * rules.reach) return 0.0;
  const double direction = ramp(std::abs(cosine), rules.no_direction, rules.full_direction);
  return direction == 0.0 ? 0.0 : direction * std::exp(-0.5 * relative);
}

NormalEquations normal_equations(const Frame& frame, const MirrorCloud& cloud, View<SurfacePoint> queries,
                                 View<Image> images, double tolerance, const RefinementRules& rules) {
  NormalEquations sums;
  for (std::size_t i = 0; i < queries.size(); ++i) {
    const SurfacePoint &query = queries[i], &partner = cloud.points[images[i].partner];
    const Position gap = minus(images[i].place, partner.place);
    const double cosine = mirrored_cosine(query.normal, partner.normal, frame.normal);
    const double weight = pair_weight(dot(gap, gap), cosine, tolerance, rules);
    if (weight == 0.0) continue;
    const Pair pair{query.place, images[i].height, gap, partner.normal, weight};
    add_point_to_plane(pair, frame, sums);
    add_point_to_point(pair, frame, rules.point_share, sums);
    ++sums.partners;
  }
  return sums;
}

// No further than the largest turn.
Position limited(const Position& move, double largest_turn) {
  const double turn = std::hypot(move[0], move[1]), share = std::min(1.0, largest_turn / std::max(turn, largest_turn));
  return {share * move[0], share * move[1], share * move[2]};
}

Plane moved(const Plane& plane, const Frame& frame, const Position& move) {
  Position normal;
  for (int axis = 0; axis < 3; ++axis)
    normal[axis] = plane.normal[axis] + move[0] * frame.first[axis] + move[1] * frame.second[axis];
  return {unit(normal), plane.offset - move[2]};
}

Plane refined(Plane plane, const MirrorCloud& cloud, View<SurfacePoint> queries, View<double> tolerances,
              const RefinementRules& rules) {
  std::vector<Image> images;
  for (std::size_t step = 0; step < tolerances.size(); ++step) {
    const Frame frame = frame_of(plane.normal);
    cast_images(plane, cloud, queries, rules.reach * tolerances[step], images);
    const NormalEquations sums = normal_equations(frame, cloud, queries, images, tolerances[step], rules);
    if (sums.partners < rules.fewest) return plane;
    const Position move = limited(sums.step(rules.ridge), rules.largest_turn);
    plane = moved(plane, frame, move);
    const bool finest = tolerances[step] == tolerances[tolerances.size() - 1];
    if (finest && std::max({std::abs(move[0]), std::abs(move[1]), std::abs(move[2])}) < rules.settled) return plane;
  }
  return plane;
}

}  // namespace

std::vector<Plane> refine(View<Plane> planes, const MirrorCloud& cloud, View<std::int32_t> queries,
                          View<double> tolerances, std::size_t steps, const RefinementRules& rules) {
  std::vector<SurfacePoint> asked;
  for (const std::int32_t query : queries) asked.push_back(cloud.points[query]);
  std::vector<Plane> found;
  for (std::size_t i = 0; i < planes.size(); ++i)
    found.push_back(refined(planes[i], cloud, asked, {tolerances.data() + i * steps, steps}, rules));
  return found;
}

}  // namespace symrecon
