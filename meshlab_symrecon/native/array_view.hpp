// A read-only look at an array that somebody else owns.
#pragma once

#include <cstddef>

namespace symrecon {

template <typename T>
class View {
 public:
  View() = default;
  View(const T* start, std::size_t size) : start_(start), size_(size) {}
  template <typename Array>
  View(const Array& array) : start_(array.data()), size_(array.size()) {}

  const T& operator[](std::size_t i) const { return start_[i]; }
  const T* begin() const { return start_; }
  const T* end() const { return start_ + size_; }
  std::size_t size() const { return size_; }

 private:
  const T* start_ = nullptr;
  std::size_t size_ = 0;
};

}  // namespace symrecon
