// numpy borders of the crust's loops.
#include "bindings.hpp"
#include "crust.hpp"
#include "far_faces.hpp"
#include "near_points.hpp"
#include "numpy_borders.hpp"
#include "poles.hpp"
#include "surface_topology.hpp"

namespace nb = nanobind;

namespace symrecon {
namespace {

nb::tuple give_surface(SampledSurface&& surface) {
  return nb::make_tuple(give_rows<double>(std::move(surface.points)),
                        give_rows<std::int32_t>(std::move(surface.faces)), give(std::move(surface.nearest)));
}

// Lets signals through, Ctrl-C among them, and tells the callback.
Progress reporter(const nb::object& progress) {
  return [&progress](double fraction) {
    nb::gil_scoped_acquire hold;
    if (PyErr_CheckSignals() != 0) throw nb::python_error();
    if (!progress.is_none()) progress(fraction);
  };
}

}  // namespace

void bind_crust(nb::module_& module) {
  module.def(
      "mixed_edge_polygons",
      [](Rows<std::int32_t> cells, Rows<std::int32_t> neighbours, Row<std::uint8_t> inside,
         const nb::object& progress) {
        const Progress report = reporter(progress);
        Polygons polygons;
        {
          nb::gil_scoped_release release;
          polygons = mixed_edge_polygons(view_rows<Quad>(cells), view_rows<Quad>(neighbours), view_row(inside), report);
        }
        return nb::make_tuple(give(std::move(polygons.cells)), give(std::move(polygons.offsets)),
                              give(std::move(polygons.corners)));
      },
      nb::arg("cells"), nb::arg("neighbours"), nb::arg("inside"), nb::arg("progress") = nb::none(),
      "Polygons dual to the edges between inside and outside sites: cells, offsets, corners.");
  module.def(
      "power_vertices",
      [](Rows<double> centres, Row<double> radii, Rows<std::int32_t> samples, Rows<double> sites,
         std::int32_t sample_count, Rows<std::int32_t> cells, Row<std::int32_t> chosen, double reach,
         const nb::object& progress) {
        const Progress report = reporter(progress);
        const PolarBalls balls{view_rows<Position>(centres), view_row(radii), view_rows<Quad>(samples),
                               view_rows<Position>(sites), sample_count};
        PowerVertices vertices;
        {
          nb::gil_scoped_release release;
          vertices = power_vertices(balls, view_rows<Quad>(cells), view_row(chosen), reach, report);
        }
        return nb::make_tuple(give_rows<double>(std::move(vertices.positions)),
                              give(std::move(vertices.nearest)), vertices.replaced);
      },
      nb::arg("centres"), nb::arg("radii"), nb::arg("samples"), nb::arg("sites"), nb::arg("sample_count"),
      nb::arg("cells"), nb::arg("chosen"), nb::arg("reach"), nb::arg("progress") = nb::none(),
      "Positions, nearest samples of the power vertices of chosen cells; how many were replaced.");
  module.def(
      "join_at_samples",
      [](Rows<double> positions, Row<std::int32_t> nearest, Row<std::int32_t> offsets,
         Row<std::int32_t> corners, Rows<double> samples, const nb::object& progress) {
        const Progress report = reporter(progress);
        SampledSurface surface;
        {
          nb::gil_scoped_release release;
          surface = join_at_samples(view_rows<Position>(positions), view_row(nearest), view_row(offsets), view_row(corners),
                                    view_rows<Position>(samples), report);
        }
        return give_surface(std::move(surface));
      },
      nb::arg("positions"), nb::arg("nearest"), nb::arg("offsets"), nb::arg("corners"),
      nb::arg("samples"), nb::arg("progress") = nb::none(),
      "Triangulate polygons and join what lies at a sample: points, faces, nearest samples.");
  module.def(
      "contract_edges",
      [](Rows<double> points, Rows<std::int32_t> faces, Row<std::int32_t> nearest, Rows<double> samples,
         Row<double> spacing, double weld, double flat, const nb::object& progress) {
        const Progress report = reporter(progress);
        SampledSurface surface;
        {
          nb::gil_scoped_release release;
          surface = contract_edges(view_rows<Position>(points), view_rows<Triangle>(faces), view_row(nearest),
                                   {view_rows<Position>(samples), view_row(spacing)}, {weld, flat}, report);
        }
        return give_surface(std::move(surface));
      },
      nb::arg("points"), nb::arg("faces"), nb::arg("nearest"), nb::arg("samples"), nb::arg("spacing"),
      nb::arg("weld"), nb::arg("flat"), nb::arg("progress") = nb::none(),
      "Contract edges of a closed manifold where the link condition holds: points, faces, nearest.");
  module.def(
      "nearest_kept",
      [](Rows<double> points, Row<double> reach, Row<std::int32_t> order, double widest) {
        std::vector<std::int32_t> keeper;
        {
          nb::gil_scoped_release release;
          keeper = nearest_kept(view_rows<Position>(points), view_row(reach), view_row(order), widest);
        }
        return give(std::move(keeper));
      },
      nb::arg("points"), nb::arg("reach"), nb::arg("order"), nb::arg("widest"),
      "For each point the nearest one kept within its reach; points are kept in the given order.");
  module.def(
      "far_faces",
      [](Rows<double> points, Rows<std::int32_t> faces, Row<std::int32_t> nearest, Rows<double> samples,
         Row<double> spacing, double multiple) {
        std::vector<std::int32_t> far;
        {
          nb::gil_scoped_release release;
          far = far_faces(view_rows<Position>(points), view_rows<Triangle>(faces), view_row(nearest),
                          view_rows<Position>(samples), view_row(spacing), multiple);
        }
        return give(std::move(far));
      },
      nb::arg("points"), nb::arg("faces"), nb::arg("nearest"), nb::arg("samples"), nb::arg("spacing"),
      nb::arg("multiple"), "Faces with a place farther from the samples near their corners than the spacing explains.");
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
