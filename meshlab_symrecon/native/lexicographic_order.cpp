#include "lexicographic_order.hpp"

#include <algorithm>

namespace symrecon {

namespace {

// A copy of the first coordinate, which decides nearly always, next to the index: no jump through memory.
struct Keyed {
  double x;
  std::int32_t index;
};

}  // namespace

std::vector<std::int32_t> lexicographic_order(const double* points, std::size_t count) {
  std::vector<Keyed> keyed(count);
  for (std::size_t i = 0; i < count; ++i) keyed[i] = {points[3 * i], std::int32_t(i)};
  std::sort(keyed.begin(), keyed.end(), [points](const Keyed& a, const Keyed& b) {
    if (a.x != b.x) return a.x < b.x;
    const double *p = points + 3 * std::size_t(a.index), *q = points + 3 * std::size_t(b.index);
    if (p[1] != q[1]) return p[1] < q[1];
    if (p[2] != q[2]) return p[2] < q[2];
    return a.index < b.index;
  });
  std::vector<std::int32_t> order;
  order.reserve(count);
  for (const Keyed& entry : keyed) {
    const double* p = points + 3 * std::size_t(entry.index);
    const double* last = order.empty() ? nullptr : points + 3 * std::size_t(order.back());
    if (last == nullptr || !std::equal(p, p + 3, last)) order.push_back(entry.index);
  }
  return order;
}

}  // namespace symrecon
