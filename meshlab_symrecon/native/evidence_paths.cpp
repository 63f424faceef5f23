#include "evidence_paths.hpp"

#include <cmath>
#include <limits>
#include <utility>

namespace symrecon {
namespace {

// A copy of a pole on its way into the tree of shortest paths; copy 2 i is outer, 2 i + 1 inner.
struct Offer {
  double cost;
  std::int64_t copy;
};

// A heap of four children a node: fewer levels than two, all four in one line of the cache.
class Queue {
 public:
  bool empty() const { return offers_.empty(); }

  void push(Offer offer) {
    std::size_t place = offers_.size();
    offers_.push_back(offer);
    while (place > 0) {
      const std::size_t parent = (place - 1) / 4;
      if (offers_[parent].cost <= offer.cost) break;
      offers_[place] = offers_[parent];
      place = parent;
    }
    offers_[place] = offer;
  }

  Offer pop() {
    const Offer top = offers_.front(), last = offers_.back();
    offers_.pop_back();
    const std::size_t size = offers_.size();
    std::size_t place = 0;
    for (std::size_t child = 1; child < size; child = 4 * place + 1) {
      const std::size_t end = std::min(child + 4, size);
      std::size_t least = child;
      for (std::size_t k = child + 1; k < end; ++k)
        if (offers_[k].cost < offers_[least].cost) least = k;
      if (last.cost <= offers_[least].cost) break;
      offers_[place] = offers_[least];
      place = least;
    }
    if (size > 0) offers_[place] = last;
    return top;
  }

 private:
  std::vector<Offer> offers_;
};

}  // namespace

PathCosts evidence_paths(const PoleGraphView& graph, const OppositePoles& opposites,
                         View<std::uint8_t> seeds, const Progress& progress) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  PathCosts costs(graph.size(), {infinity, infinity});
  std::vector<float> length(graph.cosines.size());
  for (std::size_t arc = 0; arc < length.size(); ++arc) length[arc] = -std::log(graph.cosines[arc]);
  Queue queue;
  const auto offer = [&](std::size_t pole, std::size_t side, double cost) {
    if (!(cost < costs[pole][side])) return;
    costs[pole][side] = cost;
    queue.push({cost, static_cast<std::int64_t>(2 * pole + side)});
  };
  for (std::size_t pole = 0; pole < graph.size(); ++pole)
    if (seeds[pole]) offer(pole, 0, 0.0);
  Patience patience(progress, 2 * graph.size());
  while (!queue.empty()) {
    const auto [cost, copy] = queue.pop();
    const std::size_t pole = copy / 2, side = copy % 2;
    if (cost > costs[pole][side]) continue;
    patience.step();
    for (std::int64_t arc = graph.offsets[pole]; arc < graph.offsets[pole + 1]; ++arc)
      offer(graph.ends[arc], side, cost + length[arc]);
    for (std::int64_t k = opposites.offsets[pole]; k < opposites.offsets[pole + 1]; ++k)
      offer(opposites.arcs[k].pole, 1 - side, cost - std::log(opposites.arcs[k].certainty));
  }
  return costs;
}

}  // namespace symrecon
