// Islands and bubbles among the sides of cells: pieces with few boundary facets, turned over.
#include <cstdint>
#include <vector>

#include "cell_sides.hpp"
#include "disjoint_sets.hpp"

namespace symrecon {

// The pieces of either side, by their first cells, and how many boundary facets each has there.
CellSides::Pieces CellSides::pieces() const {
  const auto count = static_cast<std::int32_t>(cells_.size());
  DisjointSets joined(count);
  for (std::int32_t cell = 0; cell < count; ++cell)
    for (const std::int32_t next : cells_[cell].across)
      if (next >= 0 && next < cell && sides_[next] == sides_[cell]) joined.join(cell, next);
  Pieces found{std::vector<std::int32_t>(count), std::vector<std::int64_t>(count, 0),
               std::vector<std::uint8_t>(count, 0)};
  for (std::int32_t cell = 0; cell < count; ++cell) {
    const std::int32_t piece = found.of_cell[cell] = joined.find(cell);
    for (const std::int32_t next : cells_[cell].across)
      found.facets[piece] += next >= 0 && sides_[next] != sides_[cell];
    if (!movable(cell)) found.fixed[piece] = 1;
  }
  return found;
}

// Turn over the pieces of a side with fewer boundary facets, of inner ones not the largest; false when
// there are none.
bool CellSides::turn_pieces(const Pieces& pieces, std::int64_t smallest, Side side) {
  const auto count = static_cast<std::int32_t>(cells_.size());
  std::int32_t spared = -1;
  for (std::int32_t cell = 0; side == inner_side && cell < count; ++cell)
    if (sides_[cell] == side && (spared < 0 || pieces.facets[cell] > pieces.facets[spared])) spared = cell;
  Chosen small;
  for (std::int32_t cell = 0; cell < count; ++cell) {
    const std::int32_t piece = pieces.of_cell[cell];
    if (sides_[cell] == side && pieces.facets[piece] < smallest && !pieces.fixed[piece] && piece != spared)
      small.push_back(cell);
  }
  turn(small);
  collect_touched(small);
  for (const std::int32_t sample : touched_) pinches_[sample] = count_pinches(sample);
  return !small.empty();
}

void CellSides::turn_small_pieces(std::int64_t smallest) {
  Pieces found = pieces();
  if (turn_pieces(found, smallest, inner_side)) found = pieces();
  turn_pieces(found, smallest, outer_side);
}

}  // namespace symrecon
