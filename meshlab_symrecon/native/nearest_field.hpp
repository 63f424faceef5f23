// Nearest points of a cloud: from a table, right to about a cell, or exactly.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "crust.hpp"
#include "point_tree.hpp"
#include "vectors.hpp"
#include "view.hpp"

namespace symrecon {

class NearestField {
 public:
  // `table` holds, for each cell, a point of the nearest cell that has points, the last axis fastest; `origin` is the
  // centre of the first cell.
  NearestField(View<Position> points, View<std::int32_t> table, const std::array<std::size_t, 3>& shape,
               const Position& origin, double cell);

  std::size_t size() const { return points_.size(); }
  const Position& point(std::int32_t index) const { return points_[index]; }
  const std::array<std::size_t, 3>& shape() const { return shape_; }
  double cell() const { return cell_; }

  // A point near a place; places off the table use the cells of its rim.
  std::int32_t lookup(const Position& place) const {
    return table_[static_cast<std::size_t>((row(place, 0) * width_[1] + row(place, 1)) * width_[2] + row(place, 2))];
  }

  // The point closest to a place; where none is nearer than `within`, one that is not.
  std::int32_t closest(const Position& place, double within = std::numeric_limits<double>::infinity()) const {
    const std::int32_t guess = lookup(place);
    const Position gap = minus(points_[guess], place);
    const double square = dot(gap, gap), certain = within + slack_ * cell_;
    if (square > certain * certain && inside(place)) return guess;
    return tree_.closest(place, guess, std::min(square, within * within));
  }

 private:
  double row(const Position& place, int axis) const {
    constexpr double whole = 6755399441055744.0;  // 1.5 * 2^52: what is added to it is rounded to a whole number
    const double cells = (place[axis] - origin_[axis]) * per_cell_, last = width_[axis] - 1.0;
    const double inside = cells > 0.0 ? (cells < last ? cells : last) : 0.0;  // not a number: 0
    return (inside + whole) - whole;
  }

  bool inside(const Position& place) const {
    bool inside = true;
    for (int axis = 0; axis < 3; ++axis)
      inside &= std::abs(place[axis] - origin_[axis] - 0.5 * cell_ * (width_[axis] - 1.0)) <=
                0.5 * cell_ * width_[axis];
    return inside;
  }

  // Cells by which a point of the table may be farther than the closest one: twice the half diagonals of the cells of
  // the place and of the point, and a little for rounding.
  static constexpr double slack_ = 3.5;

  std::vector<Position> points_;
  std::vector<std::int32_t> table_;
  std::array<std::size_t, 3> shape_;
  Position width_;  // the shape, for arithmetic
  Position origin_;
  double cell_, per_cell_;
  PointTree tree_;
};

}  // namespace symrecon
