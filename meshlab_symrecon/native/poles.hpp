// Poles of samples, and how densely the samples lie.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "crust.hpp"

namespace symrecon {

// For each sample the cells whose circumcentres are its two poles; -1 where there is none.
struct PoleCells {
  std::vector<std::int32_t> first;   // farthest circumcentre of the sample's cells
  std::vector<std::int32_t> second;  // farthest one on the other side of the sample
};

// Sites from `samples` on are no samples.  Of equally far centres the one of the first cell counts.
PoleCells pole_cells(const std::vector<Position>& sites, const std::vector<Position>& centres,
                     const std::vector<Quad>& cells, std::int32_t samples);

// How far the samples round each sample are, in terms of its Delaunay neighbours.
struct Spacings {
  std::vector<double> next;  // distance to the nearest other sample
  std::vector<double> mean;  // mean distance of the four nearest neighbours, or of as many as there are
};

// A sample without a neighbour that is a sample gets infinity.
Spacings sample_spacings(const std::vector<Position>& sites, const std::vector<Quad>& cells,
                         std::int32_t samples);

}  // namespace symrecon
