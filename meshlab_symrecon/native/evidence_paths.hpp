// Shortest paths in the signed double cover of the pole graph: every pole has an outer and an inner
// copy; intersecting balls join equal copies, opposite poles different ones.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "opposite_poles.hpp"
#include "pole_graph.hpp"

namespace symrecon {

// The cost of the cheapest path from the outer copies of the seeds to a pole's outer and to its inner
// copy; infinite where there is none.  An edge costs minus the logarithm of its cosine or certainty.
using PathCosts = std::vector<std::array<double, 2>>;

PathCosts evidence_paths(const PoleGraphView& graph, const OppositePoles& opposites,
                         View<std::uint8_t> seeds, const Progress& progress);

}  // namespace symrecon
