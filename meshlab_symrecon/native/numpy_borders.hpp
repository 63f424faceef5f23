// numpy arrays looked at in place, results handed over without copying, and work without the interpreter's lock.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <array>
#include <cstdint>
#include <stdexcept>
#include <utility>
#include <vector>

#include "border_checks.hpp"
#include "progress.hpp"
#include "view.hpp"

namespace symrecon {

namespace nb = nanobind;

template <typename T>
using Row = nb::ndarray<const T, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
template <typename T, Py_ssize_t Width>
using Rows = nb::ndarray<const T, nb::shape<-1, Width>, nb::c_contig, nb::device::cpu>;

template <typename T>
View<T> view(const Row<T>& array) {
  return {array.data(), array.shape(0)};
}

template <typename T, Py_ssize_t Width>
View<std::array<T, Width>> view(const Rows<T, Width>& array) {
  return {reinterpret_cast<const std::array<T, Width>*>(array.data()), array.shape(0)};
}

template <typename T>
nb::ndarray<nb::numpy, T> give(std::vector<T>&& values) {
  auto* owner = new std::vector<T>(std::move(values));
  nb::capsule release(owner, [](void* p) noexcept { delete static_cast<std::vector<T>*>(p); });
  return nb::ndarray<nb::numpy, T>(owner->data(), {owner->size()}, release);
}

template <typename T, typename Item>
nb::ndarray<nb::numpy, T> give_rows(std::vector<Item>&& values) {
  auto* owner = new std::vector<Item>(std::move(values));
  nb::capsule release(owner, [](void* p) noexcept { delete static_cast<std::vector<Item>*>(p); });
  return nb::ndarray<nb::numpy, T>(owner->data(), {owner->size(), sizeof(Item) / sizeof(T)}, release);
}

template <typename Work>
auto without_gil(Work&& work) {
  nb::gil_scoped_release release;
  return work();
}

// Lets signals through, Ctrl-C among them.
inline void stop_on_interrupt() {
  nb::gil_scoped_acquire hold;
  if (PyErr_CheckSignals() != 0) throw nb::python_error();
}

// Lets signals through, and tells a Python callable, if there is one, the share done.
inline Progress reporter(const nb::object& progress) {
  return [&progress](double fraction) {
    nb::gil_scoped_acquire hold;
    if (PyErr_CheckSignals() != 0) throw nb::python_error();
    if (!progress.is_none()) progress(fraction);
  };
}

}  // namespace symrecon
