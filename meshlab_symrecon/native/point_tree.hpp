// A balanced tree of boxes around points, for exact nearest-point searches.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "crust.hpp"
#include "view.hpp"

namespace symrecon {

class PointTree {
 public:
  explicit PointTree(View<Position> points);

  // The point closest to a place, the first of several at one distance. The search begins at `guess`, any of the
  // points; a near one saves time. Where nothing lies within a distance whose square is `limit`, the guess is returned.
  std::int32_t closest(const Position& place, std::int32_t guess, double limit) const;

 private:
  static constexpr std::size_t children = 4, largest_leaf = 12;

  // Side by side, so that they are compared side by side.
  struct Boxes {
    double low[3][children], high[3][children];
  };
  struct Leaf {
    double places[3][largest_leaf];  // infinite where there is no point
    std::int32_t points[largest_leaf];
  };
  using Range = std::int32_t*;
  struct Search;

  void arrange(View<Position> points, std::size_t node, Range begin, Range end);

  // Node k has the children 4k + 1 .. 4k + 4; the nodes from the size of `inner_` on are the leaves.
  std::vector<Boxes> inner_;  // boxes of the children
  std::vector<Leaf> leaves_;
};

}  // namespace symrecon
