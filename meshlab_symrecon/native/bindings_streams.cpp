// Where C++'s standard streams write to: kept, and put back after other native code has failed.
#include <cstdint>
#include <cstdio>
#include <iostream>

#include <nanobind/stl/pair.h>

#include "bindings.hpp"

namespace symrecon {
namespace {

using Address = std::uintptr_t;

std::pair<Address, Address> stream_buffers() {
  return {reinterpret_cast<Address>(std::cout.rdbuf()),
          reinterpret_cast<Address>(std::cerr.rdbuf())};
}

void set_stream_buffers(Address output, Address error) {
  std::cout.rdbuf(reinterpret_cast<std::streambuf*>(output));
  std::cerr.rdbuf(reinterpret_cast<std::streambuf*>(error));
}

void flush_streams() {
  std::cout.flush();
  std::cerr.flush();
  std::fflush(nullptr);
}

}  // namespace

void bind_streams(nanobind::module_& module) {
  module.def("stream_buffers", &stream_buffers);
  module.def("flush_streams", &flush_streams);
  module.def("set_stream_buffers", &set_stream_buffers, nanobind::arg("output"),
             nanobind::arg("error"));
}

}  // namespace symrecon
