// A balanced tree of points for exact nearest-point searches (Friedman, Bentley and Finkel 1977).
#pragma once

#include <cstdint>
#include <vector>

#include "crust.hpp"
#include "view.hpp"

namespace symrecon {

class PointTree {
 public:
  explicit PointTree(View<Position> points);

  // The point closest to a place, the first of several at one distance; `guess` is any point, a near one saves time.
  std::int32_t closest(const Position& place, std::int32_t guess) const;

 private:
  struct Search;

  void arrange(std::size_t begin, std::size_t end);
  void search(std::size_t begin, std::size_t end, const Position& outside, double square, Search& search) const;

  // The points of a subtree are a range; its root is the median of the range along the root's axis, the smaller ones
  // come before it and the larger ones after it.
  std::vector<Position> places_;
  std::vector<std::int32_t> order_;  // index of the point at each place
  std::vector<std::uint8_t> axes_;
  std::vector<std::int32_t> ranks_;  // place of each point
};

}  // namespace symrecon
