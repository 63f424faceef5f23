// numpy borders of the labelling.
#include "bindings.hpp"
#include "evidence_paths.hpp"
#include "minimum_cut.hpp"
#include "numpy_borders.hpp"
#include "pole_graph.hpp"
#include "pole_pieces.hpp"
#include "propagation.hpp"

namespace symrecon {
namespace {

using Offsets = Row<std::int64_t>;
using Numbers = Row<std::int32_t>;

void require_network(const Network& network, std::size_t nodes) {
  require(network.offsets.size() == nodes + 1, "one row a pole is needed");
  require(network.lengths.size() == network.ends.size(), "one length an edge is needed");
  require_rows(network.offsets, network.ends.size());
  require_known(network.ends, nodes, "edges to unknown poles");
}

void require_pairs(View<std::int32_t> first, View<std::int32_t> second, View<double> values, std::size_t poles) {
  require(second.size() == first.size() && values.size() == first.size(), "one value a pair of poles is needed");
  require_known(first, poles, "pairs of unknown poles");
  require_known(second, poles, "pairs of unknown poles");
}

nb::tuple graph_of(Rows<double, 3> centres, Row<double> radii, Rows<std::int32_t, 4> samples,
                   Row<std::uint8_t> used, std::int32_t sample_count, Rows<std::int32_t, 4> cells,
                   Rows<std::int32_t, 4> neighbours, std::int32_t most_partners, const nb::object& progress) {
  const UsedBalls balls{view(centres), view(radii), view(samples), view(used), sample_count};
  const Progress report = reporter(progress);
  PoleGraph graph = without_gil([&] {
    const std::size_t poles = centres.shape(0);
    require(radii.shape(0) == poles && samples.shape(0) == poles && used.shape(0) == poles,
            "one radius, four samples and one mark a ball are needed");
    require(sample_count >= 0 && most_partners >= 0, "neither samples nor partners can be fewer than none");
    require_finite(view(centres), "centres must be finite");
    for (const double radius : view(radii)) require(std::isfinite(radius * radius), "radii must have finite squares");
    require_known(view(samples), std::size_t(1) << 31, "balls at negative sites");
    require_cells(view(cells), poles);
    require_neighbours(view(neighbours), view(cells));
    return pole_graph(balls, view(cells), view(neighbours), most_partners, report);
  });
  return nb::make_tuple(give(std::move(graph.offsets)), give(std::move(graph.ends)),
                        give(std::move(graph.cosines)));
}

nb::tuple paths_of(Offsets offsets, Numbers ends, Row<float> lengths, Numbers first, Numbers second,
                   Row<double> crossings, Row<std::uint8_t> seeds, const nb::object& progress) {
  const Network same_side{view(offsets), view(ends), view(lengths)};
  const Progress report = reporter(progress);
  PathCosts costs = without_gil([&] {
    require_network(same_side, seeds.shape(0));
    require_pairs(view(first), view(second), view(crossings), seeds.shape(0));
    for (const float length : same_side.lengths) require(length >= 0.0f, "lengths cannot be negative");
    for (const double crossing : view(crossings)) require(crossing >= 0.0, "crossings cannot be negative");
    const OppositePoles other_side(seeds.shape(0), view(first), view(second), view(crossings));
    return evidence_paths(same_side, other_side, view(seeds), report);
  });
  return nb::make_tuple(give(std::move(costs[0])), give(std::move(costs[1])));
}

nb::ndarray<nb::numpy, std::uint8_t> labels_of(Offsets offsets, Numbers ends, Row<float> lengths, Numbers first,
                                               Numbers second, Row<double> flatness, Row<double> radii,
                                               Row<std::uint8_t> seeds, double offered, double accepted,
                                               const nb::object& progress) {
  require(radii.shape(0) == seeds.shape(0), "one radius for each seed");
  const Network intersections{view(offsets), view(ends), view(lengths)};
  const Progress report = reporter(progress);
  return give(without_gil([&] {
    require_network(intersections, seeds.shape(0));
    require_pairs(view(first), view(second), view(flatness), seeds.shape(0));
    const OppositePoles opposites(seeds.shape(0), view(first), view(second), view(flatness));
    return propagate_labels({intersections, opposites}, view(radii), view(seeds), {offered, accepted}, report);
  }));
}

// A minimum cut that keeps the arrays it looks at alive.
class BoundCut {
 public:
  BoundCut(Offsets offsets, Numbers ends, Row<std::uint16_t> capacities)
      : offsets_(offsets), ends_(ends), capacities_(capacities), cut_(view(offsets), view(ends), view(capacities)) {}

