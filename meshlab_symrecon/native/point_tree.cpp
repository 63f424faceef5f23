#include "point_tree.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "vectors.hpp"

namespace symrecon {
namespace {

constexpr double nowhere = std::numeric_limits<double>::infinity();
constexpr int most_waiting = 128;

// The larger one of a number and 0, by arithmetic: which it is cannot be foreseen, and branches would take longer.
inline double positive(double number) { return 0.5 * (number + std::abs(number)); }

struct Box {
  Position low{nowhere, nowhere, nowhere}, high{-nowhere, -nowhere, -nowhere};
};

Box box_of(View<Position> points, const std::int32_t* begin, const std::int32_t* end) {
  Box box;
  for (const std::int32_t* point = begin; point != end; ++point)
    for (int axis = 0; axis < 3; ++axis) {
      box.low[axis] = std::min(box.low[axis], points[*point][axis]);
      box.high[axis] = std::max(box.high[axis], points[*point][axis]);
    }
  return box;
}

// Moves the smaller half of a range along the widest axis of its box to the front; ties go by index.
std::int32_t* halve(View<Position> points, std::int32_t* begin, std::int32_t* end) {
  const Box box = box_of(points, begin, end);
  const Position widths = minus(box.high, box.low);
  const auto axis = std::max_element(widths.begin(), widths.end()) - widths.begin();
  std::int32_t* const middle = begin + (end - begin) / 2;
  std::nth_element(begin, middle, end, [&](std::int32_t a, std::int32_t b) {
    const double left = points[a][axis], right = points[b][axis];
    return left < right || (left == right && a < b);
  });
  return middle;
}

}  // namespace

struct PointTree::Search {
  Position place;
  double square;  // distance of the best so far, squared
  std::int32_t best;

  // No point in a box is nearer than this.
  void squares_to(const Boxes& boxes, double (&squares)[children]) const {
    for (std::size_t child = 0; child < children; ++child) squares[child] = 0.0;
    for (int axis = 0; axis < 3; ++axis)
      for (std::size_t child = 0; child < children; ++child) {
        const double outside = positive(boxes.low[axis][child] - place[axis]) +
                               positive(place[axis] - boxes.high[axis][child]);  // at most one is not 0
        squares[child] += outside * outside;
      }
  }

  void scan(const Leaf& leaf) {
    double squares[largest_leaf] = {}, least = nowhere;
    for (int axis = 0; axis < 3; ++axis)
      for (std::size_t i = 0; i < largest_leaf; ++i) {
        const double apart = leaf.places[axis][i] - place[axis];
        squares[i] += apart * apart;
      }
    for (std::size_t i = 0; i < largest_leaf; ++i) least = std::min(least, squares[i]);
    if (least > square) return;
    for (std::size_t i = 0; i < largest_leaf; ++i)
      if (squares[i] == least && (least < square || leaf.points[i] < best)) {
        square = least;
        best = leaf.points[i];
      }
  }
};

PointTree::PointTree(View<Position> points) {
  std::size_t leaves = 1;
  for (; leaves * largest_leaf < points.size(); leaves *= children) inner_.resize(inner_.size() + leaves);
  leaves_.resize(leaves);
  std::vector<std::int32_t> order(points.size());
  std::iota(order.begin(), order.end(), 0);
  arrange(points, 0, order.data(), order.data() + order.size());
}

void PointTree::arrange(View<Position> points, std::size_t node, Range begin, Range end) {
  if (node >= inner_.size()) {
    Leaf& leaf = leaves_[node - inner_.size()];
    for (auto& row : leaf.places) std::fill(std::begin(row), std::end(row), nowhere);
    for (std::size_t i = 0; begin + i != end; ++i) {
      for (int axis = 0; axis < 3; ++axis) leaf.places[axis][i] = points[begin[i]][axis];
      leaf.points[i] = begin[i];
    }
    return;
  }
  Range const middle = halve(points, begin, end);
  const std::array<Range, 5> borders = {begin, halve(points, begin, middle), middle, halve(points, middle, end), end};
  for (std::size_t child = 0; child < children; ++child) {
    const Box box = box_of(points, borders[child], borders[child + 1]);
    for (int axis = 0; axis < 3; ++axis) {
      inner_[node].low[axis][child] = box.low[axis];
      inner_[node].high[axis][child] = box.high[axis];
    }
    arrange(points, children * node + child + 1, borders[child], borders[child + 1]);
  }
}

std::int32_t PointTree::closest(const Position& place, std::int32_t guess, double limit) const {
  Search search{place, limit, guess};
  struct {
    std::size_t node;
    double square;
  } waiting[most_waiting];
  int count = 0;
  waiting[count++] = {0, 0.0};
  while (count > 0) {
    auto [node, least] = waiting[--count];
    while (least <= search.square && node < inner_.size()) {
      double squares[children];
      search.squares_to(inner_[node], squares);
      std::size_t nearest = 0;
      for (std::size_t child = 1; child < children; ++child)
        if (squares[child] < squares[nearest]) nearest = child;
      for (std::size_t child = 0; child < children; ++child) {
        waiting[count] = {children * node + child + 1, squares[child]};
        count += child != nearest && squares[child] <= search.square;
      }
      node = children * node + nearest + 1;
      least = squares[nearest];
    }
    if (least <= search.square) search.scan(leaves_[node - inner_.size()]);
  }
  return search.best;
}

}  // namespace symrecon
