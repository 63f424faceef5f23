#include <cmath>
#include <queue>
#include <stdexcept>
#include <utility>

#include "cell_sides.hpp"

namespace symrecon {
namespace {

// A sample is taken into a boundary triangle that does not grow more than this.
constexpr double kMostGrowth = 1.0;  // areas of the triangle: a peak of half its width, at most

// The edges of a cell, each followed by the other two corners.
constexpr int kEdges[6][4] = {{0, 1, 2, 3}, {0, 2, 3, 1}, {0, 3, 1, 2}, {1, 2, 0, 3}, {1, 3, 2, 0}, {2, 3, 0, 1}};

constexpr double kRounding = 1e-9;  // of the bend: what flattens more than this cannot repeat

}  // namespace

// Turning over the cell between a boundary facet and a sample that lies off the boundary keeps the
// boundary a manifold, because nothing else of it comes near the sample.
bool CellSides::take_in(std::int32_t sample) {
  const std::uint8_t side = sides_[around_[start_[sample]]];
  for (std::int32_t i = start_[sample]; i < start_[sample + 1]; ++i)
    if (sides_[around_[i]] != side) return false;
  std::int32_t best = -1;
  double least = kMostGrowth;
  for (std::int32_t i = start_[sample]; i < start_[sample + 1]; ++i) {
    const std::int32_t cell = around_[i];
    int corner = 0;
    while (cells_[cell].site[corner] != sample) ++corner;
    if (!movable(cell) || sides_[cells_[cell].across[corner]] == side) continue;
    const double facet = facet_area(cell, corner);
    double sum = -facet;
    for (int k = 0; k < 4; ++k)
      if (k != corner) sum += facet_area(cell, k);
    if (sum < least * facet) {
      least = sum / facet;
      best = cell;
    }
  }
  if (best < 0) return false;
  sides_[best] ^= 1;
  return true;
}

void CellSides::take_in_samples() {
  for (bool more = true; more;) {
    more = false;
    for (std::int32_t sample = 0; sample < samples_; ++sample)
      if (start_[sample] < start_[sample + 1] && take_in(sample)) more = true;
  }
}

std::int32_t CellSides::next_cell(const Turn& turn) const {
  int out = 0;
  while (cells_[turn.cell].site[out] != turn.behind) ++out;
  return cells_[turn.cell].across[out];
}

void CellSides::step(Turn& turn, std::int32_t next) const {
  turn.behind = turn.ahead;
  for (const std::int32_t site : cells_[next].site)
    if (site != turn.from && site != turn.to && site != turn.behind) turn.ahead = site;
  turn.cell = next;
}

// Are two triangles of the cell on the boundary?
bool CellSides::has_pair(std::int32_t cell) const {
  int own = 0;
  for (const std::int32_t next : cells_[cell].across) own += next >= 0 && sides_[next] == sides_[cell];
  return own == 2 && movable(cell);
}

// Is the edge that the other two triangles of the cell share free of the boundary?
bool CellSides::can_exchange(std::int32_t cell) const {
  if (!has_pair(cell)) return false;
  std::int32_t own[4], other[4];
  int owned = 0, others = 0;
  for (int k = 0; k < 4; ++k) {
    if (sides_[cells_[cell].across[k]] == sides_[cell]) {
      own[owned++] = cells_[cell].site[k];
    } else {
      other[others++] = cells_[cell].site[k];
    }
  }
  Turn turn{other[0], other[1], cell, own[0], own[1]};
  do {
    const std::int32_t next = next_cell(turn);
    if (sides_[next] != sides_[cell]) return false;
    step(turn, next);
  } while (turn.cell != cell);
  return true;
}

// Length of an edge times the sine of half the angle by which the triangles to its left and right are
// out of plane.
double CellSides::bend(std::int32_t from, std::int32_t to, std::int32_t left, std::int32_t right) const {
  const Position& origin = sites_[from];
  double edge[3], l[3], r[3], square = 0.0, along_l = 0.0, along_r = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    edge[axis] = sites_[to][axis] - origin[axis];
    l[axis] = sites_[left][axis] - origin[axis];
    r[axis] = sites_[right][axis] - origin[axis];
    square += edge[axis] * edge[axis];
    along_l += edge[axis] * l[axis];
    along_r += edge[axis] * r[axis];
  }
  double ll = 0.0, rr = 0.0, lr = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double x = l[axis] - along_l / square * edge[axis], y = r[axis] - along_r / square * edge[axis];
    ll += x * x;
    rr += y * y;
    lr += x * y;
  }
  const double lengths = std::sqrt(ll * rr);
  const double cosine = lengths > 0.0 ? -lr / lengths : -1.0;  // a triangle without area bends most
  return std::sqrt(square * std::max(0.0, 0.5 - 0.5 * cosine));
}

