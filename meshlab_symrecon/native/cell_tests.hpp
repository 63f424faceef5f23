// The predicates asked of cells of a complex.
#pragma once

#include <cstdint>
#include <vector>

#include "cell_complex.hpp"
#include "predicates.hpp"
#include "site.hpp"

namespace symrecon {

class CellTests {
 public:
  CellTests(const std::vector<Site>& sites, const Margins& margins, const CellComplex& complex)
      : sites_(sites.data()), margins_(margins), complex_(complex) {}

  // > 0 when the site lies on the cell's side of its facet k
  int side_of_facet(const Cell& cell, int k, std::int32_t site) const {
    const int* place = facet_vertices[k];
    return orientation(sites_[cell.vertex[place[0]]], sites_[cell.vertex[place[1]]], sites_[cell.vertex[place[2]]],
                       sites_[site], margins_);
  }

  // The first stage for a finite cell: > 0 in conflict, < 0 not, else `undecided`.
  int filtered_conflict(const Cell& cell, const Site& site, double& permanent) const {
    const Four& v = cell.vertex;
    return filtered_power_test(sites_[v[0]], sites_[v[1]], sites_[v[2]], sites_[v[3]], site, margins_.power, permanent);
  }

  // The further stages.
  bool unfiltered_conflict(const Cell& cell, const Site& site, double permanent) const {
    const Four& v = cell.vertex;
    const Site &a = sites_[v[0]], &b = sites_[v[1]], &c = sites_[v[2]], &d = sites_[v[3]];
    const int sign = unfiltered_power_test(a, b, c, d, site, permanent, margins_);
    return (sign != 0 ? sign : perturbation_sign(a, b, c, d, site, margins_)) > 0;
  }

  // All stages, for any cell.
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
    double permanent;
    const int sign = filtered_conflict(*cell, sites_[site], permanent);
    return sign != undecided ? sign > 0 : unfiltered_conflict(*cell, sites_[site], permanent);
  }

  const Site& site(std::int32_t index) const { return sites_[index]; }

 private:
  const Site* sites_;
  Margins margins_;
  const CellComplex& complex_;
};

}  // namespace symrecon
