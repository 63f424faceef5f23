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

}  // namespace symrecon
