// Incremental regular triangulation: locate a site, dig the cavity of the cells in conflict, fill it (Bowyer, Watson).
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "cell_complex.hpp"
#include "predicates.hpp"
#include "regular_triangulation.hpp"
#include "ridge_table.hpp"
#include "site.hpp"

namespace symrecon {

inline constexpr std::int32_t insertions_per_report = 1 << 14;
inline constexpr std::size_t expected_cells_per_site = 10;  // surface samples 8, their poles 9: a reservation, not a limit

class Triangulator {
 public:
  // `sites` in order of insertion, at different positions
  Triangulator(const std::vector<Site>& sites, const Margins& margins)
      : sites_(sites), margins_(margins), hidden_(sites.size(), 0), seen_(sites.size(), -1) {
    uniform_ = std::all_of(sites.begin(), sites.end(),
                           [&](const Site& site) { return site.weight == sites.front().weight; });
    complex_.reserve(expected_cells_per_site * sites.size() + 64);
  }

  // `simplex`: four sites that are not in one plane, ascending
  void build(const Four& simplex, const Progress& progress) {
    start(simplex);
    const std::int32_t count = std::int32_t(sites_.size());
    for (std::int32_t i = 0; i < count; ++i) {
      if (i % insertions_per_report == 0 && progress) progress(double(i) / double(count));
      if (std::find(simplex.begin(), simplex.end(), i) == simplex.end()) insert(i);
    }
  }

  CellComplex& complex() { return complex_; }
  bool is_hidden(std::int32_t site) const { return hidden_[site] != 0; }

  // A cell that contains the position of the site; infinite when it lies strictly outside the hull.
  std::int32_t locate(std::int32_t site) {
    std::int32_t current = last_, previous = -1;
    if (complex_[current].is_infinite())
      current = complex_[current].neighbour[complex_[current].place_of_infinite()];
    for (;;) {
      const Cell& cell = complex_[current];
      const int offset = int(next_random() & 3);
      std::int32_t next = -1;
      for (int i = 0; i < 4; ++i) {
        const int k = (i + offset) & 3;
        if (cell.neighbour[k] != previous && side_of_facet(cell, k, site) < 0) {
          next = cell.neighbour[k];
          break;
        }
      }
      if (next < 0) return last_ = current;
      if (complex_[next].is_infinite()) return last_ = next;
      previous = current;
      current = next;
    }
  }

 private:
  struct BoundaryFacet {
    Four vertex;      // of the new cell: the cavity's cell with one vertex replaced by the new site
    int place;        // of the new site
    std::int32_t outer;
    int outer_place;  // of the facet in the outer cell
  };

  void start(const Four& simplex) {
    Four vertex = simplex;
    const int sign = orientation(sites_[vertex[0]], sites_[vertex[1]], sites_[vertex[2]], sites_[vertex[3]], margins_);
    if (sign < 0) std::swap(vertex[0], vertex[1]);
    const std::int32_t finite = complex_.create();
    complex_[finite].vertex = vertex;
    for (int k = 0; k < 4; ++k) {
      // beyond facet k the orientation is reversed, so two of its vertices change places
      const std::int32_t outer = complex_.create();
      Four beyond = vertex;
      beyond[k] = infinite;
      std::swap(beyond[(k + 1) & 3], beyond[(k + 2) & 3]);
      complex_[outer].vertex = beyond;
      complex_[outer].neighbour[k] = finite;
      complex_[finite].neighbour[k] = outer;
    }
    for (int k = 0; k < 4; ++k) {
      Cell& outer = complex_[complex_[finite].neighbour[k]];
      for (int j = 0; j < 4; ++j) {
        if (j == k) continue;  // opposite the vertex of place i lies the infinite cell beyond facet i
        const int i = int(std::find(vertex.begin(), vertex.end(), outer.vertex[j]) - vertex.begin());
        outer.neighbour[j] = complex_[finite].neighbour[i];
      }
    }
    last_ = finite;
  }

  // > 0 when the site lies on the cell's side of its facet k
  int side_of_facet(const Cell& cell, int k, std::int32_t site) const {
    const int* place = facet_vertices[k];
    return orientation(sites_[cell.vertex[place[0]]], sites_[cell.vertex[place[1]]], sites_[cell.vertex[place[2]]],
                       sites_[site], margins_);
  }

  bool in_conflict(std::int32_t index, std::int32_t site) const {
    const Cell* cell = &complex_[index];
    if (cell->is_infinite()) {
      const int k = cell->place_of_infinite();
      const int side = side_of_facet(*cell, k, site);
      if (side != 0) return side > 0;
      // In the plane of the hull facet: the power to its orthocircle decides. The finite neighbour has the same, since
      // the coefficient of its fourth vertex vanishes.
      cell = &complex_[cell->neighbour[k]];
    }
    const Four& v = cell->vertex;
    return perturbed_power_test(sites_[v[0]], sites_[v[1]], sites_[v[2]], sites_[v[3]], sites_[site], margins_) > 0;
  }

