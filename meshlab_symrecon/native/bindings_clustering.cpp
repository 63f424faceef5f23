// numpy borders of affinity propagation.
#include "affinity_messages.hpp"
#include "bindings.hpp"
#include "numpy_borders.hpp"

namespace symrecon {
namespace {

template <typename T>
using Matrix = nb::ndarray<const T, nb::ndim<2>, nb::c_contig, nb::device::cpu>;

EdgeTable table_of(const Matrix<std::int32_t>& targets, const Matrix<double>& similarities) {
  if (targets.shape(0) != similarities.shape(0) || targets.shape(1) != similarities.shape(1))
    throw std::invalid_argument("one similarity an edge is needed");
  return {targets.shape(1), {targets.data(), targets.size()}, {similarities.data(), similarities.size()}};
}

void require_known_points(const EdgeTable& table, std::size_t points) {
  for (const std::int32_t target : table.targets)
    if (target < 0 || std::size_t(target) >= points) throw std::out_of_range("edge to an unknown point");
}

void require_own_edges(const EdgeTable& table, std::size_t points) {
  if (table.width == 0) throw std::invalid_argument("each row needs an edge");
  for (std::size_t i = 0; i < points; ++i)
    if (table.targets[i * table.width] != std::int32_t(i))
      throw std::invalid_argument("each row must start with the edge to itself");
}

// Asks a Python callable, which returns similarities and targets, or nothing.
class Neighbours {
 public:
  Neighbours(const nb::object& ask, std::size_t points) : ask_(ask), points_(points) {}

  EdgeTable operator()(const std::vector<std::int32_t>& rows, std::size_t width) {
    nb::gil_scoped_acquire hold;
    const nb::object answer = ask_(give(std::vector<std::int32_t>(rows)), width);
    if (answer.is_none()) return {};
    const nb::tuple pair = nb::cast<nb::tuple>(answer);
    similarities_ = nb::cast<Matrix<double>>(pair[0]);
    targets_ = nb::cast<Matrix<std::int32_t>>(pair[1]);
    const EdgeTable table = table_of(targets_, similarities_);
    if (targets_.shape(0) != rows.size()) throw std::invalid_argument("one row a point is needed");
    require_known_points(table, points_);
    return table;
  }

 private:
  const nb::object& ask_;
  std::size_t points_;
  Matrix<double> similarities_;
  Matrix<std::int32_t> targets_;
};

nb::tuple as_tuple(Exemplars&& found) {
  return nb::make_tuple(give(std::move(found.chosen)), found.converged, found.exact, found.iterations, found.damping,
                        found.edges, give(std::move(found.earlier)));
}

nb::tuple propagate_sparse_of(const Matrix<double>& similarities, const Matrix<std::int32_t>& targets, double damping,
                              std::int32_t most, std::int32_t calm, const nb::object& more) {
  const EdgeTable table = table_of(targets, similarities);
  const std::size_t points = targets.shape(0);
  Neighbours neighbours(more, points);
  MoreEdges ask;
  if (!more.is_none()) ask = std::ref(neighbours);
  return as_tuple(without_gil([&] {
    require_known_points(table, points);
    require_own_edges(table, points);
    return propagate_sparse_affinity(table, {damping, most, calm}, ask, stop_on_interrupt);
  }));
}

nb::tuple propagate_dense_of(const Matrix<double>& similarities, double damping, std::int32_t most,
                             std::int32_t calm) {
  const std::size_t points = similarities.shape(0);
  if (similarities.shape(1) != points) throw std::invalid_argument("a square matrix is needed");
  return as_tuple(without_gil([&] {
    return propagate_dense_affinity(points, {similarities.data(), similarities.size()}, {damping, most, calm},
                                    stop_on_interrupt);
  }));
}

}  // namespace

void bind_clustering(nb::module_& module) {
  module.def("propagate_sparse_affinity", &propagate_sparse_of, nb::arg("similarities"), nb::arg("targets"),
             nb::arg("damping"), nb::arg("most"), nb::arg("calm"), nb::arg("more") = nb::none(),
             "Exemplars; whether they converged and are exact; iterations, last damping, edges; exemplars earlier.");
  module.def("propagate_dense_affinity", &propagate_dense_of, nb::arg("similarities"), nb::arg("damping"),
             nb::arg("most"), nb::arg("calm"), "The same between all points.");
}

}  // namespace symrecon
