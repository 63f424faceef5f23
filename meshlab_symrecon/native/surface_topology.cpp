#include "surface_topology.hpp"

#include <algorithm>
#include <utility>

#include "disjoint_sets.hpp"

namespace symrecon {
namespace {

// A side of a face: side 3 f + k runs from corner k of face f to the next corner.
struct Side {
  std::int32_t far;     // the larger end
  std::int32_t number;  // 3 f + k
};

std::int32_t next_corner(std::int32_t corner) { return corner % 3 == 2 ? corner - 2 : corner + 1; }

// Sides by their smaller end: those of vertex v are sides[starts[v]] to sides[starts[v + 1]].
struct SortedSides {
  std::vector<std::int32_t> starts;
  std::vector<Side> sides;
};

// A counting sort by the smaller end, then each run by the larger one.
SortedSides sorted_sides(View<Triangle> faces, std::int32_t vertex_count) {
  const std::int32_t side_count = static_cast<std::int32_t>(3 * faces.size());
  const auto vertex = [&](std::int32_t corner) { return faces[corner / 3][corner % 3]; };
  std::vector<std::int32_t> starts(vertex_count + 1, 0);
  for (std::int32_t side = 0; side < side_count; ++side)
    ++starts[std::min(vertex(side), vertex(next_corner(side))) + 1];
  for (std::int32_t v = 0; v < vertex_count; ++v) starts[v + 1] += starts[v];
  std::vector<Side> sides(side_count);
  std::vector<std::int32_t> place(starts.begin(), starts.end() - 1);
  for (std::int32_t side = 0; side < side_count; ++side) {
    const std::int32_t a = vertex(side), b = vertex(next_corner(side));
    sides[place[std::min(a, b)]++] = {std::max(a, b), side};
  }
  for (std::int32_t v = 0; v < vertex_count; ++v)
    std::sort(sides.begin() + starts[v], sides.begin() + starts[v + 1], [](const Side& a, const Side& b) {
      return a.far != b.far ? a.far < b.far : a.number < b.number;
    });
  return {std::move(starts), std::move(sides)};
}

}  // namespace

SurfaceTopology surface_topology(View<Triangle> faces, std::int32_t vertex_count) {
  const std::int32_t side_count = static_cast<std::int32_t>(3 * faces.size());
  const auto vertex = [&](std::int32_t corner) { return faces[corner / 3][corner % 3]; };
  const auto [starts, sides] = sorted_sides(faces, vertex_count);
  SurfaceTopology result;
  DisjointSets pieces(faces.size()), fans(side_count);
  std::vector<std::uint8_t> used(vertex_count, 0);
  for (const Triangle& face : faces)
    for (const std::int32_t v : face) used[v] = 1;
  result.vertices = std::count(used.begin(), used.end(), 1);

  for (std::int32_t v = 0; v < vertex_count; ++v) {
    for (std::int32_t i = starts[v]; i < starts[v + 1];) {
      std::int32_t end = i + 1;
      for (; end < starts[v + 1] && sides[end].far == sides[i].far; ++end) {
        const std::int32_t one = sides[end - 1].number, other = sides[end].number;
        pieces.join(one / 3, other / 3);
        const bool opposed = vertex(one) != vertex(other);
        fans.join(one, opposed ? next_corner(other) : other);
        fans.join(next_corner(one), opposed ? other : next_corner(other));
      }
      const std::int32_t uses = end - i;
      result.boundary += uses == 1;
      result.crowded += uses > 2;
      result.misoriented += uses == 2 && vertex(sides[i].number) == vertex(sides[i + 1].number);
      ++result.edges;
      i = end;
    }
  }
  std::int32_t count = 0;
  fans.numbers(&count);
  result.fans = count;
  result.piece = pieces.numbers(&count);
  result.components = count;
  return result;
}

}  // namespace symrecon
