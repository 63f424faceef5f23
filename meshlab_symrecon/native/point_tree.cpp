#include "point_tree.hpp"

#include <algorithm>
#include <numeric>

#include "vectors.hpp"

namespace symrecon {
namespace {

constexpr std::size_t largest_leaf = 8;
constexpr int deepest = 64;

}  // namespace

struct PointTree::Search {
  Position place;
  double square;  // distance of the best so far, squared
  std::int32_t best;

  // No point in the box is nearer.
  double square_to(const Box& box) const {
    double square = 0.0;
    for (int axis = 0; axis < 3; ++axis) {
      const double outside = std::max({box.low[axis] - place[axis], place[axis] - box.high[axis], 0.0});
      square += outside * outside;
    }
    return square;
  }
};

PointTree::PointTree(View<Position> points) : leaves_(1), order_(points.size()) {
  while (leaves_ * largest_leaf < points.size()) leaves_ *= 2;
  boxes_.resize(2 * leaves_);
  starts_.assign(leaves_ + 1, points.size());
  std::iota(order_.begin(), order_.end(), 0);
  if (points.size() > 0) arrange(points, 1, 0, points.size());
  for (int axis = 0; axis < 3; ++axis)
    for (const std::int32_t point : order_) places_[axis].push_back(points[point][axis]);
}

// Halves a range of points along the widest axis of its box, until it is a leaf.
void PointTree::arrange(View<Position> points, std::size_t node, std::size_t begin, std::size_t end) {
  Box& box = boxes_[node] = {points[order_[begin]], points[order_[begin]]};
  for (std::size_t place = begin; place < end; ++place)
    for (int axis = 0; axis < 3; ++axis) {
      box.low[axis] = std::min(box.low[axis], points[order_[place]][axis]);
      box.high[axis] = std::max(box.high[axis], points[order_[place]][axis]);
    }
  if (node >= leaves_) {
    starts_[node - leaves_] = begin;
    return;
  }
  const Position widths = minus(box.high, box.low);
  const auto axis = std::max_element(widths.begin(), widths.end()) - widths.begin();
  const std::size_t middle = begin + (end - begin) / 2;
  std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
                   [&](std::int32_t a, std::int32_t b) {
                     const double left = points[a][axis], right = points[b][axis];
                     return left < right || (left == right && a < b);
                   });
  arrange(points, 2 * node, begin, middle);
  arrange(points, 2 * node + 1, middle, end);
}

void PointTree::scan(std::size_t leaf, Search& search) const {
  const std::size_t begin = starts_[leaf], count = starts_[leaf + 1] - begin;
  double squares[largest_leaf];
  for (std::size_t i = 0; i < count; ++i) {
    const double x = places_[0][begin + i] - search.place[0], y = places_[1][begin + i] - search.place[1],
                 z = places_[2][begin + i] - search.place[2];
    squares[i] = x * x + y * y + z * z;
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (squares[i] > search.square || (squares[i] == search.square && order_[begin + i] >= search.best)) continue;
    search.square = squares[i];
    search.best = order_[begin + i];
  }
}

std::int32_t PointTree::closest(const Position& place, std::int32_t guess, double limit) const {
  Search search{place, limit, guess};
  struct {
    std::size_t node;
    double square;
  } waiting[deepest];  // the farther one of two children, on each level
  int count = 0;
  waiting[count++] = {1, search.square_to(boxes_[1])};
  while (count > 0) {
    auto [node, square] = waiting[--count];
    while (square <= search.square && node < leaves_) {
      const double left = search.square_to(boxes_[2 * node]), right = search.square_to(boxes_[2 * node + 1]);
      const std::size_t nearer = 2 * node + (right < left);
      waiting[count] = {nearer ^ 1, std::max(left, right)};
      count += std::max(left, right) <= search.square;
      node = nearer;
      square = std::min(left, right);
    }
    if (square <= search.square) scan(node - leaves_, search);
  }
  return search.best;
}

}  // namespace symrecon
