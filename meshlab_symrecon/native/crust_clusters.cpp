#include <algorithm>
#include <numeric>
#include <stdexcept>

#include "crust.hpp"
#include "disjoint_sets.hpp"
#include "memory_pages.hpp"
#include "vectors.hpp"

namespace symrecon {
namespace {

constexpr std::size_t kVerticesPerReport = 1 << 14;

// Joins sets of vertices of a polygon surface, each polygon taken as a fan of triangles.
//
// A set whose triangles form a disc may shrink to a point without changing the surface (a quotient by a
// cell).  What is left are triangles with distinct corners only if the ones with one corner in the set
// leave a ring of distinct vertices, at least three: a vertex met twice would be an edge met twice.
class Clusters {
 public:
  Clusters(View<Position> positions, View<std::int32_t> nearest, View<std::int32_t> offsets,
           View<std::int32_t> corners, View<Position> samples)
      : positions_(positions), nearest_(nearest), offsets_(offsets), corners_(corners), samples_(samples),
        polygons_(positions.size(), Quad{-1, -1, -1, -1}),
        representative_(positions.size()),
        local_(positions.size(), -1),
        after_(positions.size(), -1),
        seen_(offsets.size() - 1, -1),
        base_(offsets.size() - 1) {
    std::iota(representative_.begin(), representative_.end(), 0);
    for (std::size_t polygon = 0; polygon + 1 < offsets.size(); ++polygon)
      for (std::int32_t place = offsets[polygon]; place < offsets[polygon + 1]; ++place) {
        Quad& around = polygons_[corners[place]];
        int slot = 0;
        while (slot < 4 && around[slot] >= 0) ++slot;
        if (slot == 4) throw std::invalid_argument("more than four polygons meet at a corner");
        around[slot] = static_cast<std::int32_t>(polygon);
      }
    choose_bases();
  }

  void join(const Progress& progress);
  SampledSurface surface() const;

 private:
  struct Link {
    std::int32_t start, end;
  };

  // The corner after that at a place, round the polygon.
  std::int32_t after(std::int32_t polygon, std::int32_t place) const {
    return place + 1 == offsets_[polygon + 1] ? offsets_[polygon] : place + 1;
  }
  void choose_bases();
  void meet(const Triangle& face);
  void gather(const std::vector<std::int32_t>& members);
  void join_set(const std::vector<std::int32_t>& members);
  void shrink(const std::vector<std::int32_t>& members);
  bool is_ring();

