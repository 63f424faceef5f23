// The cells in conflict with a new site: found by a flood, and replaced by the cells of the site with their boundary.
//
// Whether a cell is in conflict is as unpredictable as a coin, and a wrong guess of the processor costs as much as a
// test. Both loops are therefore written without a branch on such outcomes (`append_if`), and tests that floating point
// cannot decide are put off until the others are done.
#pragma once

#include <cstdint>
#include <vector>

#include "buffer.hpp"
#include "cell_complex.hpp"
#include "cell_tests.hpp"
#include "ridge_table.hpp"

namespace symrecon {

class Cavity {
 public:
  Cavity(CellComplex& complex, const CellTests& tests, std::size_t sites)
      : complex_(complex), tests_(tests), numbers_(sites + 1) {}

  // Collect the cells in conflict, which are connected, from one of them.
  void dig(std::int32_t first, std::int32_t site) {
    inside_.clear();
    tested_.clear();
    tested_.make_room(1);
    tested_.append_if(true, first);
    doubts_.clear();
    decide(first, true);
    std::size_t next = 1, next_doubt = 0;
    for (;;) {
      for (; next < tested_.size(); ++next) test(tested_[next], site);
      if (next_doubt == doubts_.size()) break;
      for (; next_doubt < doubts_.size(); ++next_doubt) {
        const Doubt& doubt = doubts_[next_doubt];
        const Cell& cell = complex_[doubt.cell];
        decide(doubt.cell, cell.is_infinite()
                               ? tests_.in_conflict(doubt.cell, site)
                               : tests_.unfiltered_conflict(cell, tests_.site(site), doubt.permanent));
      }
    }
    collect_boundary(site);
    for (std::int32_t index : tested_) complex_.mark(index) = CellComplex::unvisited;
  }

  // Call `visit` for the vertices of the cavity that are not on its boundary.
  template <class Visit>
  void for_each_swallowed(std::int32_t site, Visit visit) const {
    for (std::int32_t index : inside_)
      for (std::int32_t vertex : complex_[index].vertex)
        if (numbers_[vertex + 1].insertion != site && vertex != infinite) visit(vertex);
  }

  // Replace the cavity by cells of the site; return one of them.
  std::int32_t fill(std::int32_t site) {
    const std::size_t vertices = boundary_.size() / 2 + 2;  // of a closed surface like a sphere
    if (vertices <= SmallRidgeTable::widest) return fill_with(small_ridges_, site);
    large_ridges_.prepare(3 * boundary_.size() / 2);
    return fill_with(large_ridges_, site);
  }

 private:
  struct Doubt {
    std::int32_t cell;
    double permanent;  // of a finite cell
  };

  struct BoundaryFacet {
    Four vertex;  // of the new cell: the cavity's cell, whose vertex at `place` will be the new site
    std::int32_t outer;
    std::int8_t place, outer_place;  // of the facet in the cell and in the outer one
  };

  struct Number {
    std::int32_t insertion = -1;  // the last site whose cavity had the vertex on its boundary
    std::int32_t number = 0;      // of the vertex on that boundary
  };

  void test(std::int32_t index, std::int32_t site) {
    const Cell& cell = complex_[index];
    double permanent = 0.0;
    const int verdict = cell.is_infinite() ? undecided : tests_.filtered_conflict(cell, tests_.site(site), permanent);
    doubts_.make_room(1);
    doubts_.append_if(verdict == undecided, {index, permanent});
    decide(index, verdict == 1);
  }

  // Marks a tested cell. It counts as outside as long as no test has shown it to be inside.
  void decide(std::int32_t index, bool conflict) {
    complex_.mark(index) = conflict ? CellComplex::in_cavity : CellComplex::outside_cavity;
    if (!conflict) return;
    inside_.make_room(1);
    inside_.append_if(true, index);
    tested_.make_room(4);
    for (std::int32_t other : complex_[index].neighbour) {
      complex_.announce(other);
      CellComplex::Mark& mark = complex_.mark(other);
      const bool fresh = mark == CellComplex::unvisited;
      tested_.append_if(fresh, other);
      mark = fresh ? CellComplex::outside_cavity : mark;
    }
  }

  void collect_boundary(std::int32_t site) {
    boundary_.clear();
    for (std::int32_t index : inside_) {
      const Cell& cell = complex_[index];
      boundary_.make_room(4);
      for (int k = 0; k < 4; ++k) {
        const std::int32_t other = cell.neighbour[k];
        boundary_.append_if(complex_.mark(other) == CellComplex::outside_cavity,
                            {cell.vertex, other, std::int8_t(k), std::int8_t(complex_[other].place_of_neighbour(index))});
      }
    }
    std::int32_t count = 0;
    for (const BoundaryFacet& facet : boundary_)
      for (int place : facet_vertices[facet.place]) {
        Number& entry = numbers_[facet.vertex[place] + 1];
        const bool fresh = entry.insertion != site;
        entry = {site, fresh ? count : entry.number};
        count += fresh;
      }
  }

  template <class Ridges>
  std::int32_t fill_with(Ridges& ridges, std::int32_t site) {
    const std::int32_t cells = std::int32_t(boundary_.size()), freed = std::int32_t(inside_.size());
    while (std::int32_t(inside_.size()) < cells) {
      inside_.make_room(1);
      inside_.append_if(true, complex_.create());
    }
    for (std::int32_t i = cells; i < freed; ++i) complex_.destroy(inside_[i]);
    for (std::int32_t i = 0; i < cells; ++i) {
      const BoundaryFacet& facet = boundary_[i];
      const int* place = facet_vertices[facet.place];
      const std::int32_t a = number_of(facet.vertex[place[0]]), b = number_of(facet.vertex[place[1]]),
                         c = number_of(facet.vertex[place[2]]);
      ridges.at(b, c) = ridges.at(c, a) = ridges.at(a, b) = inside_[i];
    }
    for (std::int32_t i = 0; i < cells; ++i) {
      const BoundaryFacet& facet = boundary_[i];
      const int* place = facet_vertices[facet.place];
      const std::int32_t a = number_of(facet.vertex[place[0]]), b = number_of(facet.vertex[place[1]]),
                         c = number_of(facet.vertex[place[2]]);
      Cell& cell = complex_[inside_[i]];
      cell.vertex = facet.vertex;
      cell.vertex[facet.place] = site;
      cell.neighbour[facet.place] = facet.outer;
      complex_[facet.outer].neighbour[facet.outer_place] = inside_[i];
      cell.neighbour[place[0]] = ridges.at(c, b);
      cell.neighbour[place[1]] = ridges.at(a, c);
      cell.neighbour[place[2]] = ridges.at(b, a);
    }
    return inside_[cells - 1];
  }

  std::int32_t number_of(std::int32_t vertex) const { return numbers_[vertex + 1].number; }

  CellComplex& complex_;
  const CellTests& tests_;
  Buffer<std::int32_t> inside_, tested_;
  Buffer<Doubt> doubts_;
  Buffer<BoundaryFacet> boundary_;
  std::vector<Number> numbers_;  // per vertex, the infinite one first
  SmallRidgeTable small_ridges_;
  LargeRidgeTable large_ridges_;
};

}  // namespace symrecon
