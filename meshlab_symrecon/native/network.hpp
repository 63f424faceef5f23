// A graph with lengths.
#pragma once

#include <cstdint>

#include "view.hpp"

namespace symrecon {

// Neighbours of node i are ends[offsets[i]] .. ends[offsets[i + 1] - 1], at these lengths.
struct Network {
  View<std::int64_t> offsets;
  View<std::int32_t> ends;
  View<float> lengths;
};

}  // namespace symrecon
