// Python bindings of the compiled kernel: numpy arrays in, numpy arrays out, the GIL released in between.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <stdexcept>
#include <utility>
#include <vector>

#include "bindings.hpp"
#include "orthocentres.hpp"
#include "poles.hpp"
#include "predicates.hpp"
#include "regular_triangulation.hpp"
#include "scaling.hpp"
#include "spatial_order.hpp"

namespace nb = nanobind;
using namespace symrecon;

namespace {

using PointArray = nb::ndarray<const double, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;
using FloatArray = nb::ndarray<const double, nb::shape<-1>, nb::c_contig, nb::device::cpu>;
using CellArray = nb::ndarray<const std::int32_t, nb::shape<-1, 4>, nb::c_contig, nb::device::cpu>;

std::vector<Site> gather(const PointArray& points, const FloatArray& weights) {
  if (points.shape(0) != weights.shape(0)) throw std::invalid_argument("one weight a point is needed");
  std::vector<Site> sites(points.shape(0));
  const double* position = points.data();
  for (std::size_t i = 0; i < sites.size(); ++i)
    sites[i] = {position[3 * i], position[3 * i + 1], position[3 * i + 2], weights.data()[i]};
  return sites;
}

// Hand a vector over to numpy without copying it.
template <class Array, class Element>
Array to_numpy(std::vector<Element>&& values, std::initializer_list<std::size_t> shape) {
  auto* owned = new std::vector<Element>(std::move(values));
  nb::capsule owner(owned, [](void* pointer) noexcept { delete static_cast<std::vector<Element>*>(pointer); });
  return Array(owned->data(), shape, owner);
}

using Matrix = nb::ndarray<nb::numpy, std::int32_t, nb::ndim<2>>;
using Vector = nb::ndarray<nb::numpy, std::int32_t, nb::ndim<1>>;
using Floats = nb::ndarray<nb::numpy, double, nb::ndim<1>>;
using Centres = nb::ndarray<nb::numpy, double, nb::ndim<2>>;

nb::tuple triangulate(const PointArray& points, const FloatArray& weights, const nb::object& progress) {
  const bool reports = !progress.is_none();
  const Progress report = [&](double fraction) {
    nb::gil_scoped_acquire hold;
    if (PyErr_CheckSignals() != 0) throw nb::python_error();
    if (reports) progress(fraction);
  };
  RegularTriangulation result;
  {
    std::vector<Site> sites = gather(points, weights);
    nb::gil_scoped_release release;
    result = regular_triangulation(std::move(sites), report);
  }
  const std::size_t cells = result.cells.size(), sites = result.representative.size();
  return nb::make_tuple(
      result.rank,
      to_numpy<Matrix>(std::move(result.cells), {cells, 4}), to_numpy<Matrix>(std::move(result.neighbours), {cells, 4}),
      to_numpy<Vector>(std::move(result.representative), {sites}), to_numpy<Vector>(std::move(result.hidden_cell), {sites}));
}

void require_known_sites(const CellArray& cells, std::size_t sites) {
  for (std::size_t i = 0; i < 4 * cells.shape(0); ++i)
    if (cells.data()[i] < 0 || std::size_t(cells.data()[i]) >= sites) throw std::out_of_range("cell of unknown sites");
}

Centres orthocentres(const PointArray& points, const FloatArray& weights, const CellArray& cells) {
  const std::size_t count = cells.shape(0);
  std::vector<Point> centres(count);
  {
    const std::vector<Site> sites = gather(points, weights);
    nb::gil_scoped_release release;
    require_known_sites(cells, sites.size());
    for (std::size_t i = 0; i < count; ++i) {
      const std::int32_t* vertex = cells.data() + 4 * i;
      centres[i] = orthocentre(sites[vertex[0]], sites[vertex[1]], sites[vertex[2]], sites[vertex[3]]);
    }
  }
  return to_numpy<Centres>(std::move(centres), {count, 3});
}

std::vector<Site> gather(const PointArray& points) {
  std::vector<Site> sites(points.shape(0));
  const double* position = points.data();
  for (std::size_t i = 0; i < sites.size(); ++i)
    sites[i] = {position[3 * i], position[3 * i + 1], position[3 * i + 2], 0.0};
  return sites;
}

void stop_on_interrupt() {
  nb::gil_scoped_acquire hold;
  if (PyErr_CheckSignals() != 0) throw nb::python_error();
}

nb::tuple find_poles_of(const PointArray& points, const CellArray& cells, std::int32_t samples) {
  require_known_sites(cells, points.shape(0));
  const Quad* const first = reinterpret_cast<const Quad*>(cells.data());
  FoundPoles poles;
  Spacings spacings;
  {
    const std::vector<Site> sites = gather(points);
    nb::gil_scoped_release release;
    poles = find_poles(sites, first, cells.shape(0), samples, stop_on_interrupt);
    spacings = sample_spacings(sites, first, cells.shape(0), samples, stop_on_interrupt);
  }
  const std::size_t count = poles.cells.size(), rows = poles.first.size();
  return nb::make_tuple(to_numpy<Vector>(std::move(poles.cells), {count}), to_numpy<Centres>(std::move(poles.centres), {count, 3}),
                        to_numpy<Vector>(std::move(poles.first), {rows}), to_numpy<Vector>(std::move(poles.second), {rows}),
                        to_numpy<Floats>(std::move(spacings.next), {rows}), to_numpy<Floats>(std::move(spacings.mean), {rows}));
}

Vector curve_order_of(const PointArray& points) {
  std::vector<std::int32_t> order;
  {
    nb::gil_scoped_release release;
    std::vector<Site> sites(points.shape(0));
    const double* position = points.data();
    for (std::size_t i = 0; i < sites.size(); ++i)  // -0.0 and 0.0 are one position
      sites[i] = {position[3 * i] + 0.0, position[3 * i + 1] + 0.0, position[3 * i + 2] + 0.0, 0.0};
    order = curve_order(sites);
  }
  const std::size_t count = order.size();
  return to_numpy<Vector>(std::move(order), {count});
}

// The stages of a predicate apart, for the tests: a stage that claims a sign must be right.
enum Stage { all_stages, filter_only, fine_only, exact_only };

int orientation_of(const PointArray& points, int stage) {
  if (points.shape(0) != 4) throw std::invalid_argument("four points are needed");
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
  module.def("orthocentres", &orthocentres, nb::arg("points"), nb::arg("weights"), nb::arg("cells"));
  module.def("find_poles", &find_poles_of, nb::arg("points"), nb::arg("cells"), nb::arg("samples"));
  module.def("curve_order", &curve_order_of, nb::arg("points"));
  module.def("orientation", &orientation_of, nb::arg("points"), nb::arg("stage") = int(all_stages));
  module.def("power_test", &power_test_of, nb::arg("points"), nb::arg("weights"), nb::arg("stage") = int(all_stages));
  module.def("fine_power_determinant", &fine_power_determinant_of, nb::arg("points"), nb::arg("weights"), nb::arg("fused"));
  module.def("perturbed_power_test", &perturbed_power_test_of, nb::arg("points"), nb::arg("weights"));
  bind_crust(module);
  bind_noise(module);
  bind_labels(module);
  bind_surfaces(module);
}
