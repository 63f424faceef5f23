// Hints to the operating system about large arrays; without effect where there is no such call.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace symrecon {

#if defined(__linux__)
// For the whole pages in a range of memory.
inline void advise(const void* memory, std::size_t bytes, std::size_t page, int advice) {
  const std::uintptr_t begin = (reinterpret_cast<std::uintptr_t>(memory) + page - 1) / page * page;
  const std::uintptr_t end = (reinterpret_cast<std::uintptr_t>(memory) + bytes) / page * page;
  if (begin < end) (void)madvise(reinterpret_cast<void*>(begin), end - begin, advice);
}
#endif

// Ask for large pages, which spare most of the address translations of a random walk through many megabytes.
inline void prefer_large_pages(const void* memory, std::size_t bytes) {
#if defined(__linux__)
  advise(memory, bytes, std::size_t(1) << 21, MADV_HUGEPAGE);
#else
  (void)memory, (void)bytes;
#endif
}

// Give the memory back before its owner does; what it holds is lost.
inline void abandon(const void* memory, std::size_t bytes) {
#if defined(__linux__)
  advise(memory, bytes, std::size_t(1) << 16, MADV_DONTNEED);
#else
  (void)memory, (void)bytes;
#endif
}

// Memory in large pages for arrays of megabytes: fewer faults while it fills, fewer address translations after.
template <class Item>
struct LargePages {
  using value_type = Item;

  LargePages() = default;
  template <class Other>
  LargePages(const LargePages<Other>&) {}  // NOLINT: allocators convert

  Item* allocate(std::size_t count) {
    Item* const memory = std::allocator<Item>().allocate(count);
    if (count * sizeof(Item) >= (std::size_t(1) << 22)) prefer_large_pages(memory, count * sizeof(Item));
    return memory;
  }
  void deallocate(Item* memory, std::size_t count) { std::allocator<Item>().deallocate(memory, count); }

  friend bool operator==(const LargePages&, const LargePages&) { return true; }
  friend bool operator!=(const LargePages&, const LargePages&) { return false; }
};

template <class Item>
using LargeVector = std::vector<Item, LargePages<Item>>;

}  // namespace symrecon
