#include "near_points.hpp"

#include <array>
#include <stdexcept>

#include "saturating.hpp"
#include "vectors.hpp"

namespace symrecon {
namespace {

using Block = std::array<std::int64_t, 3>;

// Kept points by the block of space that they lie in; blocks share a bucket now and then.
class Blocks {
 public:
  Blocks(std::size_t points, double side) : side_(side), next_(points, -1) {
    std::size_t size = 64;
    while (size < 2 * points) size *= 2;
    head_.assign(size, -1);
  }

  Block of(const Position& point) const {
    Block block;
    for (int axis = 0; axis < 3; ++axis) block[axis] = floored(point[axis] / side_);
    return block;
  }

  void add(const Block& block, std::int32_t point) {
    std::int32_t& head = head_[bucket(block)];
    next_[point] = head;
    head = point;
  }

  template <class Visit>
  void visit(const Block& block, Visit&& visit_point) const {
    for (std::int32_t point = head_[bucket(block)]; point >= 0; point = next_[point]) visit_point(point);
  }

 private:
  std::size_t bucket(const Block& block) const {
    std::uint64_t key = 0;
    for (const std::int64_t part : block) key = (key ^ std::uint64_t(part)) * 0x9e3779b97f4a7c15u;
    return (key ^ key >> 29) & (head_.size() - 1);
  }

  double side_;
  std::vector<std::int32_t> next_, head_;
};

}  // namespace

std::vector<std::int32_t> nearest_kept(View<Position> points, View<double> reach, View<std::int32_t> order,
                                       double widest) {
  if (!(widest > 0.0)) throw std::invalid_argument("blocks need a positive width");
  Blocks blocks(points.size(), widest);
  std::vector<std::int32_t> keeper(points.size(), -1);
  for (const std::int32_t point : order) {
    const Block home = blocks.of(points[point]);
    double least = reach[point] * reach[point];
    for (int dx = -1; dx <= 1; ++dx)
      for (int dy = -1; dy <= 1; ++dy)
        for (int dz = -1; dz <= 1; ++dz)
          blocks.visit({home[0] + dx, home[1] + dy, home[2] + dz}, [&](std::int32_t kept) {
            const Position apart = minus(points[point], points[kept]);
            const double square = dot(apart, apart);
            if (square > least || (square == least && keeper[point] >= 0 && keeper[point] <= kept)) return;
            least = square;
            keeper[point] = kept;
          });
    if (keeper[point] >= 0) continue;
    keeper[point] = point;
    blocks.add(home, point);
  }
  return keeper;
}

}  // namespace symrecon
