// numpy borders of the crust's loops.
#include <limits>

#include "bindings.hpp"
#include "crust.hpp"
#include "far_faces.hpp"
#include "near_points.hpp"
#include "numpy_borders.hpp"
#include "surface_topology.hpp"

namespace symrecon {
namespace {

using Cells = Rows<std::int32_t, 4>;
using Places = Rows<double, 3>;
using Numbers = Row<std::int32_t>;

nb::tuple give_surface(SampledSurface&& surface) {
  return nb::make_tuple(give_rows<double>(std::move(surface.points)),
                        give_rows<std::int32_t>(std::move(surface.faces)), give(std::move(surface.nearest)));
}

void require_sampled(const Places& points, const Rows<std::int32_t, 3>& faces, const Numbers& nearest,
                     const Places& samples, const Row<double>& spacing) {
  require(nearest.shape(0) == points.shape(0), "one nearest sample a vertex is needed");
  require(spacing.shape(0) == samples.shape(0), "one spacing a sample is needed");
  require_known(view(faces), points.shape(0), "faces of unknown vertices");
  require_known(view(nearest), samples.shape(0), "vertices at unknown samples");
}

nb::tuple polygons_of(Cells cells, Cells neighbours, Row<std::uint8_t> inside, const nb::object& progress) {
  const Progress report = reporter(progress);
  Polygons polygons = without_gil([&] {
    require_cells(view(cells), inside.shape(0));
    require_neighbours(view(neighbours), view(cells));
    require_marks(view(inside), "a site is inside (1) or not (0)");
    return mixed_edge_polygons(view(cells), view(neighbours), view(inside), report);
  });
  return nb::make_tuple(give(std::move(polygons.cells)), give(std::move(polygons.offsets)),
                        give(std::move(polygons.corners)));
}

nb::tuple vertices_of(Places centres, Row<double> radii, Cells samples, Places sites, std::int32_t sample_count,
                      Cells cells, Numbers chosen, double reach, const nb::object& progress) {
  const Progress report = reporter(progress);
  const PolarBalls balls{view(centres), view(radii), view(samples), view(sites), sample_count};
  PowerVertices vertices = without_gil([&] {
    require(radii.shape(0) == centres.shape(0) && samples.shape(0) == centres.shape(0),
            "one radius and four samples a ball are needed");
    require(sample_count >= 0 && std::size_t(sample_count) <= sites.shape(0), "samples must be among the sites");
    require_finite(view(centres), "centres must be finite");
    for (const double radius : view(radii)) require(std::isfinite(radius * radius), "radii must have finite squares");
    require_known(view(samples), sites.shape(0), "balls at unknown sites");
    require_known(view(cells), centres.shape(0), "cell of unknown balls");
    require_known(view(chosen), cells.shape(0), "unknown cells are chosen");
    return power_vertices(balls, view(cells), view(chosen), reach, report);
  });
  return nb::make_tuple(give_rows<double>(std::move(vertices.positions)), give(std::move(vertices.nearest)));
}

nb::tuple joined_of(Places positions, Numbers nearest, Numbers offsets, Numbers corners, Places samples,
                    const nb::object& progress) {
  const Progress report = reporter(progress);
  return give_surface(without_gil([&] {
    require(nearest.shape(0) == positions.shape(0), "one nearest sample a corner is needed");
    require_known(view(nearest), samples.shape(0), "corners at unknown samples");
    require_known(view(corners), positions.shape(0), "polygons with unknown corners");
    require_rows(view(offsets), corners.shape(0));
    for (std::size_t k = 0; k + 1 < offsets.shape(0); ++k)
      require(view(offsets)[k + 1] - view(offsets)[k] > 2, "a polygon needs three corners");
    return join_at_samples(view(positions), view(nearest), view(offsets), view(corners), view(samples), report);
  }));
}

nb::tuple contracted_of(Places points, Rows<std::int32_t, 3> faces, Numbers nearest, Places samples,
                        Row<double> spacing, double weld, double flat, const nb::object& progress) {
  const Progress report = reporter(progress);
  return give_surface(without_gil([&] {
    require_sampled(points, faces, nearest, samples, spacing);
    require_finite(view(points), "points must be finite");
    return contract_edges(view(points), view(faces), view(nearest), {view(samples), view(spacing)}, {weld, flat},
                          report);
  }));
}

nb::ndarray<nb::numpy, std::int32_t> keepers_of(Places points, Row<double> reach, Numbers order, double widest) {
  return give(without_gil([&] {
    require(reach.shape(0) == points.shape(0), "one reach a point is needed");
    require_finite(view(points), "points must be finite");
    require_known(view(order), points.shape(0), "an order of unknown points");
    return nearest_kept(view(points), view(reach), view(order), widest);
  }));
}

nb::ndarray<nb::numpy, std::int32_t> far_faces_of(Places points, Rows<std::int32_t, 3> faces, Numbers nearest,
                                                  Places samples, Row<double> spacing, double multiple) {
  return give(without_gil([&] {
    require_sampled(points, faces, nearest, samples, spacing);
    return far_faces(view(points), view(faces), view(nearest), view(samples), view(spacing), multiple);
  }));
}

nb::tuple topology_of(Rows<std::int32_t, 3> faces, std::int32_t vertex_count) {
  SurfaceTopology found = without_gil([&] {
    require(vertex_count >= 0 && vertex_count < std::numeric_limits<std::int32_t>::max(),
            "the number of vertices must be at least 0 and fit 32 bits");
    require(faces.shape(0) < (std::size_t(1) << 31) / 3, "there are more sides than 32-bit indices can number");
    require_known(view(faces), std::size_t(vertex_count), "faces of unknown vertices");
    return surface_topology(view(faces), vertex_count);
  });
  return nb::make_tuple(found.vertices, found.edges, found.boundary, found.crowded, found.misoriented, found.fans,
                        found.components, give(std::move(found.piece)));
}

}  // namespace

void bind_crust(nb::module_& module) {
  module.def("mixed_edge_polygons", &polygons_of, nb::arg("cells"), nb::arg("neighbours"), nb::arg("inside"),
             nb::arg("progress") = nb::none(),
             "Polygons dual to the edges between inside and outside sites: cells, offsets, corners.");
  module.def("power_vertices", &vertices_of, nb::arg("centres"), nb::arg("radii"), nb::arg("samples"),
             nb::arg("sites"), nb::arg("sample_count"), nb::arg("cells"), nb::arg("chosen"), nb::arg("reach"),
             nb::arg("progress") = nb::none(),
             "Positions, nearest samples of the power vertices of chosen cells.");
  module.def("join_at_samples", &joined_of, nb::arg("positions"), nb::arg("nearest"), nb::arg("offsets"),
             nb::arg("corners"), nb::arg("samples"), nb::arg("progress") = nb::none(),
             "Triangulate polygons and join what lies at a sample: points, faces, nearest samples.");
  module.def("contract_edges", &contracted_of, nb::arg("points"), nb::arg("faces"), nb::arg("nearest"),
             nb::arg("samples"), nb::arg("spacing"), nb::arg("weld"), nb::arg("flat"),
             nb::arg("progress") = nb::none(),
             "Contract edges of a closed manifold where the link condition holds: points, faces, nearest.");
  module.def("nearest_kept", &keepers_of, nb::arg("points"), nb::arg("reach"), nb::arg("order"), nb::arg("widest"),
             "For each point the nearest one kept within its reach; points are kept in the given order.");
  module.def("far_faces", &far_faces_of, nb::arg("points"), nb::arg("faces"), nb::arg("nearest"), nb::arg("samples"),
             nb::arg("spacing"), nb::arg("multiple"),
             "Faces with a place farther from the samples near their corners than the spacing explains.");
  module.def("surface_topology", &topology_of, nb::arg("faces"), nb::arg("vertex_count"),
             "Counts of vertices, edges, boundary, crowded and misoriented edges, fans, components; and "
             "the component of each face.");
}

}  // namespace symrecon
