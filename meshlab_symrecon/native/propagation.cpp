#include "propagation.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <queue>

namespace symrecon {
namespace {

PoleLabel other(PoleLabel label) { return label == inner_pole ? outer_pole : inner_pole; }

class Propagation {
 public:
  Propagation(const Evidence& evidence, View<double> radii)
      : evidence_(evidence),
        radii_(radii),
        labels_(radii.size(), unlabelled),
        outer_(radii.size(), 0.0),
        inner_(radii.size(), 0.0) {}

  void offer(std::int32_t pole, PoleLabel label, double confidence) {
    double& best = (label == inner_pole ? inner_ : outer_)[pole];
    if (labels_[pole] != unlabelled || !(confidence > best)) return;
    best = confidence;
    queue_.push({priority(pole), radii_[pole], pole});
  }

  // Label the most certain pole, which then offers what follows from it, until none is left.
  void run(double least_cosine, Patience& patience) {
    while (!queue_.empty()) {
      const Candidate top = queue_.top();
      queue_.pop();
      if (labels_[top.pole] != unlabelled || top.priority != priority(top.pole)) continue;
      patience.step();
      const PoleLabel label = inner_[top.pole] > outer_[top.pole] ? inner_pole : outer_pole;
      labels_[top.pole] = label;
      const double confidence = std::max(inner_[top.pole], outer_[top.pole]);
      for_each_neighbour(top.pole, [&](std::int32_t pole, double cosine) {
        if (cosine > least_cosine) offer(pole, label, cosine * confidence);
      });
      for_each_opposite(top.pole, [&](const OppositePoles::Arc& arc) {
        offer(arc.pole, other(label), arc.value * confidence);
      });
    }
  }

  // Label those that no offer reached by what lies round them, in order of their numbers.
  void label_the_rest(double least_cosine) {
    for (std::size_t i = 0; i < labels_.size(); ++i)
      if (labels_[i] == unlabelled) labels_[i] = by_surroundings(static_cast<std::int32_t>(i), least_cosine);
  }

  std::vector<std::uint8_t> take() { return {labels_.begin(), labels_.end()}; }

 private:
  struct Candidate {
    double priority, radius;
    std::int32_t pole;

    bool operator<(const Candidate& than) const {
      if (priority != than.priority) return priority < than.priority;
      return radius != than.radius ? radius < than.radius : pole > than.pole;
    }
  };

  // Contradictory offers come last, the most contradictory of them at the very end.
  double priority(std::int32_t pole) const {
    const double outer = outer_[pole], inner = inner_[pole];
    return outer > 0.0 && inner > 0.0 ? std::abs(inner - outer) - 1.0 : std::max(inner, outer);
  }

  PoleLabel by_surroundings(std::int32_t pole, double least_cosine) const {
    std::array<double, 3> deepest{};  // by label
    for_each_neighbour(pole, [&](std::int32_t next, double cosine) {
      deepest[labels_[next]] = std::max(deepest[labels_[next]], cosine);
    });
    const bool outer = deepest[outer_pole] > least_cosine, inner = deepest[inner_pole] > least_cosine;
    if (outer != inner) return inner ? inner_pole : outer_pole;
    const PoleLabel across = label_across(pole);
    if (across != unlabelled) return other(across);
    if (!outer) return unlabelled;
    return deepest[inner_pole] > deepest[outer_pole] ? inner_pole : outer_pole;
  }

  // The label of the opposite poles; none when they disagree.
  PoleLabel label_across(std::int32_t pole) const {
    std::array<bool, 3> seen{};
    for_each_opposite(pole, [&](const OppositePoles::Arc& arc) { seen[labels_[arc.pole]] = true; });
    if (seen[outer_pole] == seen[inner_pole]) return unlabelled;
    return seen[inner_pole] ? inner_pole : outer_pole;
  }

  template <typename Visit>
  void for_each_neighbour(std::int32_t pole, Visit&& visit) const {
    const Network& near = evidence_.intersections;
    for (std::int64_t arc = near.offsets[pole]; arc < near.offsets[pole + 1]; ++arc)
      visit(near.ends[arc], std::exp(-static_cast<double>(near.lengths[arc])));
  }

  template <typename Visit>
  void for_each_opposite(std::int32_t pole, Visit&& visit) const {
    const OppositePoles& across = evidence_.opposites;
    for (std::int64_t k = across.offsets[pole]; k < across.offsets[pole + 1]; ++k) visit(across.arcs[k]);
  }

  const Evidence& evidence_;
  const View<double> radii_;
  std::vector<PoleLabel> labels_;
  std::vector<double> outer_, inner_;  // the best offers
  std::priority_queue<Candidate> queue_;
};

}  // namespace

std::vector<std::uint8_t> propagate_labels(const Evidence& evidence, View<double> radii, View<std::uint8_t> seeds,
                                           const Thresholds& thresholds, const Progress& progress) {
  Propagation propagation(evidence, radii);
  for (std::size_t pole = 0; pole < seeds.size(); ++pole)
    if (seeds[pole]) propagation.offer(static_cast<std::int32_t>(pole), outer_pole, 1.0);
  Patience patience(progress, seeds.size());
  propagation.run(thresholds.offered, patience);
  propagation.label_the_rest(thresholds.accepted);
  return propagation.take();
}

}  // namespace symrecon
