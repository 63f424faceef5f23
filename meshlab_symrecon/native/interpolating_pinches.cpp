#include <algorithm>
#include <cmath>
#include <deque>

#include "cell_order.hpp"
#include "cell_sides.hpp"

namespace symrecon {
namespace {

constexpr std::uint8_t kMostDetours = 4;  // of a cell; more seldom help

}  // namespace

CellSides::CellSides(View<Position> sites, View<Quad> cells, View<Quad> neighbours, std::int32_t samples,
                     View<std::uint8_t> sides)
    : samples_(samples),
      sites_(sites),
      given_cell_(by_earliest_site(cells, sites.size())),
      cells_(cells.size()),
      sides_(cells.size()),
      start_(samples + 1, 0),
      pinches_(samples, 0),
      detours_(cells.size(), 0),
      seen_(cells.size(), 0) {
  std::vector<std::int32_t> number(cells.size());
  for (std::size_t place = 0; place < cells.size(); ++place)
    number[given_cell_[place]] = static_cast<std::int32_t>(place);
  for (std::size_t place = 0; place < cells.size(); ++place) {
    const std::int32_t given = given_cell_[place];
    Corners& cell = cells_[place];
    sides_[place] = sides[given];
    cell.site = cells[given];
    for (int k = 0; k < 4; ++k) {
      cell.across[k] = neighbours[given][k] < 0 ? -1 : number[neighbours[given][k]];
      if (cell.site[k] < samples_) ++start_[cell.site[k] + 1];
    }
  }
  for (std::int32_t site = 0; site < samples_; ++site) start_[site + 1] += start_[site];
  around_.resize(start_[samples_]);
  std::vector<std::int32_t> place(start_.begin(), start_.end() - 1);
  for (std::size_t cell = 0; cell < cells_.size(); ++cell)
    for (const std::int32_t site : cells_[cell].site)
      if (site < samples_) around_[place[site]++] = static_cast<std::int32_t>(cell);
}

std::vector<std::uint8_t> CellSides::sides() const {
  std::vector<std::uint8_t> given(sides_.size());
  for (std::size_t place = 0; place < sides_.size(); ++place) given[given_cell_[place]] = sides_[place];
  return given;
}

// Visit the cells of one side that are connected with `first` round a sample.
template <class Visit>
void CellSides::flood(std::int32_t site, std::int32_t first, Visit&& visit) {
  stack_.assign(1, first);
  seen_[first] = stamp_;
  while (!stack_.empty()) {
    const std::int32_t cell = stack_.back();
    stack_.pop_back();
    visit(cell);
    for (int k = 0; k < 4; ++k) {
      const std::int32_t next = cells_[cell].across[k];
      if (cells_[cell].site[k] == site || sides_[next] != sides_[cell] || seen_[next] == stamp_) continue;
      seen_[next] = stamp_;
      stack_.push_back(next);
    }
  }
}

// Are the boundary triangles round a sample one fan?  Quicker than counting pieces, and nearly always
// true; false also for fans of more triangles than there is room for.
bool CellSides::is_disc(std::int32_t site) const {
  constexpr int kRoom = 32;
  std::int32_t ends[kRoom][2];  // of the edges opposite the sample
  int count = 0;
  for (std::int32_t i = start_[site]; i < start_[site + 1]; ++i) {
    const std::int32_t cell = around_[i];
    if (sides_[cell] != inner_side) continue;
    const Corners& corners = cells_[cell];
    for (int k = 0; k < 4; ++k) {
      if (corners.site[k] == site || sides_[corners.across[k]] == inner_side) continue;
      if (count == kRoom) return false;
      int found = 0;
      for (int other = 0; other < 4; ++other)
        if (other != k && corners.site[other] != site) ends[count][found++] = corners.site[other];
      ++count;
    }
  }
  int at = 0, steps = 0;
  if (count == 0) return true;
  std::int32_t end = ends[0][1];
  do {  // along the edges, each end of which has one other edge
    int next = -1;
    for (int other = 0; other < count; ++other) {
      if (other == at || (ends[other][0] != end && ends[other][1] != end)) continue;
      if (next >= 0) return false;
      next = other;
    }
    end = ends[next][0] == end ? ends[next][1] : ends[next][0];
    at = next;
    ++steps;
  } while (at != 0);
  return steps == count;
}

std::int32_t CellSides::count_pinches(std::int32_t site) {
  if (is_disc(site)) return 0;
  const std::int32_t begin = start_[site], end = start_[site + 1];
  ++stamp_;
  std::int32_t pieces = 0;
  for (std::int32_t i = begin; i < end; ++i) {
    if (seen_[around_[i]] == stamp_) continue;
    flood(site, around_[i], [](std::int32_t) {});
    ++pieces;
  }
  return pieces - 2;
}

void CellSides::resolve_pinches() {
  for (std::int32_t site = 0; site < samples_; ++site) pinches_[site] = count_pinches(site);
  resolve(Moves::gains);
  resolve(Moves::detours);
  resolve(Moves::erosion);
}

// Gains take away pinches with every step, so that ends.  Detours may make others for the one they
// remove, but turn over no cell often.  Erosion turns over inner cells only, if need be more than
// remove pinches here: the inside shrinks with every step, so that ends too, and nothing is left then.
void CellSides::resolve(Moves moves) {
  std::deque<std::int32_t> waiting;
  for (std::int32_t site = 0; site < samples_; ++site)
    if (pinches_[site] > 0) waiting.push_back(site);
  while (!waiting.empty()) {
    const std::int32_t site = waiting.front();
    waiting.pop_front();
    while (pinches_[site] > 0 && (improve(site, moves) || (moves == Moves::erosion && clear(site))))
      for (const std::int32_t other : touched_)
        if (other != site && pinches_[other] > 0) waiting.push_back(other);
  }
}

// Turn over all inner cells round a sample.
bool CellSides::clear(std::int32_t site) {
  Chosen inner;
  for (std::int32_t i = start_[site]; i < start_[site + 1]; ++i)
    if (sides_[around_[i]] == inner_side) inner.push_back(around_[i]);
  turn(inner);
  collect_touched(inner);
  for (const std::int32_t sample : touched_) pinches_[sample] = count_pinches(sample);
  return true;
}

void CellSides::collect_candidates(std::int32_t site) {
  candidates_.clear();
  ++stamp_;
  for (std::int32_t i = start_[site]; i < start_[site + 1]; ++i) {
    const std::int32_t cell = around_[i];
    if (movable(cell)) candidates_.push_back({cell});
    if (seen_[cell] == stamp_) continue;
    Chosen piece;
    bool free = true;
    flood(site, cell, [&](std::int32_t member) {
      piece.push_back(member);
      free = free && movable(member);
    });
    if (free && piece.size() > 1) candidates_.push_back(std::move(piece));
  }
}

// Turn over the cells at a pinched sample that remove most pinches; of equals, those that leave
// the smaller boundary.  False when none removes any.
bool CellSides::improve(std::int32_t site, Moves moves) {
  collect_candidates(site);
  const Chosen* best = nullptr;
  std::int32_t most = 0;
  double least = 0.0;
  for (const Chosen& chosen : candidates_) {
    if (moves == Moves::erosion && sides_[chosen[0]] == outer_side) continue;
    if (moves == Moves::detours && tired(chosen)) continue;
    collect_touched(chosen);
    turn(chosen);
    std::int32_t removed = 0;
    for (const std::int32_t sample : touched_) removed += pinches_[sample] - count_pinches(sample);
    const bool helps = moves == Moves::detours ? count_pinches(site) < pinches_[site] : removed > 0;
    turn(chosen);
    if (!helps || (best != nullptr && removed < most)) continue;
    const double size = growth(chosen);
    if (best == nullptr || removed > most || size < least) {
      best = &chosen;
      most = removed;
      least = size;
    }
  }
  if (best == nullptr) return false;
  if (moves == Moves::detours)
    for (const std::int32_t cell : *best) ++detours_[cell];
  turn(*best);
  collect_touched(*best);
  for (const std::int32_t sample : touched_) pinches_[sample] = count_pinches(sample);
  return true;
}

// Has a cell been turned over on detours as often as it may be?
bool CellSides::tired(const Chosen& chosen) const {
  return std::any_of(chosen.begin(), chosen.end(), [&](auto cell) { return detours_[cell] >= kMostDetours; });
}

void CellSides::turn(const Chosen& chosen) {
  for (const std::int32_t cell : chosen) sides_[cell] ^= 1;
}

void CellSides::collect_touched(const Chosen& chosen) {
  touched_.clear();
  for (const std::int32_t cell : chosen)
    for (const std::int32_t site : cells_[cell].site)
      if (site < samples_) touched_.push_back(site);
  std::sort(touched_.begin(), touched_.end());
  touched_.erase(std::unique(touched_.begin(), touched_.end()), touched_.end());
}

double CellSides::facet_area(std::int32_t cell, int corner) const {
  const Quad& s = cells_[cell].site;
  const Position &a = sites_[s[(corner + 1) % 4]], &b = sites_[s[(corner + 2) % 4]];
  const Position& c = sites_[s[(corner + 3) % 4]];
  const double u[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
  const double v[3] = {c[0] - a[0], c[1] - a[1], c[2] - a[2]};
  const double x = u[1] * v[2] - u[2] * v[1], y = u[2] * v[0] - u[0] * v[2], z = u[0] * v[1] - u[1] * v[0];
  return 0.5 * std::sqrt(x * x + y * y + z * z);
}

// How much the boundary's area grows when these cells, all of one side, are turned over.
double CellSides::growth(const Chosen& chosen) const {
  double gain = 0.0;
  for (const std::int32_t cell : chosen)
    for (int k = 0; k < 4; ++k) {
      const std::int32_t next = cells_[cell].across[k];
      if (sides_[next] != sides_[cell]) {
        gain -= facet_area(cell, k);
      } else if (std::find(chosen.begin(), chosen.end(), next) == chosen.end()) {
        gain += facet_area(cell, k);
      }
    }
  return gain;
}

}  // namespace symrecon
