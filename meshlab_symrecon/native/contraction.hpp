// The edge contractions of the crust, step by step.
#pragma once

#include <cstdint>
#include <vector>

#include "crust.hpp"
#include "half_edges.hpp"
#include "memory_pages.hpp"
#include "view.hpp"

namespace symrecon {

class Contraction {
 public:
  Contraction(View<Position> points, View<Triangle> faces, View<std::int32_t> nearest, const Samples& samples,
              const Leanness& leanness)
      : points_(points.begin(), points.end()),
        nearest_(nearest),
        samples_(samples),
        leanness_(leanness),
        halves_(faces, points.size()),
        stamps_(points.size(), 0),
        moved_(points.size(), 0.0f) {}

  // Join vertices at one sample where the link condition holds.
  void join_coincident();
  // Contract short edges, and edges of flat places; `progress` is there.
  void thin_out(const Progress& progress);
  // Move vertices at one place a little apart.
  void part_coincident();
  SampledSurface surface() const;

 private:
  struct Spoke {
    double squared;  // length
    Position tip;
    std::int32_t half, vertex;
  };

  std::int32_t count() const { return static_cast<std::int32_t>(points_.size()); }
  bool is_at_sample(std::int32_t vertex) const {
    return points_[vertex] == samples_.positions[nearest_[vertex]];
  }

  void walk(std::int32_t hub);
  bool link_condition(std::int32_t kept) const;
  double shift(std::int32_t hub, const Spoke& kept) const;
  std::int32_t earlier(std::int32_t hub) const;
  bool remove(std::int32_t hub);
  bool join_at(std::int32_t hub);
  void step_aside(std::int32_t vertex);

  LargeVector<Position> points_;
  View<std::int32_t> nearest_;
  Samples samples_;
  Leanness leanness_;
  HalfEdges halves_;
  LargeVector<std::int32_t> stamps_;  // the last walk that met a vertex
  LargeVector<float> moved_;          // how far the surface has moved at a vertex
  LargeVector<float> turn_;           // when a vertex may go, kDone once it has had its turn
  std::int32_t walks_ = 0;
  std::vector<Spoke> spokes_;  // of the last walk
};

}  // namespace symrecon
