// Poles of samples, and how densely the samples lie.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "crust.hpp"
#include "orthocentres.hpp"
#include "progress.hpp"
#include "site.hpp"

namespace symrecon {

// The poles of samples, each once, in the order of the samples: no matter in which order the cells come.
struct FoundPoles {
  std::vector<std::int32_t> cells;  // per pole: the cell whose circumcentre it is
  std::vector<Point> centres;
  std::vector<std::int32_t> first;   // per sample: the farthest circumcentre of its cells; -1 without a cell
  std::vector<std::int32_t> second;  // the farthest one on the other side of the sample; -1 for none
};

// Sites from `samples` on are no samples.  Of equally far centres the one of the first cell counts.
FoundPoles find_poles(const std::vector<Site>& sites, View<Quad> cells,
                      std::int32_t samples, const Checkpoint& checkpoint);

// How far the samples round each sample are, in terms of its Delaunay neighbours.
struct Spacings {
  std::vector<double> next;  // distance to the nearest other sample
  std::vector<double> mean;  // mean distance of the four nearest neighbours, or of as many as there are
};

// A sample without a neighbour that is a sample gets infinity.
Spacings sample_spacings(const std::vector<Site>& sites, View<Quad> cells,
                         std::int32_t samples, const Checkpoint& checkpoint);

}  // namespace symrecon
