// Python bindings of the compiled kernel: numpy arrays in, numpy arrays out, the GIL released in between.
#include "bindings.hpp"
#include "numpy_borders.hpp"
#include "orthocentres.hpp"
#include "poles.hpp"
#include "predicates.hpp"
#include "regular_triangulation.hpp"
#include "scaling.hpp"
#include "spatial_order.hpp"

using namespace symrecon;

namespace {

using PointArray = Rows<double, 3>;
using FloatArray = Row<double>;
using CellArray = Rows<std::int32_t, 4>;
using Numbers = nb::ndarray<nb::numpy, std::int32_t>;

std::vector<Site> gather(const PointArray& points, const FloatArray& weights) {
  require(points.shape(0) == weights.shape(0), "one weight a point is needed");
  require_finite(view(points), "points must be finite");
  require_finite(view(weights), "weights must be finite");
  std::vector<Site> sites(points.shape(0));
  const double* position = points.data();
  for (std::size_t i = 0; i < sites.size(); ++i)
    sites[i] = {position[3 * i], position[3 * i + 1], position[3 * i + 2], weights.data()[i]};
  return sites;
}

nb::tuple triangulate(const PointArray& points, const FloatArray& weights, const nb::object& progress) {
  const Progress report = reporter(progress);
  std::vector<Site> sites = gather(points, weights);
  RegularTriangulation result = without_gil([&] { return regular_triangulation(std::move(sites), report); });
  return nb::make_tuple(result.rank, give_rows<std::int32_t>(std::move(result.cells)),
                        give_rows<std::int32_t>(std::move(result.neighbours)), give(std::move(result.representative)),
                        give(std::move(result.hidden_cell)));
}

nb::ndarray<nb::numpy, double> orthocentres_of(const PointArray& points, const FloatArray& weights,
                                               const CellArray& cells) {
  const std::vector<Site> sites = gather(points, weights);
  return give_rows<double>(without_gil([&] {
    require_cells(view(cells), sites.size());
    std::vector<Point> centres;
    centres.reserve(cells.shape(0));
    for (const Quad& cell : view(cells))
      centres.push_back(orthocentre(sites[cell[0]], sites[cell[1]], sites[cell[2]], sites[cell[3]]));
    return centres;
  }));
}

std::vector<Site> gather(const PointArray& points) {
  require_finite(view(points), "points must be finite");
  std::vector<Site> sites(points.shape(0));
  const double* position = points.data();
  for (std::size_t i = 0; i < sites.size(); ++i)
    sites[i] = {position[3 * i], position[3 * i + 1], position[3 * i + 2], 0.0};
  return sites;
}

nb::tuple find_poles_of(const PointArray& points, const CellArray& cells, std::int32_t samples) {
  FoundPoles poles;
  Spacings spacings;
  without_gil([&] {
    require(samples >= 0 && std::size_t(samples) <= points.shape(0), "samples must be among the points");
    require_cells(view(cells), points.shape(0));
    const std::vector<Site> sites = gather(points);
    poles = find_poles(sites, view(cells), samples, stop_on_interrupt);
    spacings = sample_spacings(sites, view(cells), samples, stop_on_interrupt);
  });
  return nb::make_tuple(give(std::move(poles.cells)), give_rows<double>(std::move(poles.centres)),
                        give(std::move(poles.first)), give(std::move(poles.second)), give(std::move(spacings.next)),
                        give(std::move(spacings.mean)));
}

Numbers curve_order_of(const PointArray& points) {
  return give(without_gil([&] {
    std::vector<Site> sites = gather(points);
    for (Site& site : sites) site = {site.x + 0.0, site.y + 0.0, site.z + 0.0, 0.0};  // -0.0 and 0.0 are one position
    return curve_order(sites);
  }));
}

// The stages of a predicate apart, for the tests: a stage that claims a sign must be right.
enum Stage { all_stages, filter_only, fine_only, exact_only };

int orientation_of(const PointArray& points, int stage) {
  if (points.shape(0) != 4) throw std::invalid_argument("four points are needed");
  require_finite(view(points), "points must be finite");
  std::vector<Site> s(4);
  for (int i = 0; i < 4; ++i) s[i] = {points.data()[3 * i], points.data()[3 * i + 1], points.data()[3 * i + 2], 0.0};
  const Margins margins = margins_for(s);
  double permanent;
  const int filtered = filtered_orientation(s[0], s[1], s[2], s[3], margins.orientation, permanent);
  const double bound = fine_orientation_bound * permanent + margins.orientation;
  if (stage == filter_only) return filtered;
  if (stage == fine_only) return fine_orientation(s[0], s[1], s[2], s[3], bound);
  if (stage == exact_only) return exact_orientation(s[0], s[1], s[2], s[3]);
  return orientation(s[0], s[1], s[2], s[3], margins);
}

int power_test_of(const PointArray& points, const FloatArray& weights, int stage) {
  if (points.shape(0) != 5) throw std::invalid_argument("five points are needed");
  const std::vector<Site> s = gather(points, weights);
  const Margins margins = margins_for(s);
  double permanent;
  const int filtered = filtered_power_test(s[0], s[1], s[2], s[3], s[4], margins.power, permanent);
  const double bound = fine_power_bound * permanent + margins.power;
  if (stage == filter_only) return filtered;
  if (stage == fine_only) return fine_power_test(s[0], s[1], s[2], s[3], s[4], bound);
  if (stage == exact_only) return exact_power_test(s[0], s[1], s[2], s[3], s[4]);
  return power_test(s[0], s[1], s[2], s[3], s[4], margins);
}

double fine_power_determinant_of(const PointArray& points, const FloatArray& weights, bool fused) {
  if (points.shape(0) != 5) throw std::invalid_argument("five points are needed");
  const std::vector<Site> s = gather(points, weights);
  return fine_power_determinant(s[0], s[1], s[2], s[3], s[4], fused && has_fma());
}

int perturbed_power_test_of(const PointArray& points, const FloatArray& weights) {
  if (points.shape(0) != 5) throw std::invalid_argument("five points are needed");
  const std::vector<Site> s = gather(points, weights);
  return perturbed_power_test(s[0], s[1], s[2], s[3], s[4], margins_for(s));
}

}  // namespace

NB_MODULE(_native, module) {
  module.doc() = "Compiled kernel of meshlab_symrecon.";
  module.def("regular_triangulation", &triangulate, nb::arg("points"), nb::arg("weights"),
             nb::arg("progress") = nb::none());
  module.def("orthocentres", &orthocentres_of, nb::arg("points"), nb::arg("weights"), nb::arg("cells"));
  module.def("find_poles", &find_poles_of, nb::arg("points"), nb::arg("cells"), nb::arg("samples"));
  module.def("curve_order", &curve_order_of, nb::arg("points"));
  module.def("orientation", &orientation_of, nb::arg("points"), nb::arg("stage") = int(all_stages));
  module.def("power_test", &power_test_of, nb::arg("points"), nb::arg("weights"), nb::arg("stage") = int(all_stages));
  module.def("fine_power_determinant", &fine_power_determinant_of, nb::arg("points"), nb::arg("weights"),
             nb::arg("fused"));
  module.def("perturbed_power_test", &perturbed_power_test_of, nb::arg("points"), nb::arg("weights"));
  bind_clustering(module);
  bind_deviation(module);
  bind_crust(module);
  bind_noise(module);
  bind_interrupts(module);
  bind_labels(module);
  bind_memory(module);
  bind_streams(module);
  bind_surfaces(module);
  bind_symmetry(module);
}
