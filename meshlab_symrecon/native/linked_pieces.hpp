// Pieces of samples, linked by Delaunay edges that are short beside the spacing at both ends.
#pragma once

#include <cstdint>
#include <vector>

#include "crust.hpp"

namespace symrecon {

// The piece of each sample.  An edge links its ends when it is at most `reach` times the smaller of
// their rooms; samples that are `loose` link to nothing.  Sites beyond the rooms are no samples.
std::vector<std::int32_t> linked_pieces(View<Position> sites, View<Quad> cells, View<double> room,
                                        View<std::uint8_t> loose, double reach);

}  // namespace symrecon
