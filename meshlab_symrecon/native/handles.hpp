// Growth of a labelled set of sites that keeps out the small bridges by which noise adds handles.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "crust.hpp"
#include "progress.hpp"
#include "view.hpp"

namespace symrecon {

// The part of `wanted` that can be reached from `certain` without a bridge made of uncertain sites.
//
// A site of `wanted` joins the set when, round that site, the set's parts belong to different
// components of the set: such a step adds no loop.  What remains would close loops through uncertain
// sites alone.  Sites of large `size` join first.  `certain` is a part of `wanted`.
// `checkpoint` is called now and then and may throw.
std::vector<std::uint8_t> grow_without_loops(View<Quad> cells, View<std::uint8_t> wanted,
                                             View<std::uint8_t> certain, View<double> size,
                                             const Checkpoint& checkpoint);

}  // namespace symrecon
