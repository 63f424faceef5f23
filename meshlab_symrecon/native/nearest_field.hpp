// Nearest points of a cloud: from a table, right to about a cell, or exactly.
#pragma once

#include <algorithm>
#include <array>
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
  // `table` holds the point nearest to the centre of each cell, the last axis fastest; `origin` is the centre of the
  // first cell.
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
    return tree_.closest(place, guess, std::min(dot(gap, gap), within * within));
  }

 private:
  double row(const Position& place, int axis) const {
    constexpr double whole = 6755399441055744.0;  // 1.5 * 2^52: what is added to it is rounded to a whole number
    const double cells = (place[axis] - origin_[axis]) * per_cell_, last = width_[axis] - 1.0;
    const double inside = cells > 0.0 ? (cells < last ? cells : last) : 0.0;  // not a number: 0
    return (inside + whole) - whole;
  }

  std::vector<Position> points_;
  std::vector<std::int32_t> table_;
  std::array<std::size_t, 3> shape_;
  Position width_;  // the shape, for arithmetic
  Position origin_;
  double cell_, per_cell_;
  PointTree tree_;
};

}  // namespace symrecon
