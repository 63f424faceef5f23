// Shortest paths in the signed double cover of the pole graph: every pole has an outer and an inner
// copy; intersecting balls join equal copies, opposite poles different ones.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "network.hpp"
#include "opposite_poles.hpp"
#include "patience.hpp"

namespace symrecon {

// The length of the shortest path from the outer copies of the seeds to a pole's outer and to its
// inner copy; infinite where there is none.  No length is negative.
using PathCosts = std::array<std::vector<double>, 2>;

PathCosts evidence_paths(const Network& same_side, const OppositePoles& other_side,
                         View<std::uint8_t> seeds, const Progress& progress);

}  // namespace symrecon
