// numpy borders of distances to a surface.
#include "bindings.hpp"
#include "closest_faces.hpp"
#include "numpy_borders.hpp"

namespace symrecon {
namespace {

nb::tuple feet_of(Rows<double, 3> points, Rows<std::int32_t, 3> faces, Rows<double, 3> normals,
                  Rows<double, 3> places, Rows<double, 3> directions, double least_cosine, bool sided, double within) {
  require(normals.shape(0) == faces.shape(0), "one normal a face is needed");
  require(directions.shape(0) == places.shape(0), "one direction a place is needed");
  Feet feet = without_gil([&] {
    require_known(view(faces), points.shape(0), "faces of unknown points");
    require_finite(view(points), "points must be finite");
    return closest_faces({view(points), view(faces), view(normals)}, view(places), view(directions),
                         {least_cosine, sided, within});
  });
  return nb::make_tuple(give(std::move(feet.faces)), give_rows<double>(std::move(feet.weights)));
}

}  // namespace

void bind_deviation(nb::module_& module) {
  module.def("closest_faces", &feet_of, nb::arg("points"), nb::arg("faces"), nb::arg("normals"), nb::arg("places"),
             nb::arg("directions"), nb::arg("least_cosine"), nb::arg("sided"), nb::arg("within"),
             "The closest face that faces the same way as each place, -1 for none, and where on it.");
}

}  // namespace symrecon
