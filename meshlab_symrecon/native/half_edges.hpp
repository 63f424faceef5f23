// A closed triangle surface whose edges can be contracted.
#pragma once

#include <cstdint>
#include <stdexcept>
#include <vector>

#include "crust.hpp"
#include "memory_pages.hpp"

namespace symrecon {

// Half-edge 4 f + k runs from corner k of face f to the next corner; its twin runs back.
class HalfEdges {
 public:
  HalfEdges(View<Triangle> faces, std::size_t vertex_count)
      : corners_(4 * faces.size()), twins_(4 * faces.size()), leaving_(vertex_count, -1) {
    for (std::size_t face = 0; face < faces.size(); ++face)
      for (int k = 0; k < 3; ++k) corners_[4 * face + k] = faces[face][k];
    pair();
    require_single_fans();
  }

  std::int32_t size() const { return static_cast<std::int32_t>(corners_.size()); }
  static std::int32_t following(std::int32_t half) { return (half & 3) == 2 ? half - 2 : half + 1; }
  static std::int32_t preceding(std::int32_t half) { return (half & 3) == 0 ? half + 2 : half - 1; }
  std::int32_t end(std::int32_t half) const { return corners_[following(half)]; }

  bool exists(std::int32_t vertex) const { return leaving_[vertex] >= 0; }
  bool is_face(std::int32_t face) const { return corners_[4 * face] >= 0; }
  Triangle face(std::int32_t face) const {
    return {corners_[4 * face], corners_[4 * face + 1], corners_[4 * face + 2]};
  }

  // Half-edges from a vertex, counter-clockwise; the face of each lies between it and the next.
  std::int32_t leaving(std::int32_t vertex) const { return leaving_[vertex]; }
  std::int32_t next_round(std::int32_t half) const { return twins_[preceding(half)]; }

  // Contract a half-edge to its end.  Its ends must share just the two vertices opposite.
  void contract(std::int32_t half) {
    const std::int32_t gone = corners_[half], kept = end(half), back = twins_[half];
    std::int32_t spoke = half;
    do {
      corners_[spoke] = kept;
      spoke = next_round(spoke);
    } while (spoke != half);
    close(half);
    close(back);
    leaving_[gone] = -1;
  }

 private:
  // The two other sides of a dead face become one edge.
  void close(std::int32_t half) {
    const std::int32_t one = twins_[following(half)], other = twins_[preceding(half)];
    twins_[one] = other;
    twins_[other] = one;
    leaving_[corners_[one]] = one;
    leaving_[corners_[other]] = other;
    corners_[half & ~3] = -1;
  }

  // Half-edges without their twin wait in a list at the smaller end.
  void pair() {
    LargeVector<std::int32_t> waiting(leaving_.size(), -1), next(corners_.size());
    LargeVector<std::int32_t>& far = twins_;  // the larger end, until the twin is known
    std::size_t lonely = 0;
    for (std::int32_t half = 0; half < size(); ++half) {
      if ((half & 3) == 3) continue;
      const std::int32_t from = corners_[half], to = end(half);
      leaving_[from] = half;
      const std::int32_t near = from < to ? from : to;
      far[half] = from < to ? to : from;
      std::int32_t* link = &waiting[near];
      while (*link >= 0 && (far[*link] != far[half] || corners_[*link] == from)) link = &next[*link];
      if (*link < 0) {
        next[half] = waiting[near];
        waiting[near] = half;
        ++lonely;
      } else {
        const std::int32_t other = *link;
        *link = next[other];
        twins_[half] = other;
        twins_[other] = half;
        --lonely;
      }
    }
    if (lonely != 0) throw std::invalid_argument("the surface is not closed and oriented");
  }

  // A contraction moves one fan of faces only.
  void require_single_fans() const {
    std::size_t reached = 0;
    for (const std::int32_t first : leaving_) {
      if (first < 0) continue;
      std::int32_t half = first;
      do {
        ++reached;
        half = next_round(half);
      } while (half != first);
    }
    if (4 * reached != 3 * corners_.size()) throw std::invalid_argument("the surface is pinched at a vertex");
  }

  LargeVector<std::int32_t> corners_;  // where each half-edge starts; the first of a dead face is -1
  LargeVector<std::int32_t> twins_;
  LargeVector<std::int32_t> leaving_;  // a half-edge from each vertex, or -1
};

}  // namespace symrecon
