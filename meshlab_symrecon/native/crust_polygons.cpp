#include <limits>
#include <stdexcept>

#include "crust.hpp"
#include "memory_pages.hpp"

namespace symrecon {
namespace {

constexpr std::size_t kStepsPerReport = 1 << 14;

// For an edge from corner a to corner b of a cell the third corner c such that turning from c to the
// fourth one is counter-clockwise round the edge: (a, b, c, fourth) is an even permutation.
constexpr int kBehind[4][4] = {{-1, 2, 3, 1}, {3, -1, 0, 2}, {1, 3, -1, 0}, {2, 0, 1, -1}};

// A cell with inner and outer sites; all cells round a mixed edge are such.
struct alignas(32) MixedCell {  // in half a cache line
  Quad sites, neighbours;  // neighbours across mixed facets, by their place among the mixed cells
};

// A bit for each corner of a cell.
int inner_corners(const Quad& cell, View<std::uint8_t> inside) {
  return inside[cell[0]] | inside[cell[1]] << 1 | inside[cell[2]] << 2 | inside[cell[3]] << 3;
}

bool is_mixed(int corners) { return corners != 0 && corners != 15; }

// The mixed cells, numbered in the order of a flood across mixed facets.  Cells of a triangulation lie in
// memory in no order of space; here neighbours get numbers close together, which makes every later
// step that goes round a cell two to three times as fast.
class Flood {
 public:
  Flood(View<Quad> cells, View<Quad> neighbours, View<std::uint8_t> inside, const Progress& progress)
      : cells_(cells), neighbours_(neighbours), inside_(inside), place_(cells.size(), kPure) {
    std::size_t count = 0;
    for (std::size_t cell = 0; cell < cells.size(); ++cell)
      if (is_mixed(inner_corners(cells[cell], inside))) {
        place_[cell] = kUnseen;
        ++count;
      }
    chosen_.reserve(count);
    mixed_.reserve(count);
    for (std::size_t cell = 0; cell < cells.size(); ++cell) {
      if (place_[cell] != kUnseen) continue;
      number(static_cast<std::int32_t>(cell));
      while (mixed_.size() < chosen_.size()) {
        if (mixed_.size() % kStepsPerReport == 0 && progress) progress(0.5 * double(mixed_.size()) / double(count));
        enter(chosen_[mixed_.size()]);
      }
    }
  }

  LargeVector<MixedCell>& mixed() { return mixed_; }
  std::vector<std::int32_t>& chosen() { return chosen_; }

 private:
  static constexpr std::int32_t kPure = -2, kUnseen = -1;

  std::int32_t number(std::int32_t cell) {
    if (place_[cell] < 0) {
      place_[cell] = static_cast<std::int32_t>(chosen_.size());
      chosen_.push_back(cell);
      cells_.announce(cell);
      neighbours_.announce(cell);
    }
    return place_[cell];
  }

  void enter(std::int32_t cell) {
    const Quad& sites = cells_[cell];
    MixedCell entry{sites, {-1, -1, -1, -1}};
    const int corners = inner_corners(sites, inside_);
    for (int k = 0; k < 4; ++k) {
      const int facet = 15 & ~(1 << k);
      if ((corners & facet) == 0 || (corners & facet) == facet) continue;
      const std::int32_t other = neighbours_[cell][k];
      if (other < 0) throw std::invalid_argument("an inner site lies on the hull");
      entry.neighbours[k] = number(other);
    }
    mixed_.push_back(entry);
  }

  View<Quad> cells_, neighbours_;
  View<std::uint8_t> inside_;
  LargeVector<std::int32_t> place_;
  std::vector<std::int32_t> chosen_;
  LargeVector<MixedCell> mixed_;
};

int place_of(std::int32_t site, const Quad& sites) {
  return (sites[1] == site) + 2 * (sites[2] == site) + 3 * (sites[3] == site);  // of distinct sites
}

// Walks round the mixed edges of the mixed cells, each once.
class Rings {
 public:
  Rings(const LargeVector<MixedCell>& mixed, View<std::uint8_t> inside, Polygons& polygons)
      : mixed_(mixed), inside_(inside), polygons_(polygons), done_(mixed.size(), 0) {}

  void enter(std::int32_t first) {
    const Quad& sites = mixed_[first].sites;
    const int inner = inner_corners(sites, inside_);
    for (int from = 0; from < 4; ++from)
      for (int to = 0; to < 4; ++to)
        if ((inner >> from & 1) && !(inner >> to & 1) && !(done_[first] >> (4 * from + to) & 1)) walk(first, from, to);
  }

 private:
  // Counter-clockwise round the way from inside to outside.
  void walk(std::int32_t first, int from_place, int to_place) {
    const std::int32_t from = mixed_[first].sites[from_place], to = mixed_[first].sites[to_place];
    int behind = kBehind[from_place][to_place];
    std::int32_t cell = first;
    for (;;) {
      const MixedCell& at = mixed_[cell];
      const auto edge = std::uint16_t(1u << (4 * from_place + to_place));
      if (done_[cell] & edge) throw std::invalid_argument("cells of the triangulation do not close round an edge");
      done_[cell] |= edge;
      polygons_.corners.push_back(cell);
      const std::int32_t shared = at.sites[6 - from_place - to_place - behind];
      cell = at.neighbours[behind];
      if (cell == first) break;
      if (cell < 0) throw std::invalid_argument("cells of the triangulation do not close round an edge");
      const Quad& sites = mixed_[cell].sites;
      from_place = place_of(from, sites);
      to_place = place_of(to, sites);
      behind = place_of(shared, sites);
      if (sites[from_place] != from || sites[to_place] != to || sites[behind] != shared)
        throw std::invalid_argument("neighbouring cells of the triangulation do not share a facet");
    }
    if (polygons_.corners.size() > std::numeric_limits<std::int32_t>::max())
      throw std::length_error("the crust needs more corners than 32-bit indices can number");
    polygons_.offsets.push_back(static_cast<std::int32_t>(polygons_.corners.size()));
  }

  const LargeVector<MixedCell>& mixed_;
  View<std::uint8_t> inside_;
  Polygons& polygons_;
  LargeVector<std::uint16_t> done_;  // bit 4 a + b for the edge from corner a to corner b
};

}  // namespace

Polygons mixed_edge_polygons(View<Quad> cells, View<Quad> neighbours, View<std::uint8_t> inside,
                             const Progress& progress) {
  Polygons result;
  LargeVector<MixedCell> mixed;
  {
    Flood flood(cells, neighbours, inside, progress);
    mixed = std::move(flood.mixed());
    result.cells = std::move(flood.chosen());
  }
  // Three or four polygons meet at every corner, three edges less one for each triangle of cells.
  result.corners.reserve(7 * mixed.size() / 2);
  result.offsets.reserve(3 * mixed.size() / 4);
  result.offsets.push_back(0);
  Rings rings(mixed, inside, result);
  for (std::size_t cell = 0; cell < mixed.size(); ++cell) {
    if (cell % kStepsPerReport == 0 && progress) progress(0.5 + 0.5 * double(cell) / double(mixed.size()));
    rings.enter(static_cast<std::int32_t>(cell));
  }
  return result;
}

}  // namespace symrecon
