#include "spatial_order.hpp"

#include <algorithm>
#include <cstring>

namespace symrecon {

namespace {

constexpr int curve_bits = 16;       // per axis; finer differences are sorted out in a smaller box
constexpr int smallest_run = 8;      // runs of equal keys up to this length are sorted lexicographically
constexpr std::int64_t first_round = 256;
constexpr int round_ratio_bits = 2;  // every round is four times as large as the one before

struct Keyed {
  std::uint64_t key;
  std::int32_t index;
};

// Position on the 3D Hilbert curve. At every level the octant is looked up in a frame given by a permutation of the
// axes and a mirroring; Skilling's form of it works on the bits of all levels at once ("Programming the Hilbert
// curve", 2004).
std::uint64_t hilbert_key(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
  std::uint32_t axis[3] = {x, y, z};
  for (std::uint32_t bit = 1u << (curve_bits - 1); bit > 1; bit >>= 1) {
    const std::uint32_t below = bit - 1;
    for (std::uint32_t& value : axis) {
      if (value & bit) {
        axis[0] ^= below;  // mirror
      } else {
        const std::uint32_t exchange = (axis[0] ^ value) & below;
        axis[0] ^= exchange;
        value ^= exchange;
      }
    }
  }
  axis[1] ^= axis[0];
  axis[2] ^= axis[1];
  std::uint32_t gray = 0;
  for (std::uint32_t bit = 1u << (curve_bits - 1); bit > 1; bit >>= 1)
    if (axis[2] & bit) gray ^= bit - 1;
  std::uint64_t key = 0;
  for (int level = curve_bits - 1; level >= 0; --level)
    for (std::uint32_t value : axis) key = (key << 1) | (((value ^ gray) >> level) & 1u);
  return key;
}

struct Box {
  double low[3];
  double extent = 0.0;  // half of the longest side, so that it cannot overflow

  Box(const std::vector<Site>& sites, const Keyed* begin, const Keyed* end) {
    const Site& first = sites[begin->index];
    double high[3] = {first.x, first.y, first.z};
    std::copy(high, high + 3, low);
    for (const Keyed* entry = begin; entry != end; ++entry) {
      const Site& site = sites[entry->index];
      const double position[3] = {site.x, site.y, site.z};
      for (int k = 0; k < 3; ++k) {
        low[k] = std::min(low[k], position[k]);
        high[k] = std::max(high[k], position[k]);
      }
    }
    for (int k = 0; k < 3; ++k) extent = std::max(extent, 0.5 * high[k] - 0.5 * low[k]);
  }

  std::uint32_t step(double coordinate, int k) const {
    constexpr double steps = double((1u << curve_bits) - 1);
    return std::uint32_t((0.5 * coordinate - 0.5 * low[k]) / extent * steps);
  }

  std::uint64_t key(const Site& site) const { return hilbert_key(step(site.x, 0), step(site.y, 1), step(site.z, 2)); }
};

std::uint64_t bits_of(double value) {
  std::uint64_t bits;
  std::memcpy(&bits, &value, sizeof bits);
  return bits;
}

// splitmix64's finaliser, chained over the coordinates
std::uint64_t hash_of(const Site& site) {
  std::uint64_t hash = 0;
  for (double coordinate : {site.x, site.y, site.z}) {
    hash += bits_of(coordinate) + 0x9e3779b97f4a7c15u;
    hash = (hash ^ (hash >> 30)) * 0xbf58476d1ce4e5b9u;
    hash = (hash ^ (hash >> 27)) * 0x94d049bb133111ebu;
    hash ^= hash >> 31;
  }
  return hash;
}

// 0 for the first and smallest round
int round_of(const Site& site, int rounds) {
  std::uint64_t hash = hash_of(site);
  int halvings = 0;
  while (halvings < round_ratio_bits * (rounds - 1) && (hash & 1) == 0) {
    hash >>= 1;
    ++halvings;
  }
  return rounds - 1 - halvings / round_ratio_bits;
}

class Sorter {
 public:
  explicit Sorter(const std::vector<Site>& sites) : sites_(sites) {}

  void sort_by_key(Keyed* begin, Keyed* end) const {
    std::sort(begin, end, [](const Keyed& a, const Keyed& b) { return a.key < b.key; });
    for (Keyed* run = begin; run != end;) {
      Keyed* next = run + 1;
      while (next != end && next->key == run->key) ++next;
      if (next - run > 1) sort_run(run, next);
      run = next;
    }
  }

 private:
  // A run of equal keys: again along the curve, in the run's own box, which is smaller by at least one step.
  void sort_run(Keyed* begin, Keyed* end) const {
    const Box box(sites_, begin, end);
    if (end - begin <= smallest_run || !(box.extent > 0.0)) {
      sort_lexicographically(begin, end);
      return;
    }
    for (Keyed* entry = begin; entry != end; ++entry) entry->key = box.key(sites_[entry->index]);
    sort_by_key(begin, end);
  }

  void sort_lexicographically(Keyed* begin, Keyed* end) const {
    std::sort(begin, end, [this](const Keyed& i, const Keyed& j) {
      const Site &a = sites_[i.index], &b = sites_[j.index];
      if (!same_position(a, b)) return before(a, b);
      if (a.weight != b.weight) return a.weight > b.weight;
      return i.index < j.index;
    });
  }

  const std::vector<Site>& sites_;
};

}  // namespace

std::vector<std::int32_t> spatial_order(const std::vector<Site>& sites, const Progress& progress) {
  const std::int32_t count = std::int32_t(sites.size());
  std::vector<std::int32_t> order(sites.size());
  if (count == 0) return order;
  std::vector<Keyed> keyed(sites.size());
  for (std::int32_t i = 0; i < count; ++i) keyed[i] = {0, i};
  const Box box(sites, keyed.data(), keyed.data() + count);
  int rounds = 1;
  for (std::int64_t size = first_round; size < count; size <<= round_ratio_bits) ++rounds;
  for (Keyed& entry : keyed) {
    const Site& site = sites[entry.index];
    const std::uint64_t round = std::uint64_t(round_of(site, rounds));
    entry.key = round << (3 * curve_bits) | (box.extent > 0.0 ? box.key(site) : 0);
  }
  if (progress) progress(0.0);
  Sorter(sites).sort_by_key(keyed.data(), keyed.data() + count);
  if (progress) progress(0.0);
  for (std::int32_t i = 0; i < count; ++i) order[i] = keyed[i].index;
  return order;
}

std::vector<std::int32_t> curve_order(const std::vector<Site>& sites) {
  std::vector<std::int32_t> order;
  if (sites.empty()) return order;
  std::vector<Keyed> keyed(sites.size());
  for (std::size_t i = 0; i < sites.size(); ++i) keyed[i] = {0, std::int32_t(i)};
  Keyed* const end = keyed.data() + keyed.size();
  const Box box(sites, keyed.data(), end);
  if (box.extent > 0.0)
    for (Keyed& entry : keyed) entry.key = box.key(sites[entry.index]);
  Sorter(sites).sort_by_key(keyed.data(), end);
  order.reserve(sites.size());
  for (const Keyed& entry : keyed)
    if (order.empty() || !same_position(sites[order.back()], sites[entry.index])) order.push_back(entry.index);
  return order;
}

}  // namespace symrecon