  nb::ndarray<nb::numpy, std::uint8_t> inner_side(Numbers ties, const nb::object& progress) {
    require(!busy_, "a cut that is at work cannot be asked again");
    const Busy at_work(busy_);
    const Progress report = reporter(progress);
    return give(without_gil([&] { return cut_.inner_side(view(ties), report); }));
  }

 private:
  Offsets offsets_;
  Numbers ends_;
  // Set and unset while the interpreter's lock is held.
  class Busy {
   public:
    explicit Busy(bool& flag) : flag_(flag) { flag_ = true; }
    ~Busy() { flag_ = false; }

   private:
    bool& flag_;
  };

  Row<std::uint16_t> capacities_;
  MinimumCut cut_;
  bool busy_ = false;
};

}  // namespace

void bind_labels(nb::module_& module) {
  module.def("pole_graph", &graph_of, nb::arg("centres"), nb::arg("radii"), nb::arg("samples"), nb::arg("used"),
             nb::arg("sample_count"), nb::arg("cells"), nb::arg("neighbours"), nb::arg("most_partners"),
             nb::arg("progress") = nb::none(),
             "Balls that intersect at less than a right angle: offsets, ends, cosines.");
  module.def(
      "flatness_of_pairs",
      [](Rows<double, 3> centres, Rows<std::int32_t, 2> pairs, Rows<double, 3> samples, Numbers pair_samples) {
        return give(without_gil([&] {
          require(pair_samples.shape(0) == pairs.shape(0), "one sample a pair is needed");
          require_known(view(pairs), centres.shape(0), "pairs of unknown poles");
          require_known(view(pair_samples), samples.shape(0), "pairs at unknown samples");
          return flatness_of_pairs(view(centres), view(pairs), view(samples), view(pair_samples));
        }));
      },
      nb::arg("centres"), nb::arg("pairs"), nb::arg("samples"), nb::arg("pair_samples"),
      "Minus the cosine of the angle between the two poles of each sample.");
  module.def("evidence_paths", &paths_of, nb::arg("offsets"), nb::arg("ends"), nb::arg("lengths"), nb::arg("first"),
             nb::arg("second"), nb::arg("crossings"), nb::arg("seeds"), nb::arg("progress") = nb::none(),
             "Length of the shortest path from a seed to the outer and to the inner copy of each pole.");
  module.def("propagate_labels", &labels_of, nb::arg("offsets"), nb::arg("ends"), nb::arg("lengths"), nb::arg("first"),
             nb::arg("second"), nb::arg("flatness"), nb::arg("radii"), nb::arg("seeds"), nb::arg("offered"),
             nb::arg("accepted"), nb::arg("progress") = nb::none(),
             "The label of each pole by greedy propagation: 0 none, 1 outside, 2 inside.");
  nb::class_<BoundCut>(module, "MinimumCut")
      .def(nb::init<Offsets, Numbers, Row<std::uint16_t>>(), nb::arg("offsets"), nb::arg("ends"),
           nb::arg("capacities"))
      .def("inner_side", &BoundCut::inner_side, nb::arg("ties"), nb::arg("progress") = nb::none(),
           "The nodes on the inner side of the minimum cut that leaves the most there.");
  module.def(
      "turn_small_pieces",
      [](Rows<std::int32_t, 4> cells, Row<std::uint8_t> labels, Row<std::uint8_t> fixed, Numbers samples,
         double smallest) {
        return give(without_gil([&] {
          require(fixed.shape(0) == labels.shape(0) && samples.shape(0) == labels.shape(0),
                  "one mark and one number of samples a pole are needed");
          require_cells(view(cells), labels.shape(0));
          require_marks(view(labels), "a pole is inner (1) or outer (0)");
          return turn_small_pieces(view(cells), view(labels), view(fixed), view(samples), smallest);
        }));
      },
      nb::arg("cells"), nb::arg("labels"), nb::arg("fixed"), nb::arg("samples"), nb::arg("smallest"),
      "The labels with islands and bubbles of fewer samples turned over.");
}

}  // namespace symrecon