  void insert(std::int32_t site) {
    const std::int32_t found = locate(site);
    if (!in_conflict(found, site)) {
      hidden_[site] = 1;
      return;
    }
    dig_cavity(found, site);
    if (!uniform_) hide_swallowed(site);
    for (std::int32_t index : cavity_) complex_.destroy(index);
    for (std::int32_t index : visited_outside_) complex_.mark(index) = CellComplex::unvisited;
    fill_cavity();
  }

  // All cells in conflict are connected; collect them and the facets around them.
  void dig_cavity(std::int32_t first, std::int32_t site) {
    cavity_.assign(1, first);
    visited_outside_.clear();
    boundary_.clear();
    complex_.mark(first) = CellComplex::in_cavity;
    for (std::size_t next = 0; next < cavity_.size(); ++next) {
      const std::int32_t index = cavity_[next];
      const Cell& cell = complex_[index];
      if (next + 1 < cavity_.size()) complex_.announce_neighbours(cavity_[next + 1]);
      // All tests before the first consequence: their outcomes are unpredictable, so that a branch after each would
      // keep the processor from working on several at a time.
      std::uint8_t verdicts[4];
      for (int k = 0; k < 4; ++k) {
        verdicts[k] = complex_.mark(cell.neighbour[k]);
        if (verdicts[k] == CellComplex::unvisited)
          verdicts[k] = in_conflict(cell.neighbour[k], site) ? CellComplex::in_cavity : CellComplex::outside_cavity;
      }
      for (int k = 0; k < 4; ++k) {
        const std::int32_t other = cell.neighbour[k];
        std::uint8_t& mark = complex_.mark(other);
        if (mark == CellComplex::unvisited) {
          mark = verdicts[k];
          (mark == CellComplex::in_cavity ? cavity_ : visited_outside_).push_back(other);
        }
        if (mark == CellComplex::outside_cavity) {
          BoundaryFacet facet = {cell.vertex, k, other, complex_[other].place_of_neighbour(index)};
          facet.vertex[k] = site;
          boundary_.push_back(facet);
        }
      }
    }
  }

  // Vertices of the cavity that are not on its boundary lose all their cells.
  void hide_swallowed(std::int32_t site) {
    for (const BoundaryFacet& facet : boundary_)
      for (std::int32_t vertex : facet.vertex)
        if (vertex != infinite) seen_[vertex] = site;
    for (std::int32_t index : cavity_)
      for (std::int32_t vertex : complex_[index].vertex)
        if (vertex != infinite && seen_[vertex] != site) hidden_[vertex] = 1;
  }

  void fill_cavity() {
    ridges_.prepare(boundary_.size());
    for (const BoundaryFacet& facet : boundary_) {
      const std::int32_t created = complex_.create();
      Cell& cell = complex_[created];
      cell.vertex = facet.vertex;
      cell.neighbour[facet.place] = facet.outer;
      complex_[facet.outer].neighbour[facet.outer_place] = created;
      for (int k = 0; k < 4; ++k)
        if (k != facet.place) link(created, k, facet);
      last_ = created;
    }
  }

  // Facet k of a new cell holds the new site and one ridge of the boundary: the two other places.
  void link(std::int32_t created, int k, const BoundaryFacet& facet) {
    std::int32_t ridge[2];
    int found = 0;
    for (int j = 0; j < 4; ++j)
      if (j != k && j != facet.place) ridge[found++] = facet.vertex[j];
    const RidgeTable::Side* mate = ridges_.match(ridge[0], ridge[1], {created, k});
    if (mate == nullptr) return;
    complex_[created].neighbour[k] = mate->cell;
    complex_[mate->cell].neighbour[mate->facet] = created;
  }

  // xorshift32: breaks the walk's habit of preferring low facets; fixed seed
  std::uint32_t next_random() {
    random_ ^= random_ << 13;
    random_ ^= random_ >> 17;
    random_ ^= random_ << 5;
    return random_;
  }

  const std::vector<Site>& sites_;
  Margins margins_;
  bool uniform_ = false;
  CellComplex complex_;
  std::vector<std::uint8_t> hidden_;
  std::vector<std::int32_t> seen_;  // per site: the last insertion whose cavity had it on the boundary
  std::vector<std::int32_t> cavity_, visited_outside_;
  std::vector<BoundaryFacet> boundary_;
  RidgeTable ridges_;
  std::int32_t last_ = 0;
  std::uint32_t random_ = 2463534242u;
};

}  // namespace symrecon
