// The power shape: poles of one side joined as their power cells touch, and its simplification.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "crust.hpp"

namespace symrecon {

using Pair = std::array<std::int32_t, 2>;

struct PowerShape {
  std::vector<std::int32_t> absorber;  // of each pole: itself, or the pole whose ball stands for its own
  std::vector<Pair> edges;             // of poles that stand for themselves, each once, in order
  std::vector<Triangle> faces;         // likewise
};

// Edges and triangles of a regular triangulation whose poles are of one part; poles of part 0 are
// left out.  In the order of falling radius, a pole absorbs those joined to it, and then those joined
// to them, whose balls stick out of its own by less than `redundancy`; at 0 none does.
PowerShape power_shape(View<Quad> cells, View<Quad> neighbours, View<std::uint8_t> part,
                       View<Position> centres, View<double> radii, double redundancy);

}  // namespace symrecon
