// numpy borders of the crust's loops.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <cstring>

#include "bindings.hpp"
#include "crust.hpp"
#include "poles.hpp"
#include "surface_topology.hpp"

namespace nb = nanobind;

namespace symrecon {
namespace {

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

}  // namespace

void bind_crust(nb::module_& module) {
  module.def(
      "mixed_edge_polygons",
      [](Rows<std::int32_t> cells, Rows<std::int32_t> neighbours, Row<std::uint8_t> inside) {
        Polygons polygons;
        {
          nb::gil_scoped_release release;
          polygons = mixed_edge_polygons(rows<Quad>(cells), rows<Quad>(neighbours), row(inside));
        }
        return nb::make_tuple(give(std::move(polygons.offsets)), give(std::move(polygons.corners)),
                              give(std::move(polygons.inner)), give(std::move(polygons.outer)));
      },
      nb::arg("cells"), nb::arg("neighbours"), nb::arg("inside"),
      "Polygons dual to the edges between inside and outside sites: offsets, corners, inner, outer.");
  module.def(
      "contract_edges",
      [](Rows<double> points, Rows<std::int32_t> faces, Row<std::int32_t> anchor,
         Rows<double> anchor_points, Row<double> shortest) {
        Contraction result;
        {
          nb::gil_scoped_release release;
          result = contract_edges(rows<Position>(points), rows<Triangle>(faces), row(anchor),
                                  rows<Position>(anchor_points), row(shortest));
        }
        return nb::make_tuple(give_rows<double>(std::move(result.points)),
                              give_rows<std::int32_t>(std::move(result.faces)));
      },
      nb::arg("points"), nb::arg("faces"), nb::arg("anchor"), nb::arg("anchor_points"),
      nb::arg("shortest"), "Contract edges of a closed manifold where the link condition holds.");
  module.def(
      "label_pieces",
      [](Rows<std::int32_t> cells, Row<std::uint8_t> labels) {
        std::vector<std::int32_t> pieces;
        {
          nb::gil_scoped_release release;
          pieces = label_pieces(rows<Quad>(cells), row(labels));
        }
        return give(std::move(pieces));
      },
      nb::arg("cells"), nb::arg("labels"),
      "The piece of each site, connected by edges between sites of equal label.");
  module.def(
      "surface_topology",
      [](Rows<std::int32_t> faces, std::int32_t vertex_count) {
        SurfaceTopology found;
        {
          nb::gil_scoped_release release;
          found = surface_topology(rows<Triangle>(faces), vertex_count);
        }
        return nb::make_tuple(found.vertices, found.edges, found.boundary, found.crowded,
                              found.misoriented, found.fans, found.components,
                              give(std::move(found.piece)));
      },
      nb::arg("faces"), nb::arg("vertex_count"),
      "Counts of vertices, edges, boundary, crowded and misoriented edges, fans, components; and "
      "the component of each face.");
}

}  // namespace symrecon
