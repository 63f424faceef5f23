// Stages 2 and 3 of the predicates: double-doubles, then integers. Formulas and bounds are in the header.
#include "predicates.hpp"

#include <algorithm>
#include <array>

#include "double_double.hpp"
#include "exact_frame.hpp"

namespace symrecon {

namespace {

// A row of the determinant: the difference of two positions, and of the lifted heights.
template <class Number>
struct Row {
  Number x, y, z;
};

template <class Number>
Number minor_xy(const Row<Number>& a, const Row<Number>& b) {
  return a.x * b.y - b.x * a.y;
}

// sign such that orientation(a, b, c, d) = this for rows relative to d
template <class Number>
Number orientation_determinant(const Row<Number>& a, const Row<Number>& b, const Row<Number>& c) {
  return (b.z * minor_xy(a, c) - a.z * minor_xy(b, c)) - c.z * minor_xy(a, b);
}

template <class Number>
Number power_determinant(const Row<Number>& a, const Row<Number>& b, const Row<Number>& c, const Row<Number>& d,
                         const Number (&lift)[4]) {
  const Number ab = minor_xy(a, b), bc = minor_xy(b, c), cd = minor_xy(c, d);
  const Number da = minor_xy(d, a), ac = minor_xy(a, c), bd = minor_xy(b, d);
  const Number bcd = (b.z * cd - c.z * bd) + d.z * bc;
  const Number cda = (c.z * da + d.z * ac) + a.z * cd;
  const Number dab = (d.z * ab + a.z * bd) + b.z * da;
  const Number abc = (a.z * bc - b.z * ac) + c.z * ab;
  return (lift[0] * bcd - lift[1] * cda) + (lift[2] * dab - lift[3] * abc);
}

Row<DoubleDouble> difference(const Site& a, const Site& b) {
  return {two_difference(a.x, b.x), two_difference(a.y, b.y), two_difference(a.z, b.z)};
}

template <int Capacity>
struct ExactRows {
  using Number = Integer<Capacity>;

  ExactRows(const ExactFrame& frame, const Site& last)
      : frame(frame),
        x(frame.coordinate<Capacity>(last.x)),
        y(frame.coordinate<Capacity>(last.y)),
        z(frame.coordinate<Capacity>(last.z)) {}

  Row<Number> row(const Site& site) const {
    return {frame.coordinate<Capacity>(site.x) - x, frame.coordinate<Capacity>(site.y) - y,
            frame.coordinate<Capacity>(site.z) - z};
  }

  Number lift(const Row<Number>& row, const Site& site, const Site& last) const {
    const Number square = row.x * row.x + row.y * row.y + row.z * row.z;
    return square - (frame.weight<Capacity>(site.weight) - frame.weight<Capacity>(last.weight));
  }

  const ExactFrame& frame;
  Number x, y, z;
};

template <int Capacity>
int exact_orientation_with(const ExactFrame& frame, const Site& a, const Site& b, const Site& c, const Site& d) {
  const ExactRows<Capacity> rows(frame, d);
  return orientation_determinant(rows.row(a), rows.row(b), rows.row(c)).sign();
}

template <int Capacity>
int exact_power_test_with(const ExactFrame& frame, const Site& a, const Site& b, const Site& c, const Site& d,
                          const Site& e) {
  const ExactRows<Capacity> rows(frame, e);
  const Row<Integer<Capacity>> ra = rows.row(a), rb = rows.row(b), rc = rows.row(c), rd = rows.row(d);
  const Integer<Capacity> lifts[4] = {rows.lift(ra, a, e), rows.lift(rb, b, e), rows.lift(rc, c, e),
                                      rows.lift(rd, d, e)};
  return power_determinant(ra, rb, rc, rd, lifts).sign();
}

template <int Capacity>
bool collinear_with(const ExactFrame& frame, const Site& a, const Site& b, const Site& c) {
  const ExactRows<Capacity> rows(frame, c);
  const Row<Integer<Capacity>> ra = rows.row(a), rb = rows.row(b);
  return (ra.x * rb.y - rb.x * ra.y).sign() == 0 && (ra.y * rb.z - rb.y * ra.z).sign() == 0 &&
         (ra.z * rb.x - rb.z * ra.x).sign() == 0;
}

}  // namespace

int fine_orientation(const Site& a, const Site& b, const Site& c, const Site& d, double bound) {
  const DoubleDouble value = orientation_determinant(difference(a, d), difference(b, d), difference(c, d));
  return certified_sign(value.high, bound);
}

int exact_orientation(const Site& a, const Site& b, const Site& c, const Site& d) {
  const Site* const sites[4] = {&a, &b, &c, &d};
  const ExactFrame frame(sites, 4, false);
  return is_everyday(frame) ? exact_orientation_with<everyday_limbs>(frame, a, b, c, d)
                            : exact_orientation_with<all_limbs>(frame, a, b, c, d);
}

int exact_power_test(const Site& a, const Site& b, const Site& c, const Site& d, const Site& e) {
  const Site* const sites[5] = {&a, &b, &c, &d, &e};
  const ExactFrame frame(sites, 5, true);
  return is_everyday(frame) ? exact_power_test_with<everyday_limbs>(frame, a, b, c, d, e)
                            : exact_power_test_with<all_limbs>(frame, a, b, c, d, e);
}

int unfiltered_orientation(const Site& a, const Site& b, const Site& c, const Site& d, double permanent,
                           const Margins& margins) {
  const int sign = fine_orientation(a, b, c, d, fine_orientation_bound * permanent + margins.orientation);
  return sign != undecided ? sign : exact_orientation(a, b, c, d);
}

int unfiltered_power_test(const Site& a, const Site& b, const Site& c, const Site& d, const Site& e, double permanent,
                          const Margins& margins) {
  const int sign = fine_power_test(a, b, c, d, e, fine_power_bound * permanent + margins.power);
  return sign != undecided ? sign : exact_power_test(a, b, c, d, e);
}

int perturbation_sign(const Site& a, const Site& b, const Site& c, const Site& d, const Site& e,
                      const Margins& margins) {
  // The determinant is linear in each weight. A larger weight of e brings it into conflict: coefficient
  // orientation(a, b, c, d). Exchanging e with another site changes the sign: minus the orientation with e in its place.
  const std::array<const Site*, 5> sites = {&a, &b, &c, &d, &e};
  std::array<int, 5> ranked = {0, 1, 2, 3, 4};
  std::sort(ranked.begin(), ranked.end(), [&](int i, int j) { return before(*sites[i], *sites[j]); });
  for (int i : ranked) {
    if (i == 4) return orientation(a, b, c, d, margins);
    std::array<const Site*, 4> cell = {&a, &b, &c, &d};
    cell[i] = &e;
    const int coefficient = -orientation(*cell[0], *cell[1], *cell[2], *cell[3], margins);
    if (coefficient != 0) return coefficient;
  }
  return 0;
}

bool collinear(const Site& a, const Site& b, const Site& c) {
  const Site* const sites[3] = {&a, &b, &c};
  const ExactFrame frame(sites, 3, false);
  return is_everyday(frame) ? collinear_with<everyday_limbs>(frame, a, b, c)
                            : collinear_with<all_limbs>(frame, a, b, c);
}

}  // namespace symrecon
