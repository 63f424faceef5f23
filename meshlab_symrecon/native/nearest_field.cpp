#include "nearest_field.hpp"

#include "border_checks.hpp"

namespace symrecon {

NearestField::NearestField(View<Position> points, View<std::int32_t> table, const std::array<std::size_t, 3>& shape,
                           const Position& origin, double cell)
    : points_(points.begin(), points.end()),
      table_(table.begin(), table.end()),
      shape_(shape),
      width_{double(shape[0]), double(shape[1]), double(shape[2])},
      origin_(origin),
      cell_(cell),
      per_cell_(1.0 / cell),
      tree_(points) {
  require(table.size() > 0 && table.size() == shape[0] * shape[1] * shape[2], "one entry a cell is needed");
  require_known(table, points_.size(), "table of unknown points");
}

}  // namespace symrecon
