// Incremental regular triangulation: locate a site, dig the cavity of the cells in conflict, fill it (Bowyer, Watson).
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "cavity.hpp"
#include "cell_complex.hpp"
#include "cell_tests.hpp"
#include "predicates.hpp"
#include "progress.hpp"
#include "regular_triangulation.hpp"
#include "site.hpp"

namespace symrecon {

inline constexpr std::size_t expected_cells_per_site = 10;  // surface samples 8, their poles 9: a reservation, not a limit

class Triangulator {
 public:
  // `sites` in order of insertion, at different positions
  Triangulator(const std::vector<Site>& sites, const Margins& margins)
      : sites_(sites),
        margins_(margins),
        hidden_(sites.size(), 0),
        tests_(sites, margins, complex_),
        cavity_(complex_, tests_, sites.size()) {
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
        if (cell.neighbour[k] != previous && tests_.side_of_facet(cell, k, site) < 0) {
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

  void insert(std::int32_t site) {
    const std::int32_t found = locate(site);
    if (!tests_.in_conflict(found, site)) {
      hidden_[site] = 1;
      return;
    }
    cavity_.dig(found, site);
    if (!uniform_) cavity_.for_each_swallowed(site, [&](std::int32_t vertex) { hidden_[vertex] = 1; });
    last_ = cavity_.fill(site);
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
  std::vector<std::uint8_t> hidden_;
  CellComplex complex_;
  CellTests tests_;
  Cavity cavity_;
  std::int32_t last_ = 0;
  std::uint32_t random_ = 2463534242u;
};

}  // namespace symrecon
