// The exact signs that the triangulation is built on.
//
//   orientation(a, b, c, d)     sign of det[b - a, c - a, d - a]: +1 when the cell a b c d is positively oriented
//   power_test(a, b, c, d, e)   for a positive cell: +1 when e has negative power to its orthosphere ("in conflict"),
//                               that is, when the lifted e = (p, |p|^2 - w) lies below the lifted cell
//   perturbed_power_test        the same, never 0 for a positive cell and five different positions
//
// Three stages: plain doubles with a certified bound, double-doubles with a certified bound, integers.
// The bounds are absolute errors relative to the permanent (the determinant's formula with every term made positive).
//
// Both determinants are evaluated on differences to the last argument. Writing u = 2^-53, count the roundings (factors
// 1 + delta, |delta| <= u) that any one term of the expanded determinant passes through:
//   difference 1; minor xy: 2 differences, product 1, difference of products 1                         ->  4
//   minor xyz: minor xy 4, difference 1, product 1, two additions 2                                    ->  8
//   lift x^2 + y^2 + z^2 - dw: 2 differences, square 1, three additions 3                              ->  6
//   power test: minor xyz 8, lift 6, product 1, two additions 2                                        -> 17
// so the orientation is off by at most ((1 + u)^8 - 1) P and the power test by ((1 + u)^17 - 1) P with the exact
// permanent P. The computed bounds P' of the permanents pass through fewer than 18 roundings, hence P <= P' (1 + 19 u),
// and 10 u and 20 u bound both effects and the rounding of the bound itself. For the power test P' is 24 terms times the
// largest |x|, |y|, |z| and lift: coarser than the permanent but half the work, and what it leaves undecided is rare.
// The fine stages carry the error of every operation along. The orientation uses double-doubles (double_double.hpp): the
// differences are exact, a product costs 8 u^2 and a sum 8 u^2, so
//   minor xy 16, minor xyz 16 + 8 + 16 = 40 u^2; 64 u^2 leaves room for the permanent.
// The power test, the one that fails the first stage eight times per pole, uses cheaper pairs in four lanes
// (paired_lanes.hpp): 253 u^2, as counted in fine_stage.cpp; 256 u^2 leaves room for the permanent and terms in u^3.
// Underflow: one product may lose up to 2^-1074, multiplied later by at most a lift and a difference. Margins::safe
// states the size of input for which the margins below cover all of them; larger input has infinite margins, so that
// every sign comes from the integers. Input within the margins cannot overflow.
#pragma once

#include <cmath>
#include <limits>

#include "site.hpp"

namespace symrecon {

constexpr int undecided = 2;

// Absolute errors by underflow, which no bound relative to a permanent covers.
struct Margins {
  double orientation;
  double power;

