// Finds, for every ridge (edge) of a cavity's boundary, the two new cells that meet there.
#pragma once

#include <cstdint>
#include <vector>

namespace symrecon {

// Open addressing, reused for every cavity; each ridge is entered once and taken out once, so it ends up empty.
class RidgeTable {
 public:
  struct Side {
    std::int32_t cell;
    std::int32_t facet;
  };

  // Make room for the ridges of a boundary of so many facets.
  void prepare(std::size_t facets) {
    std::size_t size = 64;
    shift_ = 58;
    while (size < 4 * facets) {
      size *= 2;
      --shift_;
    }
    if (entries_.size() < size) entries_.resize(size);
    mask_ = size - 1;
    ++round_;
  }

  // The side entered before for this ridge, or nullptr after entering the given one.
  const Side* match(std::int32_t u, std::int32_t v, Side side) {
    const std::uint32_t low = std::uint32_t(u < v ? u : v), high = std::uint32_t(u < v ? v : u);
    const std::uint64_t key = std::uint64_t(low) << 32 | high;
    std::size_t slot = (key * 0x9e3779b97f4a7c15u) >> shift_;
    for (;; slot = (slot + 1) & mask_) {
      Entry& entry = entries_[slot];
      if (entry.round != round_) {
        entry = {key, round_, side};
        return nullptr;
      }
      if (entry.key == key) return &entry.side;
    }
  }

 private:
  struct Entry {
    std::uint64_t key = 0;
    std::uint32_t round = 0;
    Side side = {0, 0};
  };

  std::vector<Entry> entries_;
  std::size_t mask_ = 0;
  int shift_ = 58;
  std::uint32_t round_ = 0;
};

}  // namespace symrecon
