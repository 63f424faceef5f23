// The cells of a triangulation of space with one vertex at infinity, and their adjacency.
//
// Every facet belongs to exactly two cells. A cell with the infinite vertex stands for the outside of a hull facet; it
// is oriented as if the vertex were a point beyond that facet.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <vector>

#include "memory_pages.hpp"
#include "prefetch.hpp"
#include "progress.hpp"

namespace symrecon {

using Four = std::array<std::int32_t, 4>;

constexpr std::int32_t infinite = -1;

struct alignas(32) Cell {  // half a cache line
  Four vertex;
  Four neighbour;  // neighbour[k] lies opposite vertex[k]

  bool is_infinite() const { return (vertex[0] | vertex[1] | vertex[2] | vertex[3]) < 0; }

  int place_of_infinite() const {
    for (int k = 0; k < 4; ++k)
      if (vertex[k] == infinite) return k;
    return -1;
  }

  // no branch: the place is unpredictable
  int place_of_neighbour(std::int32_t other) const {
    return int(neighbour[1] == other) + 2 * int(neighbour[2] == other) + 3 * int(neighbour[3] == other);
  }
};

// Replacing vertex k by a point p keeps the orientation of (row k, p).
constexpr int facet_vertices[4][3] = {{2, 1, 3}, {0, 2, 3}, {1, 0, 3}, {0, 1, 2}};

class CellComplex {
 public:
  enum Mark : std::uint8_t { unvisited, outside_cavity, in_cavity, deleted };

  void reserve(std::size_t count) {
    cells_.reserve(count);
    marks_.reserve(count);
    prefer_large_pages(cells_.data(), count * sizeof(Cell));
  }

  std::int32_t create() {
    if (!free_.empty()) {
      const std::int32_t index = free_.back();
      free_.pop_back();
      marks_[index] = unvisited;
      return index;
    }
    if (cells_.size() >= std::size_t(std::numeric_limits<std::int32_t>::max()))
      throw std::length_error("the triangulation needs more cells than 32-bit indices can number");
    cells_.emplace_back();
    marks_.push_back(unvisited);
    return std::int32_t(cells_.size() - 1);
  }

  void destroy(std::int32_t index) {
    marks_[index] = deleted;
    free_.push_back(index);
  }

  Cell& operator[](std::int32_t index) { return cells_[index]; }
  const Cell& operator[](std::int32_t index) const { return cells_[index]; }
  Mark& mark(std::int32_t index) { return marks_[index]; }
  bool exists(std::int32_t index) const { return marks_[index] != deleted; }
  std::int32_t size() const { return std::int32_t(cells_.size()); }

  // A hint that the cell will be read soon; worth a tenth of the time.
  void announce(std::int32_t index) const { prefetch(&cells_[index]); }

  // The cells that have a number, in the order of the numbers; -1 leaves a cell out.
  std::vector<Four> numbered_vertices(const std::vector<std::int32_t>& number, std::size_t count) const {
    std::vector<Four> vertices(count);
    for (std::size_t i = 0; i < cells_.size(); ++i)
      if (number[i] >= 0) vertices[number[i]] = cells_[i].vertex;
    return vertices;
  }

  // Their neighbours by number. Packed inside the old cells before the copy, so that the memory of the other half can be
  // given up; leaves the complex empty.
  std::vector<Four> take_numbered_neighbours(const std::vector<std::int32_t>& number, std::size_t count,
                                             const Checkpoint& checkpoint) {
    std::size_t packed = 0;
    for (std::size_t i = 0; i < cells_.size(); ++i) {
      if (i % cells_per_checkpoint == 0) checkpoint();
      if (number[i] < 0) continue;
      Four renumbered;
      for (int k = 0; k < 4; ++k) renumbered[k] = number[cells_[i].neighbour[k]];
      packed_four(packed++) = renumbered;  // packed <= i: overwrites only what has been read
    }
    const std::size_t kept = (packed + 1) / 2;
    abandon(cells_.data() + kept, (cells_.size() - kept) * sizeof(Cell));
    std::vector<Four> neighbours(count);
    packed = 0;
    for (std::size_t i = 0; i < number.size(); ++i) {
      if (i % cells_per_checkpoint == 0) checkpoint();
      if (number[i] >= 0) neighbours[number[i]] = packed_four(packed++);
    }
    std::vector<Cell>().swap(cells_);
    std::vector<Mark>().swap(marks_);
    std::vector<std::int32_t>().swap(free_);
    return neighbours;
  }

 private:
  Four& packed_four(std::size_t i) { return i % 2 == 0 ? cells_[i / 2].vertex : cells_[i / 2].neighbour; }

  std::vector<Cell> cells_;
  std::vector<Mark> marks_;
  std::vector<std::int32_t> free_;
};

}  // namespace symrecon
