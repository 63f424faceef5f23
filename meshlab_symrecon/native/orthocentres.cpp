#include "orthocentres.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "double_double.hpp"
#include "exact_frame.hpp"
#include "predicates.hpp"

namespace symrecon {

namespace {

// Accuracy asked of the offset u, relative to its length.
constexpr double plain_accuracy = 1e-12;
constexpr double fine_accuracy = 1e-16;  // what is left is the rounding of the quotient

// Cramer's rule: u = numerator / (2 determinant).
template <class Number>
struct Quotient {
  Number x, y, z, determinant;
};

template <class Number>
struct Arm {  // from the first site to another one
  Number x, y, z, lift;
};

template <class Number>
Quotient<Number> cramer(const Arm<Number>& b, const Arm<Number>& c, const Arm<Number>& d) {
  const Number cd_x = c.y * d.z - c.z * d.y, cd_y = c.z * d.x - c.x * d.z, cd_z = c.x * d.y - c.y * d.x;
  const Number db_x = d.y * b.z - d.z * b.y, db_y = d.z * b.x - d.x * b.z, db_z = d.x * b.y - d.y * b.x;
  const Number bc_x = b.y * c.z - b.z * c.y, bc_y = b.z * c.x - b.x * c.z, bc_z = b.x * c.y - b.y * c.x;
  return {(b.lift * cd_x + c.lift * db_x) + d.lift * bc_x, (b.lift * cd_y + c.lift * db_y) + d.lift * bc_y,
          (b.lift * cd_z + c.lift * db_z) + d.lift * bc_z, (b.x * cd_x + b.y * cd_y) + b.z * cd_z};
}

// Every term of Cramer's formulas made positive, in one figure for the numerators and one for the determinant.
struct Permanents {
  double numerator, determinant;
};

double sum_of_sides(double x, double y, double z) { return std::fabs(x) + std::fabs(y) + std::fabs(z); }

// `weights`: |w_i - w_0|, which enters the lift of an arm beside its squared length
Permanents permanents(const Arm<double>& b, const Arm<double>& c, const Arm<double>& d, const double (&weights)[3]) {
  const double lengths[3] = {sum_of_sides(b.x, b.y, b.z), sum_of_sides(c.x, c.y, c.z), sum_of_sides(d.x, d.y, d.z)};
  double lifts[3];
  for (int i = 0; i < 3; ++i) lifts[i] = lengths[i] * lengths[i] + weights[i];
  return {lifts[0] * lengths[1] * lengths[2] + lifts[1] * lengths[2] * lengths[0] + lifts[2] * lengths[0] * lengths[1],
          lengths[0] * lengths[1] * lengths[2]};
}

// Numerators N and determinant D with errors at most r P_N and r P_D: the error of N / D is at most
// (r P_N + |N| / |D| r P_D) / (|D| - r P_D). Asked for: `accuracy` times the length.
bool accurate(double x, double y, double z, double determinant, const Permanents& scale, double roundings,
              double accuracy) {
  const double size = std::fabs(determinant), numerator = std::max(std::fabs(x), std::max(std::fabs(y), std::fabs(z)));
  const double error = roundings * (scale.numerator + numerator / size * scale.determinant);
  return roundings * scale.determinant < 0.5 * size && 2.0 * error < accuracy * numerator && std::isfinite(error) &&
         size > std::ldexp(1.0, -900);
}

DoubleDouble lift(DoubleDouble x, DoubleDouble y, DoubleDouble z, double weight, double first_weight) {
  return ((x * x + y * y) + z * z) - two_difference(weight, first_weight);
}

Arm<DoubleDouble> fine_arm(const Site& a, const Site& b) {
  Arm<DoubleDouble> arm = {two_difference(b.x, a.x), two_difference(b.y, a.y), two_difference(b.z, a.z), {0.0, 0.0}};
  arm.lift = lift(arm.x, arm.y, arm.z, b.weight, a.weight);
  return arm;
}

template <int Capacity>
Point exact_orthocentre(const ExactFrame& frame, const Site& a, const Site& b, const Site& c, const Site& d) {
  using Number = Integer<Capacity>;
  const auto arm = [&](const Site& site) {
    Arm<Number> result;
    result.x = frame.coordinate<Capacity>(site.x) - frame.coordinate<Capacity>(a.x);
    result.y = frame.coordinate<Capacity>(site.y) - frame.coordinate<Capacity>(a.y);
    result.z = frame.coordinate<Capacity>(site.z) - frame.coordinate<Capacity>(a.z);
    result.lift = result.x * result.x + result.y * result.y + result.z * result.z -
                  (frame.weight<Capacity>(site.weight) - frame.weight<Capacity>(a.weight));
    return result;
  };
  const Quotient<Number> u = cramer(arm(b), arm(c), arm(d));
  int below;
  const double determinant = u.determinant.leading(below);
  const auto offset = [&](const Number& numerator) {
    int above;
    const double value = numerator.leading(above);
    return std::ldexp(0.5 * value / determinant, above - below + frame.exponent);
  };
  return {a.x + offset(u.x), a.y + offset(u.y), a.z + offset(u.z)};
}

Point by_integers(const Site& a, const Site& b, const Site& c, const Site& d) {
  const Site* const sites[4] = {&a, &b, &c, &d};
  const ExactFrame frame(sites, 4, true);
  return is_everyday(frame) ? exact_orthocentre<everyday_limbs>(frame, a, b, c, d)
                            : exact_orthocentre<all_limbs>(frame, a, b, c, d);
}

Point by_double_doubles(const Site& a, const Site& b, const Site& c, const Site& d, const Permanents& scale) {
  // lift 32, cross product 24, product and sums 24: 80 u^2 (predicates.hpp); 128 leaves room
  constexpr double roundings = 128 * unit_roundoff * unit_roundoff;
  const Quotient<DoubleDouble> u = cramer(fine_arm(a, b), fine_arm(a, c), fine_arm(a, d));
  if (!accurate(u.x.high, u.y.high, u.z.high, u.determinant.high, scale, roundings, fine_accuracy))
    return by_integers(a, b, c, d);
  const double half = 0.5 / u.determinant.high;
  return {a.x + u.x.high * half, a.y + u.y.high * half, a.z + u.z.high * half};
}

}  // namespace

Point orthocentre(const Site& a, const Site& b, const Site& c, const Site& d) {
  const auto arm = [&](const Site& site) {
    const double x = site.x - a.x, y = site.y - a.y, z = site.z - a.z;
    return Arm<double>{x, y, z, x * x + y * y + z * z - (site.weight - a.weight)};
  };
  const Arm<double> b_arm = arm(b), c_arm = arm(c), d_arm = arm(d);
  const Quotient<double> u = cramer(b_arm, c_arm, d_arm);
  const double weights[3] = {std::fabs(b.weight - a.weight), std::fabs(c.weight - a.weight),
                             std::fabs(d.weight - a.weight)};
  const Permanents scale = permanents(b_arm, c_arm, d_arm, weights);
  // lift 6, cross product 4, product 1, sums 2: 13 u (predicates.hpp); 16 leaves room
  if (!accurate(u.x, u.y, u.z, u.determinant, scale, 16 * unit_roundoff, plain_accuracy))
    return by_double_doubles(a, b, c, d, scale);
  const double half = 0.5 / u.determinant;
  return {a.x + u.x * half, a.y + u.y * half, a.z + u.z * half};
}

}  // namespace symrecon
