// A hint that an address will be read soon.
#pragma once

namespace symrecon {

inline void prefetch(const void* address) {
#if defined(__GNUC__) || defined(__clang__)
  __builtin_prefetch(address);
#else
  (void)address;
#endif
}

}  // namespace symrecon
