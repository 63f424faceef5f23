// numpy borders of affinity propagation.
#include "affinity_messages.hpp"
#include "bindings.hpp"
#include "numpy_borders.hpp"

namespace symrecon {
namespace {

template <typename T>
using Matrix = nb::ndarray<const T, nb::ndim<2>, nb::c_contig, nb::device::cpu>;

EdgeTable table_of(const Matrix<std::int32_t>& targets, const Matrix<double>& similarities) {
  require(targets.shape(0) == similarities.shape(0) && targets.shape(1) == similarities.shape(1),
          "one similarity an edge is needed");
  return {targets.shape(1), {targets.data(), targets.size()}, {similarities.data(), similarities.size()}};
}

void require_own_edges(const EdgeTable& table, std::size_t points) {
  require(table.width > 0, "each row needs an edge");
  for (std::size_t i = 0; i < points; ++i) {
    require(table.targets[i * table.width] == std::int32_t(i), "each row must start with the edge to itself");
    require(std::isfinite(table.similarities[i * table.width]), "the similarity to itself must be finite");
  }
}

MessageSchedule schedule_of(double damping, std::int32_t most, std::int32_t calm) {
  require(most >= 0 && calm >= 0, "iterations cannot be fewer than none");
  require(damping >= 0.0 && damping < 1.0, "damping must be at least 0 and less than 1");
  return {damping, most, calm};
}

// Asks a Python callable, which returns similarities and targets, or nothing.
class Neighbours {
 public:
  Neighbours(const nb::object& ask, std::size_t points) : ask_(ask), points_(points) {}

  EdgeTable operator()(const std::vector<std::int32_t>& rows, std::size_t width) {
    nb::gil_scoped_acquire hold;
    const nb::object answer = ask_(give(std::vector<std::int32_t>(rows)), width);
    if (answer.is_none()) return {};
    const bool is_pair = nb::isinstance<nb::tuple>(answer) && nb::len(answer) == 2;
    if (!is_pair || !nb::try_cast(answer[0], similarities_) || !nb::try_cast(answer[1], targets_))
      throw nb::type_error("an answer is None, or a matrix of similarities and one of targets");
    const EdgeTable table = table_of(targets_, similarities_);
    require(targets_.shape(0) == rows.size(), "one row a point is needed");
    require_known(table.targets, points_, "edge to an unknown point");
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
    require_known(table.targets, points, "edge to an unknown point");
    require_own_edges(table, points);
    return propagate_sparse_affinity(table, schedule_of(damping, most, calm), ask, stop_on_interrupt);
  }));
}

nb::tuple propagate_dense_of(const Matrix<double>& similarities, double damping, std::int32_t most,
                             std::int32_t calm) {
  const std::size_t points = similarities.shape(0);
  require(similarities.shape(1) == points, "a square matrix is needed");
  return as_tuple(without_gil([&] {
    return propagate_dense_affinity(points, {similarities.data(), similarities.size()},
                                    schedule_of(damping, most, calm), stop_on_interrupt);
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
