#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>

#include "crust.hpp"

namespace symrecon {
namespace {

Position minus(const Position& a, const Position& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }

Position cross(const Position& a, const Position& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

double dot(const Position& a, const Position& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

// Faces round each vertex as linked lists of corners: corner 3 f + k is vertex k of face f.
// Joining two vertices joins their lists in constant time; dead faces are passed over.
class Surface {
 public:
  Surface(std::vector<Position> points, std::vector<Triangle> faces)
      : points_(std::move(points)),
        faces_(std::move(faces)),
        alive_(faces_.size(), 1),
        next_(3 * faces_.size(), -1),
        head_(points_.size(), -1),
        tail_(points_.size(), -1),
        parent_(points_.size()) {
    std::iota(parent_.begin(), parent_.end(), 0);
    for (std::int32_t corner = 0; corner < static_cast<std::int32_t>(next_.size()); ++corner) {
      const std::int32_t vertex = faces_[corner / 3][corner % 3];
      (head_[vertex] < 0 ? head_[vertex] : next_[tail_[vertex]]) = corner;
      tail_[vertex] = corner;
    }
  }

  std::int32_t find(std::int32_t vertex) {
    while (parent_[vertex] != vertex) vertex = parent_[vertex] = parent_[parent_[vertex]];
    return vertex;
  }

  const Position& point(std::int32_t vertex) const { return points_[vertex]; }
  double length(std::int32_t start, std::int32_t end) const {
    const Position side = minus(points_[start], points_[end]);
    return std::sqrt(dot(side, side));
  }
  const std::vector<Triangle>& faces() const { return faces_; }
  bool alive(std::size_t face) const { return alive_[face]; }

  bool coincide(std::int32_t a, std::int32_t b) const { return points_[a] == points_[b]; }

  // Move a vertex part of the way to the mean of its neighbours.
  void relax(std::int32_t vertex, double step) {
    gather(vertex, faces_gone_, ring_gone_);
    for (int axis = 0; axis < 3; ++axis) {
      double sum = 0.0;
      for (const std::int32_t other : ring_gone_) sum += points_[other][axis];
      points_[vertex][axis] += step * (sum / static_cast<double>(ring_gone_.size()) - points_[vertex][axis]);
    }
  }

  // Contract the edge (gone, kept) to `place`; false when that would pinch or turn the surface.
  bool contract(std::int32_t gone, std::int32_t kept, const Position& place, bool keep_facing) {
    gather(gone, faces_gone_, ring_gone_);
    gather(kept, faces_kept_, ring_kept_);
    if (!link_condition(gone, kept)) return false;
    if (keep_facing && (turns(faces_gone_, gone, kept, place) || turns(faces_kept_, kept, gone, place)))
      return false;
    for (const std::int32_t face : faces_gone_) {
      Triangle& corners = faces_[face];
      if (has(corners, kept)) {
        alive_[face] = 0;
      } else {
        std::replace(corners.begin(), corners.end(), gone, kept);
      }
    }
    next_[tail_[kept]] = head_[gone];
    tail_[kept] = tail_[gone];
    head_[gone] = -1;
    parent_[gone] = kept;
    points_[kept] = place;
    prune(kept);
    return true;
  }

 private:
  static bool has(const Triangle& corners, std::int32_t vertex) {
    return corners[0] == vertex || corners[1] == vertex || corners[2] == vertex;
  }

  // The living faces at a vertex, and its neighbours in rising order.
  void gather(std::int32_t vertex, std::vector<std::int32_t>& faces, std::vector<std::int32_t>& ring) {
    faces.clear();
    ring.clear();
    for (std::int32_t corner = head_[vertex]; corner >= 0; corner = next_[corner]) {
      const std::int32_t face = corner / 3;
      if (!alive_[face]) continue;
      faces.push_back(face);
      for (const std::int32_t other : faces_[face])
        if (other != vertex) ring.push_back(other);
    }
    std::sort(ring.begin(), ring.end());
    ring.erase(std::unique(ring.begin(), ring.end()), ring.end());
  }

  // Two ends may share exactly the two vertices opposite their edge; a tetrahedron stays as it is.
  bool link_condition(std::int32_t gone, std::int32_t kept) const {
    if (!std::binary_search(ring_gone_.begin(), ring_gone_.end(), kept)) return false;
    if (ring_gone_.size() == 3 && ring_kept_.size() == 3) return false;
    std::size_t shared = 0;
    for (const std::int32_t vertex : ring_gone_)
      shared += std::binary_search(ring_kept_.begin(), ring_kept_.end(), vertex);
    (void)gone;
    return shared == 2;
  }

  // Whether a face at `moved` that survives would face away from where it faced.
  bool turns(const std::vector<std::int32_t>& faces, std::int32_t moved, std::int32_t other,
             const Position& place) const {
    for (const std::int32_t face : faces) {
      const Triangle& corners = faces_[face];
      if (has(corners, other)) continue;
      Position now[3], then[3];
      for (int k = 0; k < 3; ++k) {
        now[k] = points_[corners[k]];
        then[k] = corners[k] == moved ? place : now[k];
      }
      const Position before = cross(minus(now[1], now[0]), minus(now[2], now[0]));
      const Position after = cross(minus(then[1], then[0]), minus(then[2], then[0]));
      constexpr double kSteepest = 0.2;  // cosine: a face may turn by 78 degrees at the most
      if (dot(before, after) < kSteepest * std::sqrt(dot(before, before) * dot(after, after)) ||
          dot(after, after) == 0.0)
        return true;
    }
    return false;
  }

  // Drop dead corners from a list, so that lists stay short.
  void prune(std::int32_t vertex) {
    std::int32_t* link = &head_[vertex];
    std::int32_t last = -1;
    for (std::int32_t corner = *link; corner >= 0; corner = next_[corner]) {
      if (!alive_[corner / 3]) continue;
      *link = corner;
      link = &next_[corner];
      last = corner;
    }
    *link = -1;
    tail_[vertex] = last;
  }

  std::vector<Position> points_;
  std::vector<Triangle> faces_;
  std::vector<std::uint8_t> alive_;
  std::vector<std::int32_t> next_, head_, tail_, parent_;
  std::vector<std::int32_t> faces_gone_, faces_kept_, ring_gone_, ring_kept_;
};

struct Edge {
  double length;
  std::int32_t start, end;
};

bool before(const Edge& a, const Edge& b) {
  if (a.length != b.length) return a.length < b.length;
  return a.start != b.start ? a.start < b.start : a.end < b.end;
}

// The living edges that `wanted(start, end)` picks, each once.
template <class Wanted>
std::vector<Edge> living_edges(const Surface& surface, Wanted&& wanted) {
  std::vector<Edge> edges;
  for (std::size_t face = 0; face < surface.faces().size(); ++face) {
    if (!surface.alive(face)) continue;
    const Triangle& corners = surface.faces()[face];
    for (int k = 0; k < 3; ++k) {
      const std::int32_t start = corners[k], end = corners[(k + 1) % 3];
      // the face on the other side has the edge the other way round
      if (start < end && wanted(start, end)) edges.push_back({surface.length(start, end), start, end});
    }
  }
  return edges;
}

void contract_to_anchors(Surface& surface, const std::vector<std::int32_t>& anchor,
                         const std::vector<Position>& anchor_points) {
  std::vector<Edge> edges = living_edges(surface, [&](std::int32_t start, std::int32_t end) {
    return anchor[start] >= 0 && anchor[start] == anchor[end];
  });
  // An edge that is refused may be free once its neighbours are gone.
  for (std::size_t before = edges.size() + 1; edges.size() < before;) {
    before = edges.size();
    edges.erase(std::remove_if(edges.begin(), edges.end(),
                               [&](const Edge& edge) {
                                 const std::int32_t start = surface.find(edge.start);
                                 const std::int32_t end = surface.find(edge.end);
                                 return start == end ||
                                        surface.contract(end, start, anchor_points[anchor[start]], false);
                               }),
                edges.end());
  }
}

std::int64_t contract_short(Surface& surface, const std::vector<std::int32_t>& anchor,
                            const std::vector<double>& shortest) {
  constexpr int kRounds = 4;  // later rounds meet edges that earlier ones made short
  std::int64_t refused = 0;
  for (int round = 0; round < kRounds; ++round) {
    std::vector<Edge> edges = living_edges(surface, [&](std::int32_t start, std::int32_t end) {
      return surface.length(start, end) < std::min(shortest[start], shortest[end]);
    });
    std::sort(edges.begin(), edges.end(), before);
    std::int64_t contracted = 0;
    refused = 0;
    for (const Edge& edge : edges) {
      std::int32_t start = surface.find(edge.start), end = surface.find(edge.end);
      if (start == end) continue;
      if (anchor[end] >= 0 && anchor[start] < 0) std::swap(start, end);  // samples stay in place
      Position place = surface.point(start);
      if (anchor[start] < 0)
        for (int axis = 0; axis < 3; ++axis)
          place[axis] = 0.5 * (surface.point(start)[axis] + surface.point(end)[axis]);
      const bool both = anchor[start] >= 0 && anchor[end] >= 0;
      (!both && surface.contract(end, start, place, true) ? contracted : refused) += 1;
    }
    if (contracted == 0) break;
  }
  return refused;
}

// Vertices of one anchor that could not be joined lie at one point; move all but the first a little
// towards their neighbours, so that no reader joins them and pinches the surface.
void part_coincident(Surface& surface, const std::vector<std::int32_t>& anchor, std::size_t anchors) {
  constexpr double kStep = 0.01;  // of the way to the neighbours' mean
  std::vector<std::int32_t> first(anchors, -1);
  for (std::size_t face = 0; face < surface.faces().size(); ++face) {
    if (!surface.alive(face)) continue;
    for (const std::int32_t vertex : surface.faces()[face]) {
      if (anchor[vertex] < 0) continue;
      std::int32_t& keeper = first[anchor[vertex]];
      if (keeper < 0) keeper = vertex;
      if (keeper != vertex && surface.coincide(keeper, vertex)) surface.relax(vertex, kStep);
    }
  }
}

}  // namespace

Contraction contract_edges(std::vector<Position> points, std::vector<Triangle> faces,
                           const std::vector<std::int32_t>& anchor,
                           const std::vector<Position>& anchor_points,
                           const std::vector<double>& shortest) {
  const std::size_t count = points.size();
  Surface surface(std::move(points), std::move(faces));
  contract_to_anchors(surface, anchor, anchor_points);
  Contraction result;
  result.refused = contract_short(surface, anchor, shortest);
  part_coincident(surface, anchor, anchor_points.size());
  std::vector<std::int32_t> number(count, -1);
  for (std::size_t face = 0; face < surface.faces().size(); ++face) {
    if (!surface.alive(face)) continue;
    Triangle corners = surface.faces()[face];
    for (std::int32_t& corner : corners) {
      if (number[corner] < 0) {
        number[corner] = static_cast<std::int32_t>(result.points.size());
        result.points.push_back(surface.point(corner));
        result.origin.push_back(corner);
      }
      corner = number[corner];
    }
    result.faces.push_back(corners);
  }
  return result;
}

}  // namespace symrecon
