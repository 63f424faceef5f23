// numpy borders of the surface through the samples, and of the medial axis.
#include "bindings.hpp"
#include "interpolating.hpp"
#include "numpy_borders.hpp"
#include "power_shape.hpp"

namespace nb = nanobind;

namespace symrecon {
void bind_surfaces(nb::module_& module) {
  module.def(
      "label_cells",
      [](Rows<double> sites, Rows<std::int32_t> cells, Rows<std::int32_t> neighbours,
         std::int32_t samples, Rows<double> centres, Row<double> radii,
         Rows<std::int32_t> on_balls, Row<std::uint8_t> sides, Rows<std::int32_t> of_sample) {
        std::vector<std::uint8_t> found;
        {
          nb::gil_scoped_release release;
          found = label_cells(view_rows<Position>(sites), view_rows<Quad>(cells),
                              view_rows<Quad>(neighbours), samples,
                              {view_rows<Position>(centres), view_row(radii), view_rows<Quad>(on_balls),
                               view_row(sides), view_rows<PolePair>(of_sample)});
        }
        return give(std::move(found));
      },
      nb::arg("sites"), nb::arg("cells"), nb::arg("neighbours"), nb::arg("samples"),
      nb::arg("centres"), nb::arg("radii"), nb::arg("on_balls"), nb::arg("sides"), nb::arg("of_sample"),
      "The side (0 outer, 1 inner) of each cell, from its pole or the polar balls of its samples.");
  module.def(
      "settle_sides",
      [](Rows<double> sites, Rows<std::int32_t> cells, Rows<std::int32_t> neighbours,
         std::int32_t samples, Row<std::uint8_t> sides, std::int64_t smallest) {
        std::vector<std::uint8_t> settled;
        {
          nb::gil_scoped_release release;
          settled = settle_sides(view_rows<Position>(sites), view_rows<Quad>(cells),
                                 view_rows<Quad>(neighbours), samples, view_row(sides), smallest);
        }
        return give(std::move(settled));
      },
      nb::arg("sites"), nb::arg("cells"), nb::arg("neighbours"), nb::arg("samples"), nb::arg("sides"),
      nb::arg("smallest"), "Sides of cells whose boundary is a smooth manifold.");
  module.def(
      "power_shape",
      [](Rows<std::int32_t> cells, Rows<std::int32_t> neighbours, Row<std::uint8_t> part,
         Rows<double> centres, Row<double> radii, double redundancy) {
        PowerShape shape;
        {
          nb::gil_scoped_release release;
          shape = power_shape(view_rows<Quad>(cells), view_rows<Quad>(neighbours), view_row(part),
                              view_rows<Position>(centres), view_row(radii), redundancy);
        }
        return nb::make_tuple(give(std::move(shape.absorber)),
                              give_rows<std::int32_t>(std::move(shape.edges)),
                              give_rows<std::int32_t>(std::move(shape.faces)));
      },
      nb::arg("cells"), nb::arg("neighbours"), nb::arg("part"), nb::arg("centres"), nb::arg("radii"),
      nb::arg("redundancy"), "Absorber of each pole, edges and triangles between poles of one part.");
}

}  // namespace symrecon
