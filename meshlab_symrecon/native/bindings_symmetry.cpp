// numpy borders of the search for reflection planes.
#include "bindings.hpp"
#include "even_samples.hpp"
#include "mirror_cloud.hpp"
#include "mirror_evidence.hpp"
#include "mirror_pairs.hpp"
#include "mirror_refinement.hpp"
#include "nearest_field.hpp"
#include "numpy_borders.hpp"
#include "relief.hpp"

#include <limits>

namespace symrecon {
namespace {

using Numbers = nb::ndarray<nb::numpy, std::int32_t>;
using Table = nb::ndarray<const std::int32_t, nb::ndim<3>, nb::c_contig, nb::device::cpu>;
using PlaneArray = Rows<double, 4>;

void new_field(NearestField* field, Rows<double, 3> points, Table table, Row<double> origin, double cell) {
  require(origin.shape(0) == 3, "an origin has three coordinates");
  require(cell > 0.0 && std::isfinite(cell), "cells need a positive width");
  require_finite(view(points), "points must be finite");
  require_finite(view(origin), "an origin must be finite");
  const std::array<std::size_t, 3> shape = {table.shape(0), table.shape(1), table.shape(2)};
  const Position corner = {origin.data()[0], origin.data()[1], origin.data()[2]};
  without_gil([&] { new (field) NearestField(view(points), {table.data(), table.size()}, shape, corner, cell); });
}

template <typename Find>
Numbers find_each(Rows<double, 3> places, Find&& find) {
  return give(without_gil([&] {
    std::vector<std::int32_t> found;
    found.reserve(places.shape(0));
    for (const Position& place : view(places)) found.push_back(find(place));
    return found;
  }));
}

Numbers lookup(const NearestField& field, Rows<double, 3> places) {
  return find_each(places, [&](const Position& place) { return field.lookup(place); });
}

Numbers closest(const NearestField& field, Rows<double, 3> places, double within) {
  return find_each(places, [&](const Position& place) { return field.closest(place, within); });
}

View<Plane> view_planes(const PlaneArray& planes) {
  static_assert(sizeof(Plane) == 4 * sizeof(double), "a plane is a row of four numbers");
  return {reinterpret_cast<const Plane*>(planes.data()), planes.shape(0)};
}

void require_points(std::size_t points, std::initializer_list<std::size_t> sizes) {
  for (const std::size_t size : sizes) require(size == points, "one entry a point is needed");
}

void require_queries(View<std::int32_t> queries, const NearestField& field) {
  require_known(queries, field.size(), "queries of unknown points");
}

nb::ndarray<nb::numpy, double> examine_planes(PlaneArray planes, Row<std::int32_t> queries, Row<double> distinctness,
                                              const NearestField& field, Rows<double, 3> normals,
                                              Row<std::uint8_t> oriented, Row<double> border_distance, bool exact,
                                              const EvidenceRules& rules) {
  require_points(field.size(), {normals.shape(0), oriented.shape(0), border_distance.shape(0)});
  require(distinctness.shape(0) == queries.shape(0), "one distinctness a query is needed");
  return give_rows<double>(without_gil([&] {
    require_queries(view(queries), field);
    MirrorCloud cloud{field, {}, exact};
    cloud.points.reserve(field.size());
    for (std::size_t i = 0; i < field.size(); ++i)
      cloud.points.push_back(
          {field.point(i), view(normals)[i], border_distance.data()[i], oriented.data()[i] != 0});
    return examine(view_planes(planes), cloud, view(queries), view(distinctness), rules);
  }));
}

nb::tuple landings_of(PlaneArray planes, Row<std::int32_t> queries, const NearestField& field, Rows<double, 3> normals,
                      Row<std::uint8_t> oriented, Row<double> border_distance, bool exact,
                      const EvidenceRules& rules) {
  require_points(field.size(), {normals.shape(0), oriented.shape(0), border_distance.shape(0)});
  Landings found = without_gil([&] {
    require_queries(view(queries), field);
    MirrorCloud cloud{field, {}, exact};
    for (std::size_t i = 0; i < field.size(); ++i)
      cloud.points.push_back(
          {field.point(i), view(normals)[i], border_distance.data()[i], oriented.data()[i] != 0});
    return landings(view_planes(planes), cloud, view(queries), rules);
  });
  return nb::make_tuple(give(std::move(found.partners)), give(std::move(found.weights)),
                        give(std::move(found.distances)), give(std::move(found.cosines)),
                        give(std::move(found.worth)), give(std::move(found.excused)));
}

nb::ndarray<nb::numpy, double> relief_of(Rows<double, 3> points, Rows<double, 3> normals, double radius) {
  require_points(points.shape(0), {normals.shape(0)});
  require(radius > 0.0 && std::isfinite(radius), "a radius is positive");
  return give(without_gil([&] {
    require_finite(view(points), "points must be finite");
    return relief(view(points), view(normals), radius);
  }));
}

nb::ndarray<nb::numpy, double> refine_each(PlaneArray planes, Row<std::int32_t> queries, Row<double> tolerances,
                                           const NearestField& field, Rows<double, 3> normals, bool exact,
                                           const RefinementRules& rules) {
  require_points(field.size(), {normals.shape(0)});
  const std::size_t count = planes.shape(0), steps = count == 0 ? 0 : tolerances.shape(0) / count;
  require(tolerances.shape(0) == steps * count, "each plane needs as many tolerances");
  return give_rows<double>(without_gil([&] {
    require_queries(view(queries), field);
    MirrorCloud cloud{field, {}, exact};
    cloud.points.reserve(field.size());
    for (std::size_t i = 0; i < field.size(); ++i)
      cloud.points.push_back({field.point(i), view(normals)[i], 0.0, false});
    return refine(view_planes(planes), cloud, view(queries), view(tolerances), steps, rules);
  }));
}

nb::ndarray<nb::numpy, std::int32_t> pairs_of(Rows<double, 3> points, Rows<double, 3> normals,
                                              Row<std::uint8_t> oriented, double shortest, double least_cosine) {
  require_points(points.shape(0), {normals.shape(0), oriented.shape(0)});
  return give_rows<std::int32_t>(without_gil(
      [&] { return mirror_pairs(view(points), view(normals), view(oriented), shortest, least_cosine); }));
}

nb::ndarray<nb::numpy, std::int64_t> farthest_of(Rows<double, 3> points, std::size_t count, std::size_t first) {
  require(count <= points.shape(0) && (count == 0 || first < points.shape(0)),
          "more points are wanted than there are");
  return give(without_gil([&] { return farthest_points(view(points), count, first); }));
}

void bind_rules(nb::module_& module) {
  nb::class_<EvidenceRules>(module, "EvidenceRules")
      .def(
          "__init__",
          [](EvidenceRules* rules, double tolerance, double no_direction, double full_direction, double sideways,
             double near_plane, double no_match, double rim_reach, double least_gap, double far, double beyond,
             Row<double> broken_off) {
            require(broken_off.shape(0) == 4, "a plane has four numbers");
            const double* plane = broken_off.data();
            new (rules) EvidenceRules{tolerance, no_direction, full_direction, sideways, near_plane,
                                      no_match,  rim_reach,    least_gap,      far,      beyond,
                                      {{plane[0], plane[1], plane[2]}, plane[3]}};
          },
          nb::kw_only(), nb::arg("tolerance"), nb::arg("no_direction"), nb::arg("full_direction"), nb::arg("sideways"),
          nb::arg("near_plane"), nb::arg("no_match"), nb::arg("rim_reach"), nb::arg("least_gap"), nb::arg("far"),
          nb::arg("beyond"), nb::arg("broken_off"));
  nb::class_<RefinementRules>(module, "RefinementRules")
      .def(
          "__init__",
          [](RefinementRules* rules, double reach, double no_direction, double full_direction, double point_share,
             double ridge, double largest_turn, double settled, std::int32_t fewest) {
            new (rules) RefinementRules{reach, no_direction, full_direction, point_share,
                                        ridge, largest_turn, settled,        fewest};
          },
          nb::kw_only(), nb::arg("reach"), nb::arg("no_direction"), nb::arg("full_direction"), nb::arg("point_share"),
          nb::arg("ridge"), nb::arg("largest_turn"), nb::arg("settled"), nb::arg("fewest"));
}

}  // namespace

void bind_symmetry(nb::module_& module) {
  nb::class_<NearestField>(module, "NearestField")
      .def("__init__", &new_field, nb::arg("points"), nb::arg("table"), nb::arg("origin"), nb::arg("cell"))
      .def_prop_ro("shape", [](const NearestField& field) {
        return nb::make_tuple(field.shape()[0], field.shape()[1], field.shape()[2]);
      })
      .def_prop_ro("cell", &NearestField::cell)
      .def("lookup", &lookup, nb::arg("places"), "A point near each place, right to about a cell.")
      .def("closest", &closest, nb::arg("places"), nb::arg("within") = std::numeric_limits<double>::infinity(),
           "The point closest to each place, the first of several; any one where none is nearer than `within`.");
  bind_rules(module);
  module.def("farthest_points", &farthest_of, nb::arg("points"), nb::arg("count"), nb::arg("first"),
             "Order of points in which each one is the farthest from all those before it.");
  module.def("examine", &examine_planes, nb::arg("planes"), nb::arg("queries"), nb::arg("distinctness"),
             nb::arg("field"), nb::arg("normals"), nb::arg("oriented"), nb::arg("border_distance"), nb::arg("exact"),
             nb::arg("rules"), "Support, agreement, contradiction and residual of each plane.");
  module.def("landings", &landings_of, nb::arg("planes"), nb::arg("queries"), nb::arg("field"), nb::arg("normals"),
             nb::arg("oriented"), nb::arg("border_distance"), nb::arg("exact"), nb::arg("rules"),
             "Partner, weight, distance, cosine, worth and excuse of each query's image, a row of queries a plane.");
  module.def("relief", &relief_of, nb::arg("points"), nb::arg("normals"), nb::arg("radius"),
             "Height of the centroid of each point's ball above its tangent plane, in radii.");
  module.def("refine_planes", &refine_each, nb::arg("planes"), nb::arg("queries"), nb::arg("tolerances"),
             nb::arg("field"), nb::arg("normals"), nb::arg("exact"), nb::arg("rules"),
             "Planes moved to where the mirrored queries fit the cloud best.");
  module.def("mirror_pairs", &pairs_of, nb::arg("points"), nb::arg("normals"), nb::arg("oriented"),
             nb::arg("shortest"), nb::arg("least_cosine"), "Pairs of points that may be mirror images of each other.");
}

}  // namespace symrecon
