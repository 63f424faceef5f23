// Regular (weighted Delaunay) triangulation of points in space, valid for every input that spans three dimensions.
//
// Incremental insertion (Bowyer 1981, Watson 1981) with one vertex at infinity, exact predicates and symbolically
// perturbed weights. The perturbed heights are in general position, so the triangulation is unique, has no flat cells,
// and the cells in conflict with a new site always form a star-shaped cavity around it.
#pragma once

#include <cstdint>
#include <vector>

#include "cell_complex.hpp"
#include "progress.hpp"
#include "site.hpp"

namespace symrecon {

struct RegularTriangulation {
  int rank = 0;  // dimension spanned by the positions; there are cells only when it is 3
  std::vector<Four> cells;       // site indices, positively oriented
  std::vector<Four> neighbours;  // neighbour k lies opposite vertex k; -1 outside the hull
  std::vector<std::int32_t> representative;  // per site: itself, or the site at the same position that stands for it
  std::vector<std::int32_t> hidden_cell;     // per site: -1, or for a hidden site the cell that contains it
};

// `sites` are finite. Throws std::length_error when the cells outgrow 32-bit indices.
RegularTriangulation regular_triangulation(std::vector<Site> sites, const Progress& progress);

}  // namespace symrecon
