#include "even_samples.hpp"

#include <algorithm>
#include <limits>

namespace symrecon {
namespace {

constexpr std::size_t lanes = 8;

// Coordinates side by side, filled up to whole rows of lanes with copies of the first point.
struct Columns {
  std::vector<double> x, y, z;

  explicit Columns(View<Position> points) {
    for (const Position& point : points) add(point);
    while (x.size() % lanes != 0) add(points[0]);
  }

  void add(const Position& point) {
    x.push_back(point[0]);
    y.push_back(point[1]);
    z.push_back(point[2]);
  }
};

// Takes a point: the gaps, squared distances to the nearest point taken, shrink. Returns the largest one.
double take(const Columns& points, std::size_t taken, std::vector<double>& gaps) {
  const double x = points.x[taken], y = points.y[taken], z = points.z[taken];
  double largest[lanes] = {};
  for (std::size_t i = 0; i < gaps.size(); i += lanes)
    for (std::size_t lane = 0; lane < lanes; ++lane) {
      const double a = points.x[i + lane] - x, b = points.y[i + lane] - y, c = points.z[i + lane] - z;
      const double square = a * a + b * b + c * c, gap = gaps[i + lane];
      const double smaller = square < gap ? square : gap;
      gaps[i + lane] = smaller;
      largest[lane] = largest[lane] < smaller ? smaller : largest[lane];
    }
  return *std::max_element(largest, largest + lanes);
}

}  // namespace

std::vector<std::int64_t> farthest_points(View<Position> points, std::size_t count, std::size_t first) {
  std::vector<std::int64_t> order;
  if (count == 0) return order;
  const Columns columns(points);
  std::vector<double> gaps(columns.x.size(), std::numeric_limits<double>::infinity());
  order.push_back(std::int64_t(first));
  while (order.size() < count) {
    const double largest = take(columns, std::size_t(order.back()), gaps);
    order.push_back(std::find(gaps.begin(), gaps.end(), largest) - gaps.begin());
  }
  return order;
}

}  // namespace symrecon
