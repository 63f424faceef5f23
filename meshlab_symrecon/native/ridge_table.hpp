// Finds, for every ridge (edge) of a cavity's boundary, the new cell on its other side.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace symrecon {

// The boundary is an oriented closed surface, so each ridge is used once in either direction: the cell that has u -> v
// finds its neighbour under v -> u. Vertices are numbered within the boundary.

// A square of entries; no search and no branch, for the boundaries of up to `widest` vertices that are nearly all.
class SmallRidgeTable {
 public:
  static constexpr std::size_t widest = 128;

  std::int32_t& at(std::int32_t u, std::int32_t v) { return entries_[std::size_t(u) * widest + std::size_t(v)]; }

 private:
  std::vector<std::int32_t> entries_ = std::vector<std::int32_t>(widest * widest, 0);
};

// Open addressing, for any number of ridges.
class LargeRidgeTable {
 public:
  void prepare(std::size_t ridges) {
    std::size_t size = 64;
    shift_ = 58;
    while (size < 4 * ridges) {
      size *= 2;
      --shift_;
    }
    if (entries_.size() < size) entries_.resize(size);
    mask_ = size - 1;
    ++round_;
  }

  std::int32_t& at(std::int32_t u, std::int32_t v) {
    const std::uint64_t key = std::uint64_t(std::uint32_t(u)) << 32 | std::uint32_t(v);
    for (std::size_t slot = (key * 0x9e3779b97f4a7c15u) >> shift_;; slot = (slot + 1) & mask_) {
      Entry& entry = entries_[slot];
      if (entry.round != round_) entry = {key, round_, 0};
      if (entry.key == key) return entry.cell;
    }
  }

 private:
  struct Entry {
    std::uint64_t key = 0;
    std::uint32_t round = 0;
    std::int32_t cell = 0;
  };

  std::vector<Entry> entries_;
  std::size_t mask_ = 0;
  int shift_ = 58;
  std::uint32_t round_ = 0;
};

}  // namespace symrecon