// By how much turning over an exchangeable cell lessens the boundary's total bend; 0 when it does not.
double CellSides::flattening(std::int32_t cell) const {
  std::int32_t own[2], other[2];
  int owned = 0, others = 0;
  for (int k = 0; k < 4; ++k) {
    if (sides_[cells_[cell].across[k]] == sides_[cell]) {
      own[owned++] = cells_[cell].site[k];
    } else {
      other[others++] = cells_[cell].site[k];
    }
  }
  double before = bend(own[0], own[1], other[0], other[1]);
  double after = bend(other[0], other[1], own[0], own[1]);
  for (int i = 0; i < 2; ++i)
    for (int j = 0; j < 2; ++j) {
      Turn turn{own[i], other[j], cell, own[1 - i], other[1 - j]};
      for (std::int32_t next = next_cell(turn); sides_[next] == sides_[cell]; next = next_cell(turn))
        step(turn, next);
      before += bend(own[i], other[j], turn.ahead, own[1 - i]);
      after += bend(own[i], other[j], turn.ahead, other[1 - j]);
    }
  return after < before * (1.0 - kRounding) ? before - after : 0.0;
}

void CellSides::smooth() {
  // the greatest gain first, so that the result does not depend on the order of the cells
  std::priority_queue<std::pair<double, std::int32_t>> waiting;
  std::vector<double> gains(cells_.size(), 0.0);
  const auto wait = [&](std::int32_t cell) {
    const double gain = can_exchange(cell) ? flattening(cell) : 0.0;
    if (gain > 0.0 && gain != gains[cell]) waiting.push({gain, cell});
    gains[cell] = gain;
  };
  for (std::int32_t cell = 0; cell < static_cast<std::int32_t>(cells_.size()); ++cell) wait(cell);
  while (!waiting.empty()) {
    const auto [gain, cell] = waiting.top();
    waiting.pop();
    if (gain != gains[cell]) continue;  // something near has changed since
    sides_[cell] ^= 1;
    gains[cell] = 0.0;
    seen_[cell] = ++stamp_;
    const Quad& site = cells_[cell].site;
    for (const auto& edge : kEdges) {  // where the boundary bends otherwise now
      Turn turn{site[edge[0]], site[edge[1]], cell, site[edge[2]], site[edge[3]]};
      for (std::int32_t next = next_cell(turn); next != cell; next = next_cell(turn)) {
        step(turn, next);
        if (seen_[next] != stamp_) wait(next);
        seen_[next] = stamp_;
      }
    }
  }
}

std::vector<std::uint8_t> settle_sides(const std::vector<Position>& sites, const std::vector<Quad>& cells,
                                       const std::vector<Quad>& neighbours, std::int32_t samples,
                                       std::vector<std::uint8_t> sides, std::int64_t smallest) {
  for (std::size_t cell = 0; cell < cells.size(); ++cell)
    if (sides[cell] == inner_side)
      for (const std::int32_t site : cells[cell])
        if (site >= samples) throw std::invalid_argument("an inner cell with a corner that is no sample");
  CellSides partition(sites, cells, neighbours, samples, std::move(sides));
  partition.resolve_pinches();
  partition.turn_small_pieces(smallest);
  partition.take_in_samples();
  partition.smooth();
  return std::move(partition).sides();
}

}  // namespace symrecon
