// Orders of sites and cells in which near ones are mostly near in memory.
#pragma once

#include <cstdint>
#include <vector>

#include "crust.hpp"
#include "view.hpp"

namespace symrecon {

// The first `count` sites along a Z-shaped curve (Morton 1966).
std::vector<std::int32_t> along_curve(View<Position> sites, std::int32_t count);

// Cells by the earliest of their sites, given the place of each site.
std::vector<std::int32_t> by_earliest_site(View<Quad> cells, const std::vector<std::int32_t>& place);

}  // namespace symrecon
