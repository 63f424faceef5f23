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
  struct Box {
    Position low, high;
  };
  struct Search;

  void arrange(View<Position> points, std::size_t node, std::size_t begin, std::size_t end);
  void scan(std::size_t leaf, Search& search) const;

  // Node k has the children 2k and 2k + 1; node 1 is the root. Leaf k has the places from starts_[k] to starts_[k + 1].
  std::size_t leaves_;  // a power of two; node `leaves_ + k` is leaf k
  std::vector<Box> boxes_;
  std::vector<std::size_t> starts_;
  std::vector<std::int32_t> order_;            // index of the point at each place
  std::array<std::vector<double>, 3> places_;  // its coordinates
};

}  // namespace symrecon