  // Differences at most 2^101, differences of weights at most 2^202: an underflow of 2^-1074 in a minor grows by at most
  // 2^101 (orientation) or 2^101 * 2^204 (power), one in a lift by a minor of at most 2^306; the underflows of all
  // products and of their errors, a few hundred, by 2^9 more.
  static Margins safe() { return {std::ldexp(1.0, -900), std::ldexp(1.0, -700)}; }
  static Margins never() {
    return {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  }
};

constexpr double unit_roundoff = 1.1102230246251565e-16;  // 2^-53
constexpr double orientation_bound = 10 * unit_roundoff;
constexpr double power_bound = 20 * unit_roundoff;
constexpr double fine_orientation_bound = 64 * unit_roundoff * unit_roundoff;
constexpr double fine_power_bound = 256 * unit_roundoff * unit_roundoff;

inline int certified_sign(double value, double bound) {
  // one branch that is nearly always taken; the sign itself, hard to predict, needs none
  if (std::fabs(value) > bound) return int(value > 0.0) - int(value < 0.0);
  return undecided;
}

inline double largest(double a, double b, double c, double d) {
  const double ab = a > b ? a : b, cd = c > d ? c : d;
  return ab > cd ? ab : cd;
}

// Stage 1. `permanent`, an upper bound of it, is handed on to stage 2.
inline int filtered_orientation(const Site& a, const Site& b, const Site& c, const Site& d, double margin,
                                double& permanent) {
  const double ax = a.x - d.x, ay = a.y - d.y, az = a.z - d.z;
  const double bx = b.x - d.x, by = b.y - d.y, bz = b.z - d.z;
  const double cx = c.x - d.x, cy = c.y - d.y, cz = c.z - d.z;
  const double bxcy = bx * cy, cxby = cx * by, cxay = cx * ay, axcy = ax * cy, axby = ax * by, bxay = bx * ay;
  // relative to d the determinant changes its sign
  const double determinant = az * (cxby - bxcy) + bz * (axcy - cxay) + cz * (bxay - axby);
  permanent = std::fabs(az) * (std::fabs(bxcy) + std::fabs(cxby)) + std::fabs(bz) * (std::fabs(cxay) + std::fabs(axcy)) +
              std::fabs(cz) * (std::fabs(axby) + std::fabs(bxay));
  return certified_sign(determinant, orientation_bound * permanent + margin);
}

inline int filtered_power_test(const Site& a, const Site& b, const Site& c, const Site& d, const Site& e, double margin,
                               double& permanent) {
  const double ax = a.x - e.x, ay = a.y - e.y, az = a.z - e.z, aw = a.weight - e.weight;
  const double bx = b.x - e.x, by = b.y - e.y, bz = b.z - e.z, bw = b.weight - e.weight;
  const double cx = c.x - e.x, cy = c.y - e.y, cz = c.z - e.z, cw = c.weight - e.weight;
  const double dx = d.x - e.x, dy = d.y - e.y, dz = d.z - e.z, dw = d.weight - e.weight;
  const double ab = ax * by - bx * ay, bc = bx * cy - cx * by, cd = cx * dy - dx * cy;
  const double da = dx * ay - ax * dy, ac = ax * cy - cx * ay, bd = bx * dy - dx * by;
  const double a2 = ax * ax + ay * ay + az * az, b2 = bx * bx + by * by + bz * bz;
  const double c2 = cx * cx + cy * cy + cz * cz, d2 = dx * dx + dy * dy + dz * dz;
  const double determinant = ((a2 - aw) * (bz * cd - cz * bd + dz * bc) - (b2 - bw) * (cz * da + dz * ac + az * cd)) +
                             ((c2 - cw) * (dz * ab + az * bd + bz * da) - (d2 - dw) * (az * bc - bz * ac + cz * ab));
  const double x = largest(std::fabs(ax), std::fabs(bx), std::fabs(cx), std::fabs(dx));
  const double y = largest(std::fabs(ay), std::fabs(by), std::fabs(cy), std::fabs(dy));
  const double z = largest(std::fabs(az), std::fabs(bz), std::fabs(cz), std::fabs(dz));
  const double lift =
      largest(a2 + std::fabs(aw), b2 + std::fabs(bw), c2 + std::fabs(cw), d2 + std::fabs(dw));
  permanent = 24.0 * (x * y) * (z * lift);
  return certified_sign(determinant, power_bound * permanent + margin);
}

// Stage 2.
int fine_orientation(const Site& a, const Site& b, const Site& c, const Site& d, double bound);
int fine_power_test(const Site& a, const Site& b, const Site& c, const Site& d, const Site& e, double bound);

// What the fine power test takes the sign of, with the errors of products by fused multiply-add or by splitting: the
// same to the last bit. `fused` only where the machine has it.
double fine_power_determinant(const Site& a, const Site& b, const Site& c, const Site& d, const Site& e, bool fused);
bool has_fma();

// Stage 3.
int exact_orientation(const Site& a, const Site& b, const Site& c, const Site& d);
int exact_power_test(const Site& a, const Site& b, const Site& c, const Site& d, const Site& e);

// Stages 2 and 3 in turn.
int unfiltered_orientation(const Site& a, const Site& b, const Site& c, const Site& d, double permanent,
                           const Margins& margins);
int unfiltered_power_test(const Site& a, const Site& b, const Site& c, const Site& d, const Site& e, double permanent,
                          const Margins& margins);

inline int orientation(const Site& a, const Site& b, const Site& c, const Site& d, const Margins& margins) {
  double permanent;
  const int sign = filtered_orientation(a, b, c, d, margins.orientation, permanent);
  return sign != undecided ? sign : unfiltered_orientation(a, b, c, d, permanent, margins);
}

inline int power_test(const Site& a, const Site& b, const Site& c, const Site& d, const Site& e,
                      const Margins& margins) {
  double permanent;
  const int sign = filtered_power_test(a, b, c, d, e, margins.power, permanent);
  return sign != undecided ? sign : unfiltered_power_test(a, b, c, d, e, permanent, margins);
}

// The sign after an infinitesimal growth of the weights, w_i + epsilon^rank(i), rank = lexicographic order of the
// positions (Devillers and Teillaud, "Perturbations and vertex removal in a 3D Delaunay triangulation", SODA 2003).
int perturbation_sign(const Site& a, const Site& b, const Site& c, const Site& d, const Site& e,
                      const Margins& margins);

inline int perturbed_power_test(const Site& a, const Site& b, const Site& c, const Site& d, const Site& e,
                                const Margins& margins) {
  const int sign = power_test(a, b, c, d, e, margins);
  return sign != 0 ? sign : perturbation_sign(a, b, c, d, e, margins);
}

// True when three positions lie on one line.
bool collinear(const Site& a, const Site& b, const Site& c);

}  // namespace symrecon
