// What the C library does with large arrays that are freed: it gives them back to the system, or keeps them.
#include <nanobind/nanobind.h>

#if defined(__GLIBC__)
#include <malloc.h>
#endif

#include "bindings.hpp"

namespace symrecon {
namespace {

// Arrays up to this size come from memory that was freed before, if there is any. Fresh memory costs a fault
// and the clearing of each page: a fifth of the time of a million samples. Larger ones are mapped each for itself.
constexpr int kKept = 256 << 20;
constexpr int kUsual = 32 << 20;  // what the library itself comes to once arrays of that size were freed

void keep_freed_memory(bool keep) {
#if defined(__GLIBC__)
  mallopt(M_MMAP_THRESHOLD, keep ? kKept : kUsual);
  mallopt(M_TRIM_THRESHOLD, keep ? kKept : 2 * kUsual);
  if (!keep) malloc_trim(0);
#else
  (void)keep;
#endif
}

}  // namespace

void bind_memory(nanobind::module_& module) {
  module.def("keep_freed_memory", &keep_freed_memory, nanobind::arg("keep"));
}

}  // namespace symrecon
