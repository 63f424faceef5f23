#include "pole_graph.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace symrecon {
namespace {

double dot(const Position& a, const Position& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

Position arm(const Position& from, const Position& to) {
  return {to[0] - from[0], to[1] - from[1], to[2] - from[2]};
}

// Rows of numbers that a counting sort puts together.
struct Buckets {
  std::vector<std::int64_t> offsets;
  std::vector<std::int32_t> items;
};

// `visit(emit)` calls emit(bucket, item) for every item, twice over in the same order.
template <typename Visit>
Buckets counting_sort(std::size_t buckets, Visit&& visit) {
  Buckets sorted{std::vector<std::int64_t>(buckets + 2, 0), {}};
  std::vector<std::int64_t>& start = sorted.offsets;
  visit([&](std::int32_t bucket, std::int32_t) { ++start[bucket + 2]; });
  std::partial_sum(start.begin(), start.end(), start.begin());
  sorted.items.resize(start.back());
  // start[b + 1] runs from the start of bucket b to its end, which is where bucket b + 1 starts
  visit([&](std::int32_t bucket, std::int32_t item) { sorted.items[start[bucket + 1]++] = item; });
  start.pop_back();
  return sorted;
}

// Each edge once, from its higher end; the lower ends of a pole are in the order of their discovery.
class LowerEdges {
 public:
  std::vector<std::int64_t> offsets{0};
  std::vector<std::int32_t> ends;
  std::vector<float> cosines;

  LowerEdges(const PolarBalls& balls, std::size_t expected) : balls_(balls), seen_(balls.radii.size(), -1) {
    offsets.reserve(seen_.size() + 1);
    ends.reserve(expected);
    cosines.reserve(expected);
  }

  void offer(std::int32_t lower, std::int32_t pole) {
    if (lower >= pole || seen_[lower] == pole) return;
    seen_[lower] = pole;
    const double r = balls_.radii[lower], s = balls_.radii[pole];
    const Position apart = arm(balls_.centres[lower], balls_.centres[pole]);
    const double overlap = r * r + s * s - dot(apart, apart);
    if (!(overlap > 0.0)) return;
    ends.push_back(lower);
    cosines.push_back(static_cast<float>(std::min(1.0, overlap / (2.0 * r * s))));
  }

  void close() { offsets.push_back(static_cast<std::int64_t>(ends.size())); }

 private:
  const PolarBalls& balls_;
  std::vector<std::int32_t> seen_;  // the pole that met this one last
};

LowerEdges lower_edges(const PolarBalls& balls, View<Quad> cells, std::int32_t most_partners,
                       const Progress& progress) {
  const std::size_t count = balls.radii.size();
  const Buckets at_sample = counting_sort(balls.sample_count, [&](auto&& emit) {
    for (std::size_t pole = 0; pole < count; ++pole)
      if (balls.used[pole])
        for (const std::int32_t sample : balls.samples[pole])
          if (sample < balls.sample_count) emit(sample, static_cast<std::int32_t>(pole));
  });
  // a cell tells nothing to the lowest of its poles
  const Buckets around = counting_sort(count, [&](auto&& emit) {
    for (std::size_t cell = 0; cell < cells.size(); ++cell) {
      const Quad& poles = cells[cell];
      const std::int32_t lowest = *std::min_element(poles.begin(), poles.end());
      for (const std::int32_t pole : poles)
        if (pole != lowest) emit(pole, static_cast<std::int32_t>(cell));
    }
  });
  LowerEdges edges(balls, 2 * around.items.size());
  Patience patience(progress, count);
  std::vector<std::int64_t> next(at_sample.offsets);  // place of the pole at hand among a sample's
  for (std::size_t i = 0; i < count; ++i) {
    patience.step();
    const auto pole = static_cast<std::int32_t>(i);
    for (std::int64_t k = around.offsets[i]; k < around.offsets[i + 1]; ++k)
      for (const std::int32_t other : cells[around.items[k]]) edges.offer(other, pole);
    if (balls.used[i])
      for (const std::int32_t sample : balls.samples[i]) {
        if (sample >= balls.sample_count) continue;
        const std::int64_t place = next[sample]++;
        const std::int64_t first =
            std::max<std::int64_t>(at_sample.offsets[sample], place - most_partners + 1);
        for (std::int64_t k = first; k < place; ++k) edges.offer(at_sample.items[k], pole);
      }
    edges.close();
  }
  return edges;
}

}  // namespace

PoleGraph pole_graph(const PolarBalls& balls, View<Quad> cells, std::int32_t most_partners,
                     const Progress& progress) {
  LowerEdges lower = lower_edges(balls, cells, most_partners, progress);
  const std::size_t count = balls.radii.size();
  PoleGraph graph;
  graph.offsets.assign(count + 1, 0);
  for (std::size_t i = 0; i < count; ++i) graph.offsets[i + 1] = lower.offsets[i + 1] - lower.offsets[i];
  for (const std::int32_t end : lower.ends) ++graph.offsets[end + 1];
  std::partial_sum(graph.offsets.begin(), graph.offsets.end(), graph.offsets.begin());
  graph.ends.resize(graph.offsets.back());
  graph.cosines.resize(graph.offsets.back());
  std::vector<std::int64_t> next(graph.offsets.begin(), graph.offsets.end() - 1);
  std::vector<std::pair<std::int32_t, float>> row;
  for (std::size_t i = 0; i < count; ++i) {
    row.clear();
    for (std::int64_t k = lower.offsets[i]; k < lower.offsets[i + 1]; ++k)
      row.emplace_back(lower.ends[k], lower.cosines[k]);
    std::sort(row.begin(), row.end());
    for (const auto& [end, cosine] : row) {
      graph.ends[next[i]] = end;
      graph.cosines[next[i]++] = cosine;
      graph.ends[next[end]] = static_cast<std::int32_t>(i);
      graph.cosines[next[end]++] = cosine;
    }
  }
  return graph;
}

std::vector<double> flatness_of_pairs(View<Position> centres, View<std::array<std::int32_t, 2>> pairs,
                                      View<Position> samples, View<std::int32_t> pair_samples) {
  std::vector<double> flatness(pairs.size());
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const Position& sample = samples[pair_samples[i]];
    const Position one = arm(sample, centres[pairs[i][0]]), other = arm(sample, centres[pairs[i][1]]);
    const double lengths = std::sqrt(dot(one, one)) * std::sqrt(dot(other, other));
    flatness[i] = -dot(one, other) / std::max(lengths, std::numeric_limits<double>::min());
  }
  return flatness;
}

}  // namespace symrecon
