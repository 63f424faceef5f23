#include "cell_order.hpp"

#include <algorithm>
#include <limits>

namespace symrecon {
namespace {

constexpr std::uint32_t kSteps = 1023;  // an axis: 10 bits, so that three make a key of 30

// Bits of a number of ten, each followed by two zeros.
std::uint32_t spread(std::uint32_t bits) {
  bits = (bits | bits << 16) & 0x030000FF;
  bits = (bits | bits << 8) & 0x0300F00F;
  bits = (bits | bits << 4) & 0x030C30C3;
  return (bits | bits << 2) & 0x09249249;
}

}  // namespace

std::vector<std::int32_t> along_curve(View<Position> sites, std::int32_t count) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Position low{kInfinity, kInfinity, kInfinity}, high{-kInfinity, -kInfinity, -kInfinity};
  for (std::int32_t site = 0; site < count; ++site)
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], sites[site][axis]);
      high[axis] = std::max(high[axis], sites[site][axis]);
    }
  const double extent = std::max({high[0] - low[0], high[1] - low[1], high[2] - low[2]});
  const double scale = extent > 0.0 ? kSteps / extent : 0.0;

  std::vector<std::uint64_t> keys(count);  // the place on the curve, then the number of the site
  for (std::int32_t site = 0; site < count; ++site) {
    std::uint32_t key = 0;
    for (int axis = 0; axis < 3; ++axis)
      key |= spread(static_cast<std::uint32_t>((sites[site][axis] - low[axis]) * scale)) << axis;
    keys[site] = std::uint64_t{key} << 32 | static_cast<std::uint32_t>(site);
  }
  std::sort(keys.begin(), keys.end());
  std::vector<std::int32_t> order(count);
  std::transform(keys.begin(), keys.end(), order.begin(),
                 [](std::uint64_t key) { return static_cast<std::int32_t>(key & 0xFFFFFFFF); });
  return order;
}

std::vector<std::int32_t> by_earliest_site(View<Quad> cells, const std::vector<std::int32_t>& place) {
  const auto earliest = [&](const Quad& cell) {
    return std::min({place[cell[0]], place[cell[1]], place[cell[2]], place[cell[3]]});
  };
  std::vector<std::int32_t> start(place.size() + 1, 0);
  for (const Quad& cell : cells) ++start[earliest(cell) + 1];
  for (std::size_t site = 0; site < place.size(); ++site) start[site + 1] += start[site];
  std::vector<std::int32_t> order(cells.size());
  for (std::size_t cell = 0; cell < cells.size(); ++cell)
    order[start[earliest(cells[cell])]++] = static_cast<std::int32_t>(cell);
  return order;
}

}  // namespace symrecon
