// Order of insertion: rounds of growing random size (Amenta, Choi, Rote 2003), each along a Hilbert curve.
#pragma once

#include <cstdint>
#include <vector>

#include "progress.hpp"
#include "site.hpp"

namespace symrecon {

// Permutation of the sites that depends on their positions and weights only, not on their order: which round a site
// joins is a hash of its position. Sites at equal positions are neighbours in it, the largest weight first, then the
// smallest index. Negative zeros must have been removed. Progress is told of nothing done, only to be asked whether to
// go on.
std::vector<std::int32_t> spatial_order(const std::vector<Site>& sites, const Progress& progress);

// Indices of the distinct positions along one Hilbert curve, so that what is near in space is near in memory; of sites
// at one position the first. Depends on the positions only. Negative zeros must have been removed.
std::vector<std::int32_t> curve_order(const std::vector<Site>& sites);

}  // namespace symrecon
