#include "power_shape.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace symrecon {
namespace {

// Put the corners of simplices and then the simplices in order, and drop repeated ones.
template <class Simplex>
void make_unique(std::vector<Simplex>& simplices, std::size_t poles) {
  for (Simplex& simplex : simplices) std::sort(simplex.begin(), simplex.end());
  // by the first corner (a counting sort), then by the others
  std::vector<std::int64_t> start(poles + 1, 0);
  for (const Simplex& simplex : simplices) ++start[simplex[0] + 1];
  for (std::size_t pole = 0; pole < poles; ++pole) start[pole + 1] += start[pole];
  std::vector<Simplex> sorted(simplices.size());
  std::vector<std::int64_t> place(start.begin(), start.end() - 1);
  for (const Simplex& simplex : simplices) sorted[place[simplex[0]]++] = simplex;
  for (std::size_t pole = 0; pole < poles; ++pole)
    std::sort(sorted.begin() + start[pole], sorted.begin() + start[pole + 1]);
  sorted.erase(std::unique(sorted.begin(), sorted.end()), sorted.end());
  simplices = std::move(sorted);
}

// Let absorbers stand for the corners; simplices that lose a dimension go.
template <class Simplex>
void replace_absorbed(std::vector<Simplex>& simplices, const std::vector<std::int32_t>& absorber) {
  const auto lost = [&](Simplex& simplex) {
    for (std::int32_t& corner : simplex) corner = absorber[corner];
    std::sort(simplex.begin(), simplex.end());
    return std::adjacent_find(simplex.begin(), simplex.end()) != simplex.end();
  };
  simplices.erase(std::remove_if(simplices.begin(), simplices.end(), lost), simplices.end());
  make_unique(simplices, absorber.size());
}

PowerShape whole_shape(View<Quad> cells, View<Quad> neighbours, View<std::uint8_t> part) {
  PowerShape shape;
  for (std::size_t number = 0; number < cells.size(); ++number) {
    const Quad& cell = cells[number];
    for (int a = 0; a < 3; ++a)
      for (int b = a + 1; b < 4; ++b)
        if (part[cell[a]] != 0 && part[cell[a]] == part[cell[b]]) shape.edges.push_back({cell[a], cell[b]});
    for (int k = 0; k < 4; ++k) {
      const std::int32_t next = neighbours[number][k];
      if (next >= 0 && next < static_cast<std::int32_t>(number)) continue;  // the facet's first cell gives it
      const Triangle facet = {cell[(k + 1) % 4], cell[(k + 2) % 4], cell[(k + 3) % 4]};
      const std::uint8_t common = part[facet[0]];
      if (common != 0 && part[facet[1]] == common && part[facet[2]] == common) shape.faces.push_back(facet);
    }
  }
  make_unique(shape.edges, part.size());
  make_unique(shape.faces, part.size());
  return shape;
}

std::vector<std::int32_t> absorbers(const std::vector<Pair>& edges, View<Position> centres,
                                    View<double> radii, double redundancy) {
  const std::size_t poles = centres.size();
  std::vector<std::int64_t> start(poles + 1, 0);
  for (const Pair& edge : edges)
    for (const std::int32_t end : edge) ++start[end + 1];
  for (std::size_t pole = 0; pole < poles; ++pole) start[pole + 1] += start[pole];
  std::vector<std::int32_t> joined(2 * edges.size());
  std::vector<std::int64_t> place(start.begin(), start.end() - 1);
  for (const Pair& edge : edges) {
    joined[place[edge[0]]++] = edge[1];
    joined[place[edge[1]]++] = edge[0];
  }

  std::vector<std::int32_t> order(poles), absorber(poles), seen_by(poles, -1), reached;
  std::iota(order.begin(), order.end(), 0);
  std::iota(absorber.begin(), absorber.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return radii[a] > radii[b]; });
  std::vector<std::uint8_t> settled(poles, 0);  // stands for itself, or is absorbed
  for (const std::int32_t pole : order) {
    if (settled[pole]) continue;
    settled[pole] = 1;
    reached.assign(1, pole);
    for (std::size_t k = 0; k < reached.size(); ++k)
      for (std::int64_t i = start[reached[k]]; i < start[reached[k] + 1]; ++i) {
        const std::int32_t other = joined[i];
        if (settled[other] || seen_by[other] == pole) continue;
        seen_by[other] = pole;
        const Position &p = centres[pole], &q = centres[other];
        const double apart = std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]);
        if (apart - (radii[pole] - radii[other]) >= redundancy) continue;
        settled[other] = 1;
        absorber[other] = pole;
        reached.push_back(other);
      }
  }
  return absorber;
}

}  // namespace

PowerShape power_shape(View<Quad> cells, View<Quad> neighbours, View<std::uint8_t> part,
                       View<Position> centres, View<double> radii, double redundancy) {
  PowerShape shape = whole_shape(cells, neighbours, part);
  if (redundancy > 0.0) {
    shape.absorber = absorbers(shape.edges, centres, radii, redundancy);
    replace_absorbed(shape.edges, shape.absorber);
    replace_absorbed(shape.faces, shape.absorber);
  } else {
    shape.absorber.resize(part.size());
    std::iota(shape.absorber.begin(), shape.absorber.end(), 0);
  }
  return shape;
}

}  // namespace symrecon
