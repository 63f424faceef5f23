#include "contraction.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "vectors.hpp"

namespace symrecon {
namespace {

constexpr std::int32_t kVerticesPerReport = 1 << 14;
constexpr double kSteepest = 0.2;    // cosine: a face may turn by 78 degrees at the most
constexpr double kReach = 2.0;       // spacings: longer edges are not contracted
constexpr int kTries = 2;            // edges tried at a vertex, the shortest first
constexpr int kRounds = 2;           // of asking neighbours for their nearest samples
constexpr double kPaired = 0.15, kJoined = 0.2, kThinned = 0.75, kParted = 0.8, kNumbered = 0.9;  // shares of the time
constexpr float kDone = std::numeric_limits<float>::infinity();
constexpr double kTurned = std::numeric_limits<double>::infinity();

// Let vertices try the samples of their neighbours.
void settle_nearest(SampledSurface& surface, const Samples& samples) {
  std::vector<double> squared(surface.points.size());
  const auto gap = [&](std::int32_t vertex, std::int32_t sample) {
    const Position side = minus(surface.points[vertex], samples.positions[sample]);
    return dot(side, side);
  };
  for (std::size_t vertex = 0; vertex < squared.size(); ++vertex)
    squared[vertex] = gap(static_cast<std::int32_t>(vertex), surface.nearest[vertex]);
  for (int round = 0; round < kRounds; ++round)
    for (const Triangle& face : surface.faces)
      for (int k = 0; k < 3; ++k) {
        const std::int32_t vertex = face[k], sample = surface.nearest[face[(k + 1) % 3]];
        if (squared[vertex] == 0.0 || sample == surface.nearest[vertex]) continue;
        const double other = gap(vertex, sample);
        if (other > squared[vertex] || (other == squared[vertex] && sample > surface.nearest[vertex])) continue;
        squared[vertex] = other;
        surface.nearest[vertex] = sample;
      }
}

}  // namespace

// List the edges at a vertex in turn.
void Contraction::walk(std::int32_t hub) {
  spokes_.clear();
  ++walks_;
  const std::int32_t first = halves_.leaving(hub);
  std::int32_t half = first;
  do {
    const std::int32_t vertex = halves_.end(half);
    const Position side = minus(points_[vertex], points_[hub]);
    spokes_.push_back({dot(side, side), points_[vertex], half, vertex});
    stamps_[vertex] = walks_;
    half = halves_.next_round(half);
  } while (half != first);
}

// A vertex (walked last) and a neighbour may share exactly the two vertices opposite their edge; a
// tetrahedron stays as it is.
bool Contraction::link_condition(std::int32_t kept) const {
  int shared = 0, degree = 0;
  const std::int32_t first = halves_.leaving(kept);
  std::int32_t half = first;
  do {
    shared += stamps_[halves_.end(half)] == walks_;
    ++degree;
    half = halves_.next_round(half);
  } while (half != first && shared <= 2);
  return shared == 2 && (degree > 3 || spokes_.size() > 3);
}

// How far a vertex (walked last) lies off the planes of its faces once it has gone to a neighbour;
// infinite when a face would turn over.
double Contraction::shift(std::int32_t hub, const Spoke& kept) const {
  if (kept.squared == 0.0) return 0.0;
  const Position& start = points_[hub];
  const Position way = minus(start, kept.tip);
  double most = 0.0;
  for (std::size_t i = 0; i < spokes_.size(); ++i) {
    const Spoke& a = spokes_[i];
    const Spoke& b = spokes_[i + 1 < spokes_.size() ? i + 1 : 0];
    if (a.vertex == kept.vertex || b.vertex == kept.vertex) continue;
    const Position side = minus(b.tip, a.tip);
    const Position before = cross(minus(a.tip, start), side), after = cross(minus(a.tip, kept.tip), side);
    const double size = dot(after, after), along = dot(before, after);
    if (!(size > 0.0) || along < 0.0 || along * along < kSteepest * kSteepest * dot(before, before) * size)
      return kTurned;
    const double height = dot(after, way);
    if (height * height > most * size) most = height * height / size;
  }
  return std::sqrt(most);
}

// Contract one edge at a vertex to its other end, if that is short or leaves the surface in place.
bool Contraction::remove(std::int32_t hub) {
  walk(hub);
  const double spacing = samples_.spacing[nearest_[hub]];
  const double reach = kReach * spacing, weld = leanness_.weld * spacing, flat = leanness_.flat * spacing;
  double tried = -1.0;  // length of the edge tried last
  for (int attempt = 0; attempt < kTries; ++attempt) {
    const Spoke* kept = nullptr;
    for (const Spoke& spoke : spokes_)
      if (spoke.squared > tried && (kept == nullptr || spoke.squared < kept->squared)) kept = &spoke;
    if (kept == nullptr || !(kept->squared < reach * reach)) return false;
    tried = kept->squared;
    const float moved = moved_[hub] + static_cast<float>(shift(hub, *kept));
    if (!(moved <= (tried < weld * weld ? weld : flat)) || !link_condition(kept->vertex)) continue;
    moved_[kept->vertex] = std::max(moved_[kept->vertex], moved);
    halves_.contract(kept->half);
    return true;
  }
  return false;
}

// The neighbour whose turn comes first, if that is before the hub's; else -1.
std::int32_t Contraction::earlier(std::int32_t hub) const {
  std::int32_t earliest = hub;
  float turn = turn_[hub];
  const std::int32_t first = halves_.leaving(hub);
  std::int32_t half = first;
  do {
    const std::int32_t vertex = halves_.end(half);
    const float other = turn_[vertex];
    if (other < turn || (other == turn && vertex < earliest)) {
      earliest = vertex;
      turn = other;
    }
    half = halves_.next_round(half);
  } while (half != first);
  return earliest == hub ? -1 : earliest;
}

// Vertices go in the order of their distance from their sample, in spacings, as far as neighbours see:
// the result depends on the surface only, not on the order of its vertices, and memory is read in order.
void Contraction::thin_out(const Progress& progress) {
  turn_.assign(points_.size(), kDone);
  for (std::int32_t vertex = 0; vertex < count(); ++vertex) {
    if (!halves_.exists(vertex) || is_at_sample(vertex)) continue;
    const Position gap = minus(points_[vertex], samples_.positions[nearest_[vertex]]);
    const double spacing = samples_.spacing[nearest_[vertex]];
    turn_[vertex] = static_cast<float>(dot(gap, gap) / (spacing * spacing));
  }
  std::vector<std::int32_t> waiting;
  for (std::int32_t vertex = 0; vertex < count(); ++vertex) {
    if (vertex % kVerticesPerReport == 0) progress(double(vertex) / double(count()));
    if (turn_[vertex] == kDone) continue;
    waiting.push_back(vertex);
    while (!waiting.empty()) {
      const std::int32_t hub = waiting.back();
      const std::int32_t first = earlier(hub);
      if (first >= 0) {
        waiting.push_back(first);
        continue;
      }
      waiting.pop_back();
      turn_[hub] = kDone;
      remove(hub);
    }
  }
}

SampledSurface Contraction::surface() const {
  SampledSurface result;
  std::size_t vertices = 0, faces = 0;
  for (std::int32_t vertex = 0; vertex < count(); ++vertex) vertices += halves_.exists(vertex);
  for (std::int32_t face = 0; face < halves_.size() / 4; ++face) faces += halves_.is_face(face);
  result.points.reserve(vertices);
  result.nearest.reserve(vertices);
  result.faces.reserve(faces);
  LargeVector<std::int32_t> number(points_.size(), -1);
  for (std::int32_t face = 0; face < halves_.size() / 4; ++face) {
    if (!halves_.is_face(face)) continue;
    Triangle corners = halves_.face(face);
    for (std::int32_t& corner : corners) {
      if (number[corner] < 0) {
        number[corner] = static_cast<std::int32_t>(result.points.size());
        result.points.push_back(points_[corner]);
        result.nearest.push_back(nearest_[corner]);
      }
      corner = number[corner];
    }
    result.faces.push_back(corners);
  }
  return result;
}

SampledSurface contract_edges(View<Position> points, View<Triangle> faces, View<std::int32_t> nearest,
                              const Samples& samples, const Leanness& leanness, const Progress& progress) {
  const Progress report = [&](double share) {
    if (progress) progress(share);
  };
  Contraction contraction(points, faces, nearest, samples, leanness);
  report(kPaired);
  contraction.join_coincident();
  report(kJoined);
  contraction.thin_out([&](double share) { report(kJoined + (kThinned - kJoined) * share); });
  report(kThinned);
  contraction.part_coincident();
  report(kParted);
  SampledSurface result = contraction.surface();
  report(kNumbered);
  settle_nearest(result, samples);
  return result;
}

}  // namespace symrecon
