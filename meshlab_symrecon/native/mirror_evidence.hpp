// What the mirror image of a cloud confirms of a plane, and what nothing can excuse.
#pragma once

#include <cstdint>
#include <vector>

#include "mirror_cloud.hpp"
#include "view.hpp"

namespace symrecon {

// Lengths in the units of the cloud; the Python module `verification` gives the numbers and their reasons.
struct EvidenceRules {
  double tolerance;       // distance from the tangent plane at which a match is worth exp(-1/2)
  double no_direction;    // cosine of normals up to which there is no match,
  double full_direction;  // and from which on it counts fully
  double sideways;        // a partner farther along the surface than that is none
  double near_plane;      // points nearer to the plane count less
  double no_match;        // worth of a match below which a rim may excuse it
  double rim_reach;       // a rim nearer than this multiple of the distance to the surface excuses it,
  double least_gap;       // if that distance is at least so large
  double far;             // distance off the surface from which on it is a contradiction
  double beyond;          // and from which on nothing can be said
  Plane broken_off;       // what lies below this plane is known to be missing; no normal: nothing is
};

struct Evidence {
  double support;        // share of the queries whose mirror image lies on the surface
  double agreement;      // the same share of the queries that no hole excuses
  double contradiction;  // share that lies far off the surface, no hole to explain it
  double residual;       // RMS distance of partners from the tangent plane
};

// Mirrors the points `queries` across each plane. `distinctness` weighs contradictions, one number a query.
std::vector<Evidence> examine(View<Plane> planes, const MirrorCloud& cloud, View<std::int32_t> queries,
                              View<double> distinctness, const EvidenceRules& rules);

// Where the mirror image of each query falls, a row of queries a plane.
struct Landings {
  std::vector<std::int32_t> partners;  // points of the cloud
  std::vector<double> weights;         // of the queries: those near the plane count less
  std::vector<double> distances;       // to the partners
  std::vector<double> cosines;         // between the normals, |cosine| where a side is not known
  std::vector<double> worth;           // of the matches, 0 to 1
  std::vector<std::uint8_t> excused;   // 1: the image may have fallen into a hole, 2: it is broken off
};

Landings landings(View<Plane> planes, const MirrorCloud& cloud, View<std::int32_t> queries, const EvidenceRules& rules);

}  // namespace symrecon
