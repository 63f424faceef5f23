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
// Which offers are new, and which balls are far apart, no branch can foresee: so both are sorted out
// without one.
class LowerEdges {
 public:
  std::vector<std::int64_t> offsets{0};
  std::vector<std::int32_t> ends;
  std::vector<float> cosines;

  // Room for the edges expected is asked for but not touched, so that it costs no memory.
  LowerEdges(const UsedBalls& balls, std::size_t expected)
      : balls_(balls), seen_(balls.radii.size(), -1), row_(balls.radii.size() + 1) {
    offsets.reserve(seen_.size() + 1);
    ends.reserve(expected);
    cosines.reserve(expected);
  }

  void offer(std::int32_t lower, std::int32_t pole) {
    row_[width_] = lower;
    width_ += seen_[lower] != pole;
    seen_[lower] = pole;
  }

  // Keep those of the pole's lower ends whose balls intersect its own deeply enough.
  void close(std::int32_t pole) {
    const Position& centre = balls_.centres[pole];
    const double radius = balls_.radii[pole];
    std::size_t kept = offsets.back();
    ends.resize(kept + width_ + 1);
    cosines.resize(ends.size());
    for (std::size_t k = 0; k < width_; ++k) {
      const Position apart = arm(balls_.centres[row_[k]], centre);
      const double other = balls_.radii[row_[k]];
      const double overlap = radius * radius + other * other - dot(apart, apart);
      const auto cosine = static_cast<float>(std::min(1.0, overlap / (2.0 * radius * other)));
      ends[kept] = row_[k];
      cosines[kept] = cosine;
      kept += cosine > 0.0f;
    }
    width_ = 0;
    ends.resize(kept);
    cosines.resize(kept);
    offsets.push_back(static_cast<std::int64_t>(kept));
  }

 private:
  const UsedBalls& balls_;
  std::vector<std::int32_t> seen_;  // the pole that met this one last
  std::vector<std::int32_t> row_;   // the lower ends of the pole at hand
  std::size_t width_ = 0;
};

// The lower neighbours of each pole in the triangulation.  Of the cells round an edge those tell it that
// have a lower number than the two next to them: at least one, and far fewer than all.
Buckets lower_neighbours(View<Quad> cells, View<Quad> neighbours, std::size_t count) {
  constexpr int edges[6][4] = {{0, 1, 2, 3}, {0, 2, 1, 3}, {0, 3, 1, 2},
                               {1, 2, 0, 3}, {1, 3, 0, 2}, {2, 3, 0, 1}};  // ends, other corners
  return counting_sort(count, [&](auto&& emit) {
    for (std::size_t i = 0; i < cells.size(); ++i) {
      bool higher[4];  // the outside of the hull, -1, counts as higher than all
      for (int k = 0; k < 4; ++k) higher[k] = static_cast<std::uint32_t>(neighbours[i][k]) > i;
      for (const auto& [a, b, c, d] : edges)
        if (higher[c] && higher[d]) {
          const auto [low, high] = std::minmax(cells[i][a], cells[i][b]);
          emit(high, low);
        }
    }
  });
}

Buckets poles_at_samples(const UsedBalls& balls) {
  return counting_sort(balls.sample_count, [&](auto&& emit) {
    for (std::size_t pole = 0; pole < balls.radii.size(); ++pole)
      if (balls.used[pole])
        for (const std::int32_t sample : balls.samples[pole])
          if (sample < balls.sample_count) emit(sample, static_cast<std::int32_t>(pole));
  });
}

// Samples where more balls meet than may all be paired: there only the largest ones are paired with all others.  Which
// ones these are does not depend on their numbers.
class Crowds {
 public:
  Crowds(const UsedBalls& balls, const Buckets& at_sample, std::int32_t most) : most_(most) {
    std::vector<std::int32_t> there;
    for (std::int32_t sample = 0; sample < balls.sample_count; ++sample) {
      const auto first = at_sample.items.begin() + at_sample.offsets[sample];
      const auto last = at_sample.items.begin() + at_sample.offsets[sample + 1];
      if (last - first <= most) continue;
      there.assign(first, last);
      std::nth_element(there.begin(), there.begin() + most, there.end(), [&](std::int32_t a, std::int32_t b) {
        return balls.radii[a] != balls.radii[b] ? balls.radii[a] > balls.radii[b] : balls.centres[a] < balls.centres[b];
      });
      samples_.push_back(sample);
      largest_.insert(largest_.end(), there.begin(), there.begin() + most);
      std::sort(largest_.end() - most, largest_.end());
    }
  }

