// The pole graph: balls that intersect at less than a right angle, and the two poles of a sample.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "view.hpp"
#include "crust.hpp"
#include "patience.hpp"

namespace symrecon {

// Neighbours of pole i are ends[offsets[i]] .. ends[offsets[i + 1] - 1], in rising order; every edge
// is there from both of its ends.
struct PoleGraph {
  std::vector<std::int64_t> offsets;
  std::vector<std::int32_t> ends;
  std::vector<float> cosines;
};

// Balls and what joins them: cells of their regular triangulation, and samples on their spheres.
struct UsedBalls {
  View<Position> centres;
  View<double> radii;
  View<Quad> samples;       // on each ball; numbers from `sample_count` on are none
  View<std::uint8_t> used;  // whether a ball has a cell in the power diagram
  std::int32_t sample_count;
};

// Join the used balls that share an edge of `cells`, or a sample with one of the `most_partners`
// largest used balls there, where their cosine is positive.
PoleGraph pole_graph(const UsedBalls& balls, View<Quad> cells, View<Quad> neighbours,
                     std::int32_t most_partners, const Progress& progress);

// For each pair of poles of a sample the cosine between the directions to them, turned over: 1 where
// they lie straight across.
std::vector<double> flatness_of_pairs(View<Position> centres, View<std::array<std::int32_t, 2>> pairs,
                                      View<Position> samples, View<std::int32_t> pair_samples);

}  // namespace symrecon
