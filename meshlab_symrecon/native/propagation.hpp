// Labels that travel through the pole graph, the most certain first (Amenta, Choi, Kolluri 2001,
// section 4).
#pragma once

#include <cstdint>
#include <vector>

#include "network.hpp"
#include "opposite_poles.hpp"
#include "patience.hpp"

namespace symrecon {

enum PoleLabel : std::uint8_t { unlabelled, outer_pole, inner_pole };

// Intersecting balls offer each other their own label, opposite poles the other one.
struct Evidence {
  const Network& intersections;    // lengths are minus the logarithms of the cosines
  const OppositePoles& opposites;  // values are the flatness of the angle between the two
};

struct Thresholds {
  double offered;   // least cosine with which a ball offers its label
  double accepted;  // least cosine with which a ball that was offered none takes one
};

// The label of each pole; `seeds` are outer ones.  Of equally certain poles the largest ball comes first.
std::vector<std::uint8_t> propagate_labels(const Evidence& evidence, View<double> radii, View<std::uint8_t> seeds,
                                           const Thresholds& thresholds, const Progress& progress);

}  // namespace symrecon
