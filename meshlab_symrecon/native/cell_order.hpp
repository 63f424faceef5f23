// An order of cells in which near ones are mostly near in memory.
#pragma once

#include <cstdint>
#include <vector>

#include "crust.hpp"
#include "view.hpp"

namespace symrecon {

// Cells by the earliest of their sites, of which there are `count`; spatial where the sites are.
std::vector<std::int32_t> by_earliest_site(View<Quad> cells, std::size_t count);

}  // namespace symrecon