  // The largest balls at a crowded sample, in rising order; else an empty range.
  View<std::int32_t> largest(std::int32_t sample) const {
    const auto found = std::lower_bound(samples_.begin(), samples_.end(), sample);
    if (found == samples_.end() || *found != sample) return {largest_.data(), 0};
    return {largest_.data() + (found - samples_.begin()) * most_, static_cast<std::size_t>(most_)};
  }

 private:
  std::ptrdiff_t most_;
  std::vector<std::int32_t> samples_, largest_;
};

LowerEdges lower_edges(const UsedBalls& balls, View<Quad> cells, View<Quad> neighbours, std::int32_t most_partners,
                       const Progress& progress) {
  const std::size_t count = balls.radii.size();
  const Buckets at_sample = poles_at_samples(balls);
  const Crowds crowds(balls, at_sample, most_partners);
  const Buckets joined = lower_neighbours(cells, neighbours, count);
  LowerEdges edges(balls, joined.items.size());
  Patience patience(progress, count);
  std::vector<std::int64_t> next(at_sample.offsets);  // place of the pole at hand among a sample's
  for (std::size_t i = 0; i < count; ++i) {
    patience.step();
    const auto pole = static_cast<std::int32_t>(i);
    for (std::int64_t k = joined.offsets[i]; k < joined.offsets[i + 1]; ++k)
      edges.offer(joined.items[k], pole);
    if (balls.used[i])
      for (const std::int32_t sample : balls.samples[i]) {
        if (sample >= balls.sample_count) continue;
        const std::int64_t place = next[sample]++;
        const std::int64_t first = at_sample.offsets[sample];
        const bool crowded = at_sample.offsets[sample + 1] - first > most_partners;
        const View<std::int32_t> largest = crowded ? crowds.largest(sample) : View<std::int32_t>{nullptr, 0};
        if (crowded && !std::binary_search(largest.begin(), largest.end(), pole)) {
          for (const std::int32_t partner : largest)
            if (partner < pole) edges.offer(partner, pole);
        } else {
          for (std::int64_t k = first; k < place; ++k) edges.offer(at_sample.items[k], pole);
        }
      }
    edges.close(pole);
  }
  return edges;
}

// Every edge from both ends.  Poles are visited in rising order, first for their edges to higher ones
// and then for those to lower ones, so that every row is in order without being sorted.
PoleGraph both_ways(const LowerEdges& lower) {
  const std::size_t count = lower.offsets.size() - 1;
  PoleGraph graph;
  graph.offsets.assign(count + 1, 0);
  for (std::size_t i = 0; i < count; ++i) graph.offsets[i + 1] = lower.offsets[i + 1] - lower.offsets[i];
  for (const std::int32_t end : lower.ends) ++graph.offsets[end + 1];
  std::partial_sum(graph.offsets.begin(), graph.offsets.end(), graph.offsets.begin());
  graph.ends.resize(graph.offsets.back());
  graph.cosines.resize(graph.offsets.back());
  const auto put = [&](std::int64_t place, std::size_t end, float cosine) {
    graph.ends[place] = static_cast<std::int32_t>(end);
    graph.cosines[place] = cosine;
  };
  std::vector<std::int64_t> higher(count), next(graph.offsets.begin(), graph.offsets.end() - 1);
  for (std::size_t i = 0; i < count; ++i)
    higher[i] = graph.offsets[i] + lower.offsets[i + 1] - lower.offsets[i];
  std::vector<std::int64_t> filled(higher);
  for (std::size_t i = 0; i < count; ++i)
    for (std::int64_t k = lower.offsets[i]; k < lower.offsets[i + 1]; ++k)
      put(filled[lower.ends[k]]++, i, lower.cosines[k]);
  for (std::size_t i = 0; i < count; ++i)
    for (std::int64_t k = higher[i]; k < graph.offsets[i + 1]; ++k)
      put(next[graph.ends[k]]++, i, graph.cosines[k]);
  return graph;
}

}  // namespace

PoleGraph pole_graph(const UsedBalls& balls, View<Quad> cells, View<Quad> neighbours,
                     std::int32_t most_partners, const Progress& progress) {
  return both_ways(lower_edges(balls, cells, neighbours, most_partners, progress));
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
