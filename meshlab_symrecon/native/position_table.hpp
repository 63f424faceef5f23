// Finds positions that are equal when rounded to single precision, as most files keep them.
#pragma once

#include <array>
#include <cstdint>
#include <algorithm>
#include <limits>
#include <vector>

#include "crust.hpp"
#include "saturating.hpp"
#include "view.hpp"

namespace symrecon {

// Open addressing; as many entries as announced, at most.
// Of the grid: what is nearly symmetric does not lie on both sides of a border.
constexpr double kOffset = 0.381966;

class PositionTable {
 public:
  // For so many positions with coordinates of at most the given size.
  PositionTable(std::size_t count, double largest) : steps_(largest > 0.0 ? std::min(0x1p24 / largest, std::numeric_limits<double>::max()) : 1.0) {
    std::size_t size = 64;
    while (size < 2 * count) {
      size *= 2;
      --shift_;
    }
    entries_.assign(size, -1);
  }

  // Enter the position of a vertex, unless an equal one is there; whether it was new.
  bool enter(View<Position> points, std::int32_t vertex) {
    const std::size_t mask = entries_.size() - 1;
    for (std::size_t slot = hash(points[vertex]) >> shift_;; slot = (slot + 1) & mask) {
      if (entries_[slot] < 0) {
        entries_[slot] = vertex;
        return true;
      }
      if (rounded(points[entries_[slot]]) == rounded(points[vertex])) return false;
    }
  }

 private:
  using Rounded = std::array<std::int64_t, 3>;

  Rounded rounded(const Position& position) const {
    Rounded place;
    for (int axis = 0; axis < 3; ++axis) place[axis] = floored(position[axis] * steps_ + kOffset);
    return place;
  }

  std::uint64_t hash(const Position& position) const {
    std::uint64_t mixed = 0;
    for (const std::int64_t part : rounded(position)) {
      mixed = (mixed ^ std::uint64_t(part)) * 0x9e3779b97f4a7c15u;
      mixed ^= mixed >> 29;
    }
    return mixed * 0x9e3779b97f4a7c15u;
  }

  double steps_;  // a unit
  std::vector<std::int32_t> entries_;
  int shift_ = 58;
};

}  // namespace symrecon
