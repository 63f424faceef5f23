#include "point_tree.hpp"

#include <algorithm>
#include <numeric>

#include "vectors.hpp"

namespace symrecon {
namespace {

constexpr std::size_t leaf = 8;  // points that are looked at one by one

int widest_axis(View<Position> points, const std::int32_t* begin, const std::int32_t* end) {
  Position low = points[*begin], high = low;
  for (const std::int32_t* point = begin; point != end; ++point)
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], points[*point][axis]);
      high[axis] = std::max(high[axis], points[*point][axis]);
    }
  const Position widths = minus(high, low);
  return int(std::max_element(widths.begin(), widths.end()) - widths.begin());
}

}  // namespace

struct PointTree::Search {
  Position place;
  double square;  // distance of the best so far, squared
  std::int32_t best;

  void offer(const Position& candidate, std::int32_t index) {
    const Position gap = minus(candidate, place);
    const double found = dot(gap, gap);
    if (found > square || (found == square && index >= best)) return;
    square = found;
    best = index;
  }
};

PointTree::PointTree(View<Position> points)
    : places_(points.begin(), points.end()), order_(points.size()), axes_(points.size()), ranks_(points.size()) {
  std::iota(order_.begin(), order_.end(), 0);
  arrange(0, order_.size());
  for (std::size_t rank = 0; rank < order_.size(); ++rank) {
    places_[rank] = points[order_[rank]];
    ranks_[order_[rank]] = std::int32_t(rank);
  }
}

void PointTree::arrange(std::size_t begin, std::size_t end) {
  if (end - begin <= leaf) return;
  const std::size_t middle = begin + (end - begin) / 2;
  std::int32_t* const order = order_.data();
  const int axis = widest_axis(places_, order + begin, order + end);
  std::nth_element(order + begin, order + middle, order + end, [&](std::int32_t a, std::int32_t b) {
    const double left = places_[a][axis], right = places_[b][axis];
    return left < right || (left == right && a < b);
  });
  axes_[middle] = std::uint8_t(axis);
  arrange(begin, middle);
  arrange(middle + 1, end);
}

// `outside` tells by how much the place lies outside the range's slab along each axis, `square` the sum of its squares:
// nothing in the range is nearer (Arya and Mount 1993).
void PointTree::search(std::size_t begin, std::size_t end, const Position& outside, double square,
                       Search& found) const {
  if (square > found.square) return;
  if (end - begin <= leaf) {
    for (std::size_t rank = begin; rank < end; ++rank) found.offer(places_[rank], order_[rank]);
    return;
  }
  const std::size_t middle = begin + (end - begin) / 2;
  const int axis = axes_[middle];
  const double beyond = found.place[axis] - places_[middle][axis];
  Position farther = outside;
  farther[axis] = beyond;
  const double farther_square = square - outside[axis] * outside[axis] + beyond * beyond;
  if (beyond < 0.0) {
    search(begin, middle, outside, square, found);
    found.offer(places_[middle], order_[middle]);
    search(middle + 1, end, farther, farther_square, found);
  } else {
    search(middle + 1, end, outside, square, found);
    found.offer(places_[middle], order_[middle]);
    search(begin, middle, farther, farther_square, found);
  }
}

std::int32_t PointTree::closest(const Position& place, std::int32_t guess) const {
  const Position gap = minus(places_[ranks_[guess]], place);
  Search found{place, dot(gap, gap), guess};
  search(0, places_.size(), {0.0, 0.0, 0.0}, 0.0, found);
  return found.best;
}

}  // namespace symrecon
