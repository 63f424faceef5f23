// Finds equal positions.
#pragma once

#include <cstdint>
#include <cstring>
#include <vector>

#include "crust.hpp"

namespace symrecon {

// Open addressing; as many entries as announced, at most.
class PositionTable {
 public:
  explicit PositionTable(std::size_t count) {
    std::size_t size = 64;
    while (size < 2 * count) {
      size *= 2;
      --shift_;
    }
    entries_.assign(size, -1);
  }

  // Enter the position of a vertex, unless an equal one is there; whether it was new.
  bool enter(const std::vector<Position>& points, std::int32_t vertex) {
    const std::size_t mask = entries_.size() - 1;
    for (std::size_t slot = hash(points[vertex]) >> shift_;; slot = (slot + 1) & mask) {
      if (entries_[slot] < 0) {
        entries_[slot] = vertex;
        return true;
      }
      if (points[entries_[slot]] == points[vertex]) return false;
    }
  }

 private:
  static std::uint64_t hash(const Position& position) {
    std::uint64_t mixed = 0;
    for (const double coordinate : position) {
      const double unsigned_zero = coordinate + 0.0;
      std::uint64_t bits;
      std::memcpy(&bits, &unsigned_zero, sizeof bits);
      mixed = (mixed ^ bits) * 0x9e3779b97f4a7c15u;
      mixed ^= mixed >> 29;
    }
    return mixed * 0x9e3779b97f4a7c15u;
  }

  std::vector<std::int32_t> entries_;
  int shift_ = 58;
};

}  // namespace symrecon
