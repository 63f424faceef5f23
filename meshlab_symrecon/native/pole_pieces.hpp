// Pieces of equally labelled cells of the power diagram.
#pragma once

#include <cstdint>
#include <vector>

#include "crust.hpp"
#include "view.hpp"

namespace symrecon {

// Turn over islands, then bubbles, whose sites count fewer than `smallest` samples.  Pieces with a
// fixed site stay, and so does the largest island.
std::vector<std::uint8_t> turn_small_pieces(View<Quad> cells, View<std::uint8_t> labels,
                                            View<std::uint8_t> fixed, View<std::int32_t> samples,
                                            double smallest);

}  // namespace symrecon
