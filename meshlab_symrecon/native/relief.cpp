#include "relief.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "vectors.hpp"

namespace symrecon {
namespace {

// Points in the cells of a grid whose edge is the radius, so that a ball lies within 27 cells.
class BallGrid {
 public:
  BallGrid(View<Position> points, double radius) : points_(points), low_(lowest(points)), edge_(radius) {
    for (int axis = 0; axis < 3; ++axis) {
      double high = low_[axis];
      for (const Position& point : points) high = std::max(high, point[axis]);
      counts_[axis] = std::int64_t(std::min((high - low_[axis]) / edge_, kMostCells - 1.0)) + 1;
    }
    starts_.assign(std::size_t(counts_[0] * counts_[1] * counts_[2]) + 1, 0);
    for (const Position& point : points) ++starts_[key(cell(point)) + 1];
    for (std::size_t k = 1; k < starts_.size(); ++k) starts_[k] += starts_[k - 1];
    std::vector<std::int32_t> next(starts_.begin(), starts_.end() - 1);
    members_.resize(points.size());
    for (std::size_t k = 0; k < points.size(); ++k) members_[next[key(cell(points[k]))]++] = std::int32_t(k);
  }

  template <typename Visit>
  void within(const Position& centre, Visit&& visit) const {
    const auto middle = cell(centre);
    std::array<std::int64_t, 3> first, last;
    for (int axis = 0; axis < 3; ++axis) {
      first[axis] = std::max<std::int64_t>(middle[axis] - 1, 0);
      last[axis] = std::min(middle[axis] + 1, counts_[axis] - 1);
    }
    for (std::int64_t a = first[0]; a <= last[0]; ++a)
      for (std::int64_t b = first[1]; b <= last[1]; ++b) {  // cells of a row follow each other
        const std::int32_t begin = starts_[key({a, b, first[2]})], end = starts_[key({a, b, last[2]}) + 1];
        for (std::int32_t k = begin; k < end; ++k) {
          const Position offset = minus(points_[members_[k]], centre);
          if (dot(offset, offset) <= edge_ * edge_) visit(offset);
        }
      }
  }

 private:
  static constexpr double kMostCells = 128.0;  // on a side: bounds the memory of a tiny radius

  static Position lowest(View<Position> points) {
    Position low = points.size() ? points[0] : Position{};
    for (const Position& point : points)
      for (int axis = 0; axis < 3; ++axis) low[axis] = std::min(low[axis], point[axis]);
    return low;
  }

  std::array<std::int64_t, 3> cell(const Position& place) const {
    std::array<std::int64_t, 3> found;
    for (int axis = 0; axis < 3; ++axis)
      found[axis] = std::int64_t(std::min((place[axis] - low_[axis]) / edge_, counts_[axis] - 1.0));
    return found;
  }

  std::size_t key(const std::array<std::int64_t, 3>& cell) const {
    return std::size_t((cell[0] * counts_[1] + cell[1]) * counts_[2] + cell[2]);
  }

  View<Position> points_;
  Position low_;
  double edge_;
  std::array<std::int64_t, 3> counts_;
  std::vector<std::int32_t> starts_, members_;
};

}  // namespace

std::vector<double> relief(View<Position> points, View<Position> normals, double radius) {
  const BallGrid grid(points, radius);
  std::vector<double> heights(points.size());
  for (std::size_t k = 0; k < points.size(); ++k) {
    Position sum{};
    double count = 0.0;
    grid.within(points[k], [&](const Position& offset) {
      for (int axis = 0; axis < 3; ++axis) sum[axis] += offset[axis];
      count += 1.0;
    });
    heights[k] = dot(sum, normals[k]) / (count * radius);
  }
  return heights;
}

}  // namespace symrecon
