// numpy arrays to vectors of small arrays or to views of them, and back without copying.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <cstring>
#include <stdexcept>
#include <utility>
#include <vector>

#include "view.hpp"

namespace symrecon {

namespace nb = nanobind;

template <typename T>
using Rows = nb::ndarray<const T, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
template <typename T>
using Row = nb::ndarray<const T, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

template <typename Item, typename T>
std::vector<Item> rows(const Rows<T>& array) {
  if (array.shape(1) * sizeof(T) != sizeof(Item)) throw std::invalid_argument("wrong row width");
  std::vector<Item> items(array.shape(0));
  std::memcpy(items.data(), array.data(), items.size() * sizeof(Item));
  return items;
}

template <typename T>
std::vector<T> row(const Row<T>& array) {
  return std::vector<T>(array.data(), array.data() + array.shape(0));
}

template <typename Item, typename T>
View<Item> view_rows(const Rows<T>& array) {
  if (array.shape(1) * sizeof(T) != sizeof(Item)) throw std::invalid_argument("wrong row width");
  return {reinterpret_cast<const Item*>(array.data()), array.shape(0)};
}

template <typename T>
View<T> view_row(const Row<T>& array) {
  return {array.data(), array.shape(0)};
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

}  // namespace symrecon
