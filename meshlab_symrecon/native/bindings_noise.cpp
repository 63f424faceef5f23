// numpy borders of what keeps noise and outliers out.
#include "bindings.hpp"
#include "handles.hpp"
#include "linked_pieces.hpp"
#include "numpy_borders.hpp"

namespace symrecon {
namespace {

nb::ndarray<nb::numpy, std::uint8_t> grown_of(Rows<std::int32_t, 4> cells, Row<std::uint8_t> wanted,
                                              Row<std::uint8_t> certain, Row<double> size) {
  const std::size_t sites = wanted.shape(0);
  require(certain.shape(0) == sites && size.shape(0) == sites, "one entry a site is needed");
  return give(without_gil([&] {
    require_cells(view(cells), sites);
    require_marks(view(wanted), "a site is wanted (1) or not (0)");
    require_marks(view(certain), "a site is certain (1) or not (0)");
    return grow_without_loops(view(cells), view(wanted), view(certain), view(size), stop_on_interrupt);
  }));
}

nb::ndarray<nb::numpy, std::int32_t> pieces_of(Rows<double, 3> sites, Rows<std::int32_t, 4> cells, Row<double> room,
                                               Row<std::uint8_t> loose, double reach) {
  require(room.shape(0) <= sites.shape(0) && loose.shape(0) == room.shape(0),
          "one room and one mark a sample are needed");
  return give(without_gil([&] {
    require_cells(view(cells), sites.shape(0));
    return linked_pieces(view(sites), view(cells), view(room), view(loose), reach);
  }));
}

}  // namespace

void bind_noise(nb::module_& module) {
  module.def("grow_without_loops", &grown_of, nb::arg("cells"), nb::arg("wanted"), nb::arg("certain"), nb::arg("size"),
             "The part of `wanted` that grows from `certain` without closing loops through uncertain sites.");
  module.def("linked_pieces", &pieces_of, nb::arg("sites"), nb::arg("cells"), nb::arg("room"), nb::arg("loose"),
             nb::arg("reach"), "The piece of each sample, linked by edges short beside the spacing at both ends.");
}

}  // namespace symrecon
