// Python bindings of the compiled kernel: numpy arrays in, numpy arrays out, the GIL released in between.
#include <nanobind/nanobind.h>

NB_MODULE(_native, module) {
  module.doc() = "Compiled kernel of meshlab_symrecon.";
}
