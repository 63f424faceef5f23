// Even samples of a cloud.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "crust.hpp"
#include "view.hpp"

namespace symrecon {

// The order of the first `count` points in which each one, from `first` on, is the farthest from all those before it,
// the first of several (Gonzalez 1985).
std::vector<std::int64_t> farthest_points(View<Position> points, std::size_t count, std::size_t first);

}  // namespace symrecon
