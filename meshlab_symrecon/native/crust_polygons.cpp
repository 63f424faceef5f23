#include <stdexcept>

#include "crust.hpp"

namespace symrecon {
namespace {

// The six edges of a tetrahedron (0, 1, 2, 3), each followed by the other two corners so that the
// four are an even permutation: turning from the third to the fourth is counter-clockwise round
// the edge.
constexpr int kEdges[6][4] = {{0, 1, 2, 3}, {0, 2, 3, 1}, {0, 3, 1, 2},
                              {1, 2, 0, 3}, {1, 3, 2, 0}, {2, 3, 0, 1}};

int edge_number(int a, int b) {
  static constexpr int kNumber[4][4] = {{-1, 0, 1, 2}, {0, -1, 3, 4}, {1, 3, -1, 5}, {2, 4, 5, -1}};
  return kNumber[a][b];
}

int corner_of(const Quad& cell, std::int32_t site) {
  for (int k = 0; k < 4; ++k)
    if (cell[k] == site) return k;
  throw std::invalid_argument("neighbouring cells of the triangulation do not share a facet");
}

}  // namespace

Polygons mixed_edge_polygons(const std::vector<Quad>& cells, const std::vector<Quad>& neighbours,
                             const std::vector<std::uint8_t>& inside) {
  Polygons result;
  result.offsets.push_back(0);
  std::vector<std::uint8_t> done(cells.size(), 0);  // a bit for each of the six edges
  for (std::size_t first = 0; first < cells.size(); ++first) {
    for (int number = 0; number < 6; ++number) {
      const int* corners = kEdges[number];
      std::int32_t from = cells[first][corners[0]], to = cells[first][corners[1]];
      if (inside[from] == inside[to] || (done[first] >> number & 1)) continue;
      std::int32_t behind = cells[first][corners[2]], ahead = cells[first][corners[3]];
      if (!inside[from]) {  // the ring runs counter-clockwise round the way from inside to outside
        std::swap(from, to);
        std::swap(behind, ahead);
      }
      std::int32_t cell = static_cast<std::int32_t>(first);
      do {
        const Quad& sites = cells[cell];
        done[cell] |= 1 << edge_number(corner_of(sites, from), corner_of(sites, to));
        result.corners.push_back(cell);
        const std::int32_t next = neighbours[cell][corner_of(sites, behind)];
        if (next < 0) throw std::invalid_argument("an inner site lies on the hull");
        behind = ahead;
        for (const std::int32_t site : cells[next])
          if (site != from && site != to && site != behind) ahead = site;
        cell = next;
      } while (cell != static_cast<std::int32_t>(first));
      result.offsets.push_back(static_cast<std::int64_t>(result.corners.size()));
      result.inner.push_back(from);
      result.outer.push_back(to);
    }
  }
  return result;
}

}  // namespace symrecon
