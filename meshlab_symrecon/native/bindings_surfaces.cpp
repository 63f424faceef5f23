// numpy borders of the surface through the samples, and of the medial axis.
#include "bindings.hpp"
#include "interpolating.hpp"
#include "numpy_borders.hpp"
#include "power_shape.hpp"

namespace symrecon {
namespace {

using Cells = Rows<std::int32_t, 4>;
using Sides = nb::ndarray<nb::numpy, std::uint8_t>;

void require_samples(std::int32_t samples, std::size_t sites) {
  require(samples >= 0 && std::size_t(samples) <= sites, "samples must be among the sites");
}

// The steps go all the way round every sample.
void require_inner_samples(View<Quad> cells, View<Quad> neighbours, std::int32_t samples) {
  for (std::size_t cell = 0; cell < cells.size(); ++cell)
    for (int k = 0; k < 4; ++k)
      if (neighbours[cell][k] < 0)
        for (int corner = 0; corner < 4; ++corner)
          require(corner == k || cells[cell][corner] >= samples, "a sample lies on the hull");
}

Sides labels_of_cells(Rows<double, 3> sites, Cells cells, Cells neighbours, std::int32_t samples,
                      Rows<double, 3> centres, Row<double> radii, Cells on_balls, Row<std::uint8_t> sides,
                      Rows<std::int32_t, 2> of_sample) {
  return give(without_gil([&] {
    require_samples(samples, sites.shape(0));
    require_cells(view(cells), sites.shape(0));
    require_neighbours(view(neighbours), view(cells));
    const std::size_t balls = centres.shape(0);
    require(radii.shape(0) == balls && on_balls.shape(0) == balls && sides.shape(0) == balls,
            "one radius, four samples and one side a ball are needed");
    require(of_sample.shape(0) == std::size_t(samples), "two balls a sample are needed");
    require_known_or_none(flat(view(of_sample)), balls, "samples with unknown balls");
    require_marks(view(sides), "a ball is inner (1) or outer (0)");
    return label_cells(view(sites), view(cells), view(neighbours), samples,
                       {view(centres), view(radii), view(on_balls), view(sides), view(of_sample)});
  }));
}

Sides settled_of(Rows<double, 3> sites, Cells cells, Cells neighbours, std::int32_t samples, Row<std::uint8_t> sides,
                 std::int64_t smallest) {
  return give(without_gil([&] {
    require_samples(samples, sites.shape(0));
    require_cells(view(cells), sites.shape(0));
    require_shared_facets(view(cells), view(neighbours));
    require(sides.shape(0) == cells.shape(0), "one side a cell is needed");
    require_marks(view(sides), "a cell is inner (1) or outer (0)");
    require_inner_samples(view(cells), view(neighbours), samples);
    return settle_sides(view(sites), view(cells), view(neighbours), samples, view(sides), smallest);
  }));
}

nb::tuple power_shape_of(Cells cells, Cells neighbours, Row<std::uint8_t> part, Rows<double, 3> centres,
                         Row<double> radii, double redundancy) {
  PowerShape shape = without_gil([&] {
    require(centres.shape(0) == part.shape(0) && radii.shape(0) == part.shape(0),
            "one centre and one radius a pole are needed");
    require_cells(view(cells), part.shape(0));
    require_neighbours(view(neighbours), view(cells));
    return power_shape(view(cells), view(neighbours), view(part), view(centres), view(radii), redundancy);
  });
  return nb::make_tuple(give(std::move(shape.absorber)), give_rows<std::int32_t>(std::move(shape.edges)),
                        give_rows<std::int32_t>(std::move(shape.faces)));
}

}  // namespace

void bind_surfaces(nb::module_& module) {
  module.def("label_cells", &labels_of_cells, nb::arg("sites"), nb::arg("cells"), nb::arg("neighbours"),
             nb::arg("samples"), nb::arg("centres"), nb::arg("radii"), nb::arg("on_balls"), nb::arg("sides"),
             nb::arg("of_sample"),
             "The side (0 outer, 1 inner) of each cell, from its pole or the polar balls of its samples.");
  module.def("settle_sides", &settled_of, nb::arg("sites"), nb::arg("cells"), nb::arg("neighbours"),
             nb::arg("samples"), nb::arg("sides"), nb::arg("smallest"),
             "Sides of cells whose boundary is a smooth manifold.");
  module.def("power_shape", &power_shape_of, nb::arg("cells"), nb::arg("neighbours"), nb::arg("part"),
             nb::arg("centres"), nb::arg("radii"), nb::arg("redundancy"),
             "Absorber of each pole, edges and triangles between poles of one part.");
}

}  // namespace symrecon
