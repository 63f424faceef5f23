// A weighted point: a ball of squared radius `weight`, or a plain point with weight zero.
#pragma once

namespace symrecon {

// Aligned so that no site straddles two cache lines.
struct alignas(32) Site {
  double x, y, z, weight;
};

// Lexicographic order of positions: the rank that breaks ties, independent of the order of the input.
inline bool before(const Site& a, const Site& b) {
  if (a.x != b.x) return a.x < b.x;
  if (a.y != b.y) return a.y < b.y;
  return a.z < b.z;
}

inline bool same_position(const Site& a, const Site& b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

}  // namespace symrecon
