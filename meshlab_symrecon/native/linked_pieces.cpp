#include "linked_pieces.hpp"

#include <algorithm>

#include "disjoint_sets.hpp"
#include "vectors.hpp"

namespace symrecon {

std::vector<std::int32_t> linked_pieces(View<Position> sites, View<Quad> cells, View<double> room,
                                        View<std::uint8_t> loose, double reach) {
  const std::int32_t samples = static_cast<std::int32_t>(room.size());
  DisjointSets pieces(room.size());
  const auto links = [&](std::int32_t a, std::int32_t b) {
    if (a >= samples || b >= samples || loose[a] || loose[b]) return false;
    const Position side = minus(sites[a], sites[b]);
    const double longest = reach * std::min(room[a], room[b]);
    return dot(side, side) <= longest * longest;
  };
  for (const Quad& cell : cells)
    for (int a = 0; a < 3; ++a)
      for (int b = a + 1; b < 4; ++b)
        if (links(cell[a], cell[b])) pieces.join(cell[a], cell[b]);
  return pieces.numbers();
}

}  // namespace symrecon
