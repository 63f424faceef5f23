#include "evidence_paths.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "prefetch.hpp"
#include "radix_queue.hpp"

namespace symrecon {
namespace {

// Dijkstra's algorithm on the cover, whose copies 2 i (outer) and 2 i + 1 (inner) are never built.
//
// Copies of nearly equal cost are taken together and in any order; one whose cost falls once more after
// that is taken again, so the result is exact.
class Search {
 public:
  Search(const Network& same_side, const OppositePoles& other_side)
      : same_side_(same_side),
        other_side_(other_side),
        costs_{std::vector<double>(size(), infinity), std::vector<double>(size(), infinity)},
        shorter_(longest_row() + 1) {}

  void offer(std::size_t pole, std::size_t side, double cost) {
    if (!(cost < costs_[side][pole])) return;
    costs_[side][pole] = cost;
    queue_.push(RadixQueue::key_of(cost), static_cast<std::uint32_t>(2 * pole + side));
  }

  // Rows of the network lie far apart, and waiting for them is most of the time: so they are sent for
  // some copies ahead, but not for the three of four copies that have become cheaper since.
  void run(Patience& patience) {
    constexpr std::size_t soon = 4, late = 8;
    std::vector<RadixQueue::Entry> batch;
    while (!queue_.empty()) {
      queue_.take(batch);
      for (std::size_t k = 0; k < batch.size(); ++k) patience.step();
      drop_outdated(batch);
      for (std::size_t k = 0; k < batch.size() + late; ++k) {
        if (k < batch.size()) send_for_offsets(batch[k].item / 2);
        if (k >= soon && k - soon < batch.size()) send_for_rows(batch[k - soon].item / 2);
        if (k >= late) expand(batch[k - late]);
      }
    }
  }

  PathCosts take() { return std::move(costs_); }

 private:
  static constexpr double infinity = std::numeric_limits<double>::infinity();

  std::size_t size() const { return same_side_.offsets.size() - 1; }

  std::size_t longest_row() const {
    std::int64_t longest = 0;
    for (std::size_t pole = 0; pole < size(); ++pole)
      longest = std::max(longest, same_side_.offsets[pole + 1] - same_side_.offsets[pole]);
    return static_cast<std::size_t>(longest);
  }

  const double& cost_of(const RadixQueue::Entry& entry) const { return costs_[entry.item % 2][entry.item / 2]; }

  // Keep the entries with the key of their cost.  Which ones these are no branch can foresee.
  void drop_outdated(std::vector<RadixQueue::Entry>& batch) const {
    constexpr std::size_t soon = 12;
    std::size_t kept = 0;
    for (std::size_t k = 0; k < batch.size(); ++k) {
      if (k + soon < batch.size()) prefetch(&cost_of(batch[k + soon]));
      const RadixQueue::Entry entry = batch[k];
      batch[kept] = entry;
      kept += RadixQueue::key_of(cost_of(entry)) == entry.key;
    }
    batch.resize(kept);
  }

  void expand(const RadixQueue::Entry& entry) {
    const std::size_t pole = entry.item / 2, side = entry.item % 2;
    const double cost = costs_[side][pole];
    if (RadixQueue::key_of(cost) != entry.key) return;  // cheaper since the batch was taken
    offer_row(pole, side, cost);
    for (std::int64_t k = other_side_.offsets[pole]; k < other_side_.offsets[pole + 1]; ++k)
      offer(other_side_.arcs[k].pole, 1 - side, cost + other_side_.arcs[k].value);
  }

  // Most offers fail, which no branch can foresee: so they are sorted out without one.
  void offer_row(std::size_t pole, std::size_t side, double cost) {
    const std::vector<double>& costs = costs_[side];
    std::size_t count = 0;
    for (std::int64_t arc = same_side_.offsets[pole]; arc < same_side_.offsets[pole + 1]; ++arc) {
      shorter_[count] = arc;
      count += cost + same_side_.lengths[arc] < costs[same_side_.ends[arc]];
    }
    for (std::size_t k = 0; k < count; ++k)
      offer(same_side_.ends[shorter_[k]], side, cost + same_side_.lengths[shorter_[k]]);
  }

  void send_for_offsets(std::size_t pole) const {
    prefetch(&same_side_.offsets[pole]);
    prefetch(&other_side_.offsets[pole]);
  }

  void send_for_rows(std::size_t pole) const {
    constexpr std::int64_t line = 16;  // ends, or lengths, in a line of the cache
    const std::int64_t arc = same_side_.offsets[pole];
    for (const std::int64_t start : {arc, std::min(arc + line, same_side_.offsets[pole + 1])}) {
      prefetch(same_side_.ends.begin() + start);
      prefetch(same_side_.lengths.begin() + start);
    }
    prefetch(other_side_.arcs.data() + other_side_.offsets[pole]);
  }

  const Network& same_side_;
  const OppositePoles& other_side_;
  PathCosts costs_;
  RadixQueue queue_;
  std::vector<std::int64_t> shorter_;  // arcs of the row at hand that lead to a lower cost
};

}  // namespace

PathCosts evidence_paths(const Network& same_side, const OppositePoles& other_side,
                         View<std::uint8_t> seeds, const Progress& progress) {
  Search search(same_side, other_side);
  for (std::size_t pole = 0; pole < seeds.size(); ++pole)
    if (seeds[pole]) search.offer(pole, 0, 0.0);
  Patience patience(progress, 4 * seeds.size());
  search.run(patience);
  return search.take();
}

}  // namespace symrecon
