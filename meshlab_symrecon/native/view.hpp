// A row of items owned by somebody else, as std::span of C++20.
#pragma once

#include <cstddef>

#include "prefetch.hpp"

namespace symrecon {

template <class Item>
class View {
 public:
  View() = default;
  View(const Item* items, std::size_t size) : items_(items), size_(size) {}
  template <class Array>
  View(const Array& items) : View(items.data(), items.size()) {}  // NOLINT: as std::span

  const Item* data() const { return items_; }
  std::size_t size() const { return size_; }
  const Item& operator[](std::size_t place) const { return items_[place]; }
  // A hint that an item will be read soon.
  void announce(std::size_t place) const { prefetch(items_ + place); }

  const Item* begin() const { return items_; }
  const Item* end() const { return items_ + size_; }

 private:
  const Item* items_ = nullptr;
  std::size_t size_ = 0;
};

}  // namespace symrecon
