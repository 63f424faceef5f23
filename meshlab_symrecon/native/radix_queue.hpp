// A queue of numbered items, cheapest first, for costs that never fall below the last one taken
// (Ahuja, Mehlhorn, Orlin, Tarjan: Faster algorithms for the shortest path problem, 1990).
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <vector>

namespace symrecon {

class RadixQueue {
 public:
  struct Entry {
    std::uint32_t key;
    std::uint32_t item;
  };

  // The leading bits of a float that is not negative are in its own order.  Costs that agree in them,
  // to 1/1024 of their size, leave together: so the one who takes them can look ahead.
  static std::uint32_t key_of(double cost) {
    const auto rounded = static_cast<float>(cost);
    std::uint32_t key;
    std::memcpy(&key, &rounded, sizeof key);
    return key >> dropped_bits;
  }

  bool empty() const { return size_ == 0; }

  void push(std::uint32_t key, std::uint32_t item) {
    ++size_;
    buckets_[bucket_of(key)].push_back({key, item});
  }

  // Move all entries of the least key into `batch`.
  void take(std::vector<Entry>& batch) {
    batch.clear();
    if (buckets_[0].empty()) refill();
    batch.swap(buckets_[0]);
    size_ -= batch.size();
  }

 private:
  static constexpr int dropped_bits = 13;

  // Bucket b > 0 holds the keys whose highest bit that differs from the last one taken is b - 1.
  std::size_t bucket_of(std::uint32_t key) const {
    if (key == last_) return 0;
    const auto difference = static_cast<double>(key ^ last_);  // its exponent is the highest bit
    std::uint64_t bits;
    std::memcpy(&bits, &difference, sizeof bits);
    return static_cast<std::size_t>(bits >> 52) - 1022;
  }

  void refill() {
    std::size_t first = 1;
    while (buckets_[first].empty()) ++first;
    std::vector<Entry> entries;
    entries.swap(buckets_[first]);
    last_ = std::min_element(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
              return a.key < b.key;
            })->key;
    for (const Entry& entry : entries) buckets_[bucket_of(entry.key)].push_back(entry);
    entries.clear();
    buckets_[first].swap(entries);  // keeps its memory
  }

  std::array<std::vector<Entry>, 33> buckets_;
  std::uint32_t last_ = 0;
  std::size_t size_ = 0;
};

}  // namespace symrecon
