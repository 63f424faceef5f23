#include "cell_order.hpp"

#include <algorithm>

namespace symrecon {

std::vector<std::int32_t> by_earliest_site(View<Quad> cells, std::size_t count) {
  std::vector<std::int32_t> start(count + 1, 0);
  for (const Quad& cell : cells) ++start[*std::min_element(cell.begin(), cell.end()) + 1];
  for (std::size_t site = 0; site < count; ++site) start[site + 1] += start[site];
  std::vector<std::int32_t> order(cells.size());
  for (std::size_t cell = 0; cell < cells.size(); ++cell) {
    const std::int32_t earliest = *std::min_element(cells[cell].begin(), cells[cell].end());
    order[start[earliest]++] = static_cast<std::int32_t>(cell);
  }
  return order;
}

}  // namespace symrecon
