// A list that grows by conditional appends without a branch: the item is always written, and counted only if wanted.
#pragma once

#include <cstddef>
#include <vector>

namespace symrecon {

template <class Item>
class Buffer {
 public:
  void clear() { count_ = 0; }
  std::size_t size() const { return count_; }

  // To be called before up to `more` appends.
  void make_room(std::size_t more) {
    if (count_ + more > items_.size()) items_.resize(2 * (count_ + more));
  }

  void append_if(bool wanted, const Item& item) {
    items_[count_] = item;
    count_ += wanted;
  }

  Item& operator[](std::size_t i) { return items_[i]; }
  const Item* begin() const { return items_.data(); }
  const Item* end() const { return items_.data() + count_; }

 private:
  std::vector<Item> items_;
  std::size_t count_ = 0;
};

}  // namespace symrecon