  View<Position> positions_;
  View<std::int32_t> nearest_, offsets_, corners_;
  View<Position> samples_;
  LargeVector<Quad> polygons_;  // round each vertex: three or four
  LargeVector<std::int32_t> representative_;
  LargeVector<std::int32_t> local_;  // of the vertices of the set at hand: their places in it
  LargeVector<std::int32_t> after_;  // of the vertices round it: the next one
  LargeVector<std::int32_t> seen_;   // the last set that each polygon was met in
  LargeVector<std::int32_t> base_;   // of each polygon: the place of the corner its fan starts from
  std::int32_t sets_ = 0;
  // of the set at hand
  DisjointSets connected_;
  std::vector<std::int32_t> parts_;
  std::vector<Link> links_;
  std::int64_t inner_sides_ = 0, inner_faces_ = 0;
};

// Fans start at a sample, else at the corner nearest to its own.  Which one depends on the surface only, not
// on the order of the corners: of several samples it is the one whose other vertices are the farthest.
void Clusters::choose_bases() {
  LargeVector<float> rank(positions_.size()), spread(samples_.size(), 0.0f);
  for (std::size_t vertex = 0; vertex < rank.size(); ++vertex) {
    const Position gap = minus(positions_[vertex], samples_[nearest_[vertex]]);
    rank[vertex] = static_cast<float>(dot(gap, gap));
    spread[nearest_[vertex]] += rank[vertex];
  }
  for (std::size_t vertex = 0; vertex < rank.size(); ++vertex)
    if (rank[vertex] == 0.0f) rank[vertex] = -spread[nearest_[vertex]];
  for (std::size_t polygon = 0; polygon < base_.size(); ++polygon) {
    base_[polygon] = offsets_[polygon];
    for (std::int32_t place = offsets_[polygon] + 1; place < offsets_[polygon + 1]; ++place)
      if (rank[corners_[place]] < rank[corners_[base_[polygon]]]) base_[polygon] = place;
  }
}

// Take account of a triangle with a corner in the set at hand.
inline void Clusters::meet(const Triangle& face) {
  const Triangle local{local_[face[0]], local_[face[1]], local_[face[2]]};
  const int within = (local[0] >= 0) + (local[1] >= 0) + (local[2] >= 0);
  if (within == 1) {
    const int corner = local[0] >= 0 ? 0 : local[1] >= 0 ? 1 : 2;
    const Link link{representative_[face[(corner + 1) % 3]], representative_[face[(corner + 2) % 3]]};
    if (link.start != link.end) links_.push_back(link);
  } else if (within == 2) {
    ++inner_sides_;
    if (local[0] < 0) connected_.join(local[1], local[2]);
    else connected_.join(local[0], local[1] >= 0 ? local[1] : local[2]);
  } else if (within == 3) {
    inner_sides_ += 3;
    ++inner_faces_;
    connected_.join(local[0], local[1]);
    connected_.join(local[0], local[2]);
  }
}

// Count the triangles and edges inside a set, list the edges opposite to it, and find its connected parts.
void Clusters::gather(const std::vector<std::int32_t>& members) {
  for (std::size_t i = 0; i < members.size(); ++i) local_[members[i]] = static_cast<std::int32_t>(i);
  connected_.reset(members.size());
  links_.clear();
  inner_sides_ = inner_faces_ = 0;
  for (const std::int32_t vertex : members)
    for (const std::int32_t polygon : polygons_[vertex]) {
      if (polygon < 0 || seen_[polygon] == sets_) continue;
      seen_[polygon] = sets_;
      const std::int32_t base = corners_[base_[polygon]];
      std::int32_t place = after(polygon, base_[polygon]), earlier = corners_[place];
      while ((place = after(polygon, place)) != base_[polygon]) {
        const std::int32_t later = corners_[place];
        meet({base, earlier, later});
        earlier = later;
      }
    }
  ++sets_;
  for (const std::int32_t vertex : members) local_[vertex] = -1;
  parts_.clear();
  for (std::size_t i = 0; i < members.size(); ++i)
    if (const auto member = static_cast<std::int32_t>(i); connected_.find(member) == member) parts_.push_back(member);
}

// The vertices at one sample, each connected part for itself.
void Clusters::join_set(const std::vector<std::int32_t>& members) {
  if (members.size() < 2) return;
  gather(members);
  if (parts_.size() == 1) return shrink(members);
  std::vector<std::vector<std::int32_t>> sets(parts_.size());
  for (std::size_t i = 0; i < members.size(); ++i) {
    const std::int32_t part = connected_.find(static_cast<std::int32_t>(i));
    sets[std::lower_bound(parts_.begin(), parts_.end(), part) - parts_.begin()].push_back(members[i]);
  }
  for (const std::vector<std::int32_t>& set : sets) {
    if (set.size() < 2) continue;
    gather(set);
    shrink(set);
  }
}

// Whether the links form one ring of distinct vertices.
bool Clusters::is_ring() {
  if (links_.size() < 3) return false;
  bool distinct = true;
  for (const Link& link : links_) {
    distinct = distinct && after_[link.start] < 0;
    after_[link.start] = link.end;
  }
  std::size_t steps = 0;
  std::int32_t vertex = links_.front().start;
  if (distinct) do {
    vertex = after_[vertex];
    ++steps;
  } while (vertex >= 0 && vertex != links_.front().start && steps <= links_.size());
  for (const Link& link : links_) after_[link.start] = -1;
  return distinct && vertex == links_.front().start && steps == links_.size();
}

// The connected set gathered last becomes one vertex, if it can.
void Clusters::shrink(const std::vector<std::int32_t>& members) {
  const std::int64_t euler = static_cast<std::int64_t>(members.size()) - inner_sides_ / 2 + inner_faces_;
  if (euler != 1 || !is_ring()) return;
  for (const std::int32_t vertex : members) representative_[vertex] = members.front();
}

// The vertices at each sample as linked lists in rising order; sets in the order of their first vertices.
void Clusters::join(const Progress& progress) {
  std::vector<std::int32_t> first(samples_.size(), -1), next(positions_.size(), -1), members;
  for (std::size_t vertex = positions_.size(); vertex-- > 0;)
    if (positions_[vertex] == samples_[nearest_[vertex]]) {
      next[vertex] = first[nearest_[vertex]];
      first[nearest_[vertex]] = static_cast<std::int32_t>(vertex);
    }
  for (std::size_t vertex = 0; vertex < positions_.size(); ++vertex) {
    if (vertex % kVerticesPerReport == 0 && progress) progress(double(vertex) / double(positions_.size()));
    if (first[nearest_[vertex]] != static_cast<std::int32_t>(vertex)) continue;
    members.clear();
    for (std::int32_t member = first[nearest_[vertex]]; member >= 0; member = next[member]) members.push_back(member);
    join_set(members);
  }
}

SampledSurface Clusters::surface() const {
  SampledSurface result;
  std::size_t count = 0;
  for (std::size_t vertex = 0; vertex < positions_.size(); ++vertex)
    count += representative_[vertex] == static_cast<std::int32_t>(vertex);
  result.points.reserve(count);
  result.nearest.reserve(count);
  result.faces.reserve(2 * count + 64);
  LargeVector<std::int32_t> number(positions_.size(), -1);
  const auto numbered = [&](std::int32_t vertex) {
    if (number[vertex] < 0) {
      number[vertex] = static_cast<std::int32_t>(result.points.size());
      result.points.push_back(positions_[vertex]);
      result.nearest.push_back(nearest_[vertex]);
    }
    return number[vertex];
  };
  for (std::int32_t polygon = 0; polygon < static_cast<std::int32_t>(base_.size()); ++polygon) {
    const std::int32_t first = representative_[corners_[base_[polygon]]];
    std::int32_t place = after(polygon, base_[polygon]), b = representative_[corners_[place]];
    while ((place = after(polygon, place)) != base_[polygon]) {
      const std::int32_t c = representative_[corners_[place]];
      if (first != b && b != c && c != first) {
        const std::int32_t one = numbered(first), two = numbered(b), three = numbered(c);
        result.faces.push_back({one, two, three});
      }
      b = c;
    }
  }
  return result;
}

}  // namespace

SampledSurface join_at_samples(View<Position> positions, View<std::int32_t> nearest,
                               View<std::int32_t> offsets, View<std::int32_t> corners,
                               View<Position> samples, const Progress& progress) {
  Clusters clusters(positions, nearest, offsets, corners, samples);
  clusters.join(progress);
  return clusters.surface();
}

}  // namespace symrecon
