// Disjoint sets of 0 .. n - 1, with path halving; the smaller number stands for a set.
#pragma once

#include <cstdint>
#include <numeric>
#include <vector>

namespace symrecon {

class DisjointSets {
 public:
  DisjointSets() = default;
  explicit DisjointSets(std::size_t count) { reset(count); }

  // Start again with a set for each member.
  void reset(std::size_t count) {
    parent_.resize(count);
    std::iota(parent_.begin(), parent_.end(), 0);
  }

  std::int32_t find(std::int32_t member) {
    while (parent_[member] != member) member = parent_[member] = parent_[parent_[member]];
    return member;
  }

  void join(std::int32_t a, std::int32_t b) {
    a = find(a);
    b = find(b);
    if (a < b) parent_[b] = a;
    if (b < a) parent_[a] = b;
  }

  // The set of each member, counted from 0 in the order of first members.
  std::vector<std::int32_t> numbers(std::int32_t* count = nullptr) {
    std::vector<std::int32_t> number(parent_.size(), 0);
    std::int32_t next = 0;
    for (std::size_t i = 0; i < parent_.size(); ++i) {
      const std::int32_t root = find(static_cast<std::int32_t>(i));
      number[i] = root == static_cast<std::int32_t>(i) ? next++ : number[root];
    }
    if (count != nullptr) *count = next;
    return number;
  }

 private:
  std::vector<std::int32_t> parent_;
};

}  // namespace symrecon
