// numpy borders of what keeps noise and outliers out.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <cstring>
#include <stdexcept>

#include "bindings.hpp"
#include "handles.hpp"
#include "linked_pieces.hpp"

namespace nb = nanobind;

namespace symrecon {
namespace {

template <typename T>
using Row = nb::ndarray<const T, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Cells = nb::ndarray<const std::int32_t, nb::shape<-1, 4>, nb::c_contig, nb::device::cpu>;

template <typename T>
std::vector<T> row(const Row<T>& array) {
  return std::vector<T>(array.data(), array.data() + array.shape(0));
}

nb::ndarray<nb::numpy, std::uint8_t> grow(const Cells& cells, const Row<std::uint8_t>& wanted,
                                          const Row<std::uint8_t>& certain, const Row<double>& size) {
  const std::size_t sites = wanted.shape(0);
  if (certain.shape(0) != sites || size.shape(0) != sites) throw std::invalid_argument("one entry a site is needed");
  for (std::size_t i = 0; i < 4 * cells.shape(0); ++i)
    if (cells.data()[i] < 0 || std::size_t(cells.data()[i]) >= sites) throw std::out_of_range("cell of unknown sites");
  auto* grown = new std::vector<std::uint8_t>();
  nb::capsule owner(grown, [](void* p) noexcept { delete static_cast<std::vector<std::uint8_t>*>(p); });
  {
    const View<Quad> quads{reinterpret_cast<const Quad*>(cells.data()), cells.shape(0)};
    const View<std::uint8_t> wish{wanted.data(), sites}, sure{certain.data(), sites};
    const View<double> sizes{size.data(), sites};
    nb::gil_scoped_release release;
    *grown = grow_without_loops(quads, wish, sure, sizes, [] {
      nb::gil_scoped_acquire hold;
      if (PyErr_CheckSignals() != 0) throw nb::python_error();
    });
  }
  return nb::ndarray<nb::numpy, std::uint8_t>(grown->data(), {grown->size()}, owner);
}

using Points = nb::ndarray<const double, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;

nb::ndarray<nb::numpy, std::int32_t> pieces(const Points& sites, const Cells& cells, const Row<double>& room,
                                            const Row<std::uint8_t>& loose, double reach) {
  if (room.shape(0) > sites.shape(0) || loose.shape(0) != room.shape(0))
    throw std::invalid_argument("one room and one mark a sample are needed");
  for (std::size_t i = 0; i < 4 * cells.shape(0); ++i)
    if (cells.data()[i] < 0 || std::size_t(cells.data()[i]) >= sites.shape(0))
      throw std::out_of_range("cell of unknown sites");
  auto* found = new std::vector<std::int32_t>();
  nb::capsule owner(found, [](void* p) noexcept { delete static_cast<std::vector<std::int32_t>*>(p); });
  {
    std::vector<Quad> quads(cells.shape(0));
    std::memcpy(quads.data(), cells.data(), quads.size() * sizeof(Quad));
    std::vector<Position> positions(sites.shape(0));
    std::memcpy(positions.data(), sites.data(), positions.size() * sizeof(Position));
    nb::gil_scoped_release release;
    *found = linked_pieces(positions, quads, row(room), row(loose), reach);
  }
  return nb::ndarray<nb::numpy, std::int32_t>(found->data(), {found->size()}, owner);
}

}  // namespace

void bind_noise(nb::module_& module) {
  module.def("grow_without_loops", &grow, nb::arg("cells"), nb::arg("wanted"), nb::arg("certain"), nb::arg("size"),
             "The part of `wanted` that grows from `certain` without closing loops through uncertain sites.");
  module.def("linked_pieces", &pieces, nb::arg("sites"), nb::arg("cells"), nb::arg("room"), nb::arg("loose"),
             nb::arg("reach"), "The piece of each sample, linked by edges short beside the spacing at both ends.");
}

}  // namespace symrecon
