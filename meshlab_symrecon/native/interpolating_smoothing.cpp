#include <cmath>
#include <stdexcept>

#include "cell_sides.hpp"

namespace symrecon {
namespace {

constexpr std::uint8_t kMostTurns = 8;  // of a cell: bends of slivers may call for turns without end

// A sample is taken into a boundary triangle that does not grow more than this.
constexpr double kMostGrowth = 1.0;  // areas of the triangle: a peak of half its width, at most

constexpr double kRounding = 1e-9;  // of the bend: what flattens more than this cannot repeat

}  // namespace

bool CellSides::is_off(std::int32_t sample) const {
  for (std::int32_t i = start_[sample] + 1; i < start_[sample + 1]; ++i)
    if (sides_[around_[i]] != sides_[around_[start_[sample]]]) return false;
  return true;
}

// Turning over the cell between a boundary facet and a sample that lies off the boundary keeps the
// boundary a manifold, because nothing else of it comes near the sample.
bool CellSides::take_in(std::int32_t sample) {
  const std::uint8_t side = sides_[around_[start_[sample]]];
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

// A sample on the boundary stays there.
void CellSides::take_in_samples() {
  Chosen off;
  for (std::int32_t sample = 0; sample < samples_; ++sample)
    if (start_[sample] < start_[sample + 1] && is_off(sample)) off.push_back(sample);
  for (std::size_t left = off.size() + 1; off.size() < left;) {
    left = off.size();
    off.erase(std::remove_if(off.begin(), off.end(), [&](auto sample) { return take_in(sample); }), off.end());
  }
}

// No branches in these two: they would be guessed wrong half the time.
std::int32_t CellSides::next_cell(const Turn& turn) const {
  const Corners& corners = cells_[turn.cell];
  const int out = (corners.site[1] == turn.behind) + 2 * (corners.site[2] == turn.behind) +
                  3 * (corners.site[3] == turn.behind);
  return corners.across[out];
}

void CellSides::step(Turn& turn, std::int32_t next) const {
  const Quad& site = cells_[next].site;
  const std::int32_t others = turn.from ^ turn.to ^ turn.ahead;  // what is left of the four is ahead
  turn.behind = turn.ahead;
  turn.ahead = site[0] ^ site[1] ^ site[2] ^ site[3] ^ others;
  turn.cell = next;
}

// Are two triangles of the cell on the boundary?
bool CellSides::has_pair(std::int32_t cell) const {
  int own = 0;
  for (const std::int32_t next : cells_[cell].across) own += next >= 0 && sides_[next] == sides_[cell];
  return own == 2 && movable(cell);
}

CellSides::Halves CellSides::halves(std::int32_t cell) const {
  Halves halves;
  int owned = 0, others = 0;
  for (int k = 0; k < 4; ++k) {
    if (sides_[cells_[cell].across[k]] == sides_[cell]) {
      halves.own[owned++] = cells_[cell].site[k];
    } else {
      halves.other[others++] = cells_[cell].site[k];
    }
  }
  return halves;
}

// Turn on to the boundary; return the cell beyond it.
std::int32_t CellSides::leave_side(Turn& turn) const {
  std::int32_t next = next_cell(turn);
  for (; sides_[next] == sides_[turn.cell]; next = next_cell(turn)) step(turn, next);
  return next;
}

// Visit the other cells round the edge of a cell that two of its corners make.
template <class Visit>
void CellSides::go_round(std::int32_t cell, const std::int32_t (&edge)[2], const std::int32_t (&facing)[2],
                         Visit&& visit) const {
  Turn turn{edge[0], edge[1], cell, facing[0], facing[1]};
  for (std::int32_t next = next_cell(turn); next != cell; next = next_cell(turn)) {
    visit(next);
    step(turn, next);
  }
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

// By how much turning over a cell with a pair lessens the boundary's total bend; at most 0 when it
// does not, or when it would make four triangles meet at an edge.
CellSides::Exchange CellSides::exchange(std::int32_t cell) const {
  const auto [own, other] = halves(cell);
  Exchange found{cell, 0.0, {}};
  double before = bend(own[0], own[1], other[0], other[1]);
  double after = bend(other[0], other[1], own[0], own[1]);
  int count = 0;
  for (int i = 0; i < 2; ++i)
    for (int j = 0; j < 2; ++j) {
      Turn turn{own[i], other[j], cell, own[1 - i], other[1 - j]};
      found.near[count++] = leave_side(turn);
      found.near[count++] = turn.cell;
      before += bend(own[i], other[j], turn.ahead, own[1 - i]);
      after += bend(own[i], other[j], turn.ahead, other[1 - j]);
    }
  for (const std::int32_t next : cells_[cell].across) found.near[count++] = next;
  if (after >= before * (1.0 - kRounding)) return found;
  bool free = true;
  go_round(cell, other, own, [&](std::int32_t next) { free = free && sides_[next] == sides_[cell]; });
  found.gain = free ? before - after : 0.0;
  return found;
}

// Does an exchange gain more than all others that it has to do with?
bool CellSides::is_greatest(const Exchange& exchange, const std::vector<double>& gains) const {
  bool greatest = true;
  const auto compare = [&](std::int32_t next) {
    const bool more = gains[next] > exchange.gain ||
                      (gains[next] == exchange.gain && given_cell_[next] > given_cell_[exchange.cell]);
    greatest = greatest && !more;
  };
  for (const std::int32_t next : exchange.near) compare(next);
  if (!greatest) return false;
  const auto [own, other] = halves(exchange.cell);
  go_round(exchange.cell, other, own, compare);
  return greatest;
}

// In rounds, each of which does all exchanges that gain more than any near them.  Those do not touch
// each other, so the result does not depend on the order of the cells.
void CellSides::smooth() {
  std::vector<double> gains(cells_.size(), 0.0);
  std::vector<std::uint8_t> turns(cells_.size(), 0);
  std::vector<Exchange> waiting;
  std::vector<std::size_t> greatest;  // places among those that wait
  Chosen changed;
  for (std::int32_t cell = 0; cell < static_cast<std::int32_t>(cells_.size()); ++cell)
    if (has_pair(cell)) changed.push_back(cell);
  ++stamp_;
  while (!changed.empty()) {
    const auto is_changed = [&](const Exchange& exchange) { return seen_[exchange.cell] == stamp_; };
    waiting.erase(std::remove_if(waiting.begin(), waiting.end(), is_changed), waiting.end());
    for (const std::int32_t cell : changed) {
      gains[cell] = 0.0;
      if (!has_pair(cell) || turns[cell] == kMostTurns) continue;
      const Exchange found = exchange(cell);
      gains[cell] = found.gain;
      if (found.gain > 0.0) waiting.push_back(found);
    }
    changed.clear();
    greatest.clear();
    for (std::size_t place = 0; place < waiting.size(); ++place)
      if (is_greatest(waiting[place], gains)) greatest.push_back(place);
    ++stamp_;
    const auto change = [&](std::int32_t cell) {
      if (seen_[cell] != stamp_) changed.push_back(cell);
      seen_[cell] = stamp_;
    };
    for (const std::size_t place : greatest) {
      const Exchange& exchange = waiting[place];
      const auto [own, other] = halves(exchange.cell);
      sides_[exchange.cell] ^= 1;
      ++turns[exchange.cell];
      change(exchange.cell);
      for (const std::int32_t next : exchange.near) change(next);
      go_round(exchange.cell, own, other, change);  // here there was an edge of the boundary,
      go_round(exchange.cell, other, own, change);  // and here is one now
    }
  }
}

std::vector<std::uint8_t> settle_sides(View<Position> sites, View<Quad> cells, View<Quad> neighbours,
                                       std::int32_t samples, View<std::uint8_t> sides, std::int64_t smallest) {
  for (std::size_t cell = 0; cell < cells.size(); ++cell)
    if (sides[cell] == inner_side)
      for (const std::int32_t site : cells[cell])
        if (site >= samples) throw std::invalid_argument("an inner cell with a corner that is no sample");
  CellSides partition(sites, cells, neighbours, samples, sides);
  partition.resolve_pinches();
  partition.turn_small_pieces(smallest);
  partition.take_in_samples();
  partition.smooth();
  return partition.sides();
}

}  // namespace symrecon
