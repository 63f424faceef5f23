// Pieces of equally labelled cells of the power diagram.
#pragma once

#include <cstdint>
#include <vector>

#include "view.hpp"
#include "crust.hpp"

namespace symrecon {

// The piece of each site, connected by edges of the cells between sites of equal label.
std::vector<std::int32_t> label_pieces(View<Quad> cells, View<std::uint8_t> labels);

// Turn over islands, then bubbles, whose sites count fewer than `smallest` samples.  Pieces with a
// fixed site stay, and so does the largest island.
std::vector<std::uint8_t> turn_small_pieces(View<Quad> cells, View<std::uint8_t> labels,
                                            View<std::uint8_t> fixed, View<std::int32_t> samples,
                                            double smallest);

}  // namespace symrecon
