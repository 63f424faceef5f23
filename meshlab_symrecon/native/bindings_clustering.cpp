// numpy borders of affinity propagation.
#include "affinity_messages.hpp"
#include "bindings.hpp"
#include "numpy_borders.hpp"

namespace symrecon {
namespace {

using Matrix = nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;

nb::tuple as_tuple(Exemplars&& found) {
  return nb::make_tuple(give(std::move(found.chosen)), give(std::move(found.needed)), found.converged,
                        found.iterations, found.damping);
}

void require_rows(const SparseSimilarities& similarities) {
  const std::size_t edges = similarities.values.size();
  if (similarities.offsets.size() == 0 || similarities.targets.size() != edges || similarities.offsets[0] != 0 ||
      std::size_t(similarities.offsets[similarities.size()]) != edges)
    throw std::invalid_argument("offsets must count the edges");
  for (std::size_t i = 0; i < similarities.size(); ++i)
    if (similarities.offsets[i + 1] <= similarities.offsets[i]) throw std::invalid_argument("each row needs an edge");
  for (std::size_t i = 0; i < similarities.size(); ++i)
    if (similarities.target(i, 0) != i) throw std::invalid_argument("each row must start with the edge to itself");
  for (const std::int32_t target : similarities.targets)
    if (target < 0 || std::size_t(target) >= similarities.size()) throw std::out_of_range("edge to an unknown point");
}

nb::tuple propagate_sparse_of(Row<std::int64_t> offsets, Row<std::int32_t> targets, Row<double> similarities,
                              double damping, std::int32_t most, std::int32_t calm) {
  return as_tuple(without_gil([&] {
    const SparseSimilarities edges{view(offsets), view(targets), view(similarities)};
    require_rows(edges);
    return propagate_affinity(edges, {damping, most, calm}, stop_on_interrupt);
  }));
}

nb::tuple propagate_dense_of(Matrix similarities, double damping, std::int32_t most, std::int32_t calm) {
  if (similarities.shape(0) != similarities.shape(1)) throw std::invalid_argument("a square matrix is needed");
  return as_tuple(without_gil([&] {
    const DenseSimilarities all{similarities.shape(0), {similarities.data(), similarities.size()}};
    return propagate_affinity(all, {damping, most, calm}, stop_on_interrupt);
  }));
}

}  // namespace

void bind_clustering(nb::module_& module) {
  module.def("propagate_sparse_affinity", &propagate_sparse_of, nb::arg("offsets"), nb::arg("targets"),
             nb::arg("similarities"), nb::arg("damping"), nb::arg("most"), nb::arg("calm"),
             "Exemplars, the similarity from which edges are needed, whether it converged, iterations, last damping.");
  module.def("propagate_dense_affinity", &propagate_dense_of, nb::arg("similarities"), nb::arg("damping"),
             nb::arg("most"), nb::arg("calm"), "The same between all points.");
}

}  // namespace symrecon
