// The cells of a Delaunay triangulation on two sides of a surface, and moves that change it.
#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "interpolating.hpp"
#include "view.hpp"

namespace symrecon {

// The boundary between the sides runs through the samples.  The cells round a sample cut a small
// sphere into triangles; the boundary is a disc there exactly when the triangles of either side are
// connected through their edges.  Every further piece is a pinch.
class CellSides {
 public:
  // Cells are numbered anew, by their sites, because every step looks round about: it is quick where
  // near samples have near numbers.
  CellSides(View<Position> sites, View<Quad> cells, View<Quad> neighbours, std::int32_t samples,
            View<std::uint8_t> sides);

  // Remove all pinches: turn over single cells, or all cells of a piece round a sample, whichever
  // removes most.  Where that would make as many, go on from there, for a while; where nothing else is
  // left, inner cells give way.
  void resolve_pinches();

  // Turn over pieces with fewer than `smallest` boundary facets, inner ones first, but not the
  // largest inner piece, nor outer ones on the hull.
  void turn_small_pieces(std::int64_t smallest);

  // Bring samples just off the boundary onto it.
  void take_in_samples();

  // Exchange two boundary triangles of a cell for its other two where that bends the boundary less.
  void smooth();

  // Of each cell, as numbered by the caller.
  std::vector<std::uint8_t> sides() const;

 private:
  struct alignas(32) Corners {  // half a cache line: both are always needed
    Quad site;
    Quad across;  // the neighbour opposite each site
  };
  using Chosen = std::vector<std::int32_t>;
  enum class Moves { gains, detours, erosion };

  // Two corners of a cell across from cells of its own side, and two across from the other side.
  struct Halves {
    std::int32_t own[2], other[2];
  };

  struct Pieces {
    std::vector<std::int32_t> of_cell;  // the first cell of the piece that each cell is in
    std::vector<std::int64_t> facets;   // on the boundary, at each piece's first cell
    std::vector<std::uint8_t> fixed;    // has a cell that cannot be turned over, likewise
  };

  // A walk round an edge through the cells there: out of this cell across the facet opposite `behind`,
  // which leads from its corner `behind` to its corner `ahead`.
  struct Turn {
    std::int32_t from, to, cell, behind, ahead;
  };

  // Two boundary triangles of a cell for its other two.
  struct Exchange {
    std::int32_t cell;
    double gain;
    // Cells on either side of the cell's triangles and of those that share an edge with them: where
    // the gain depends on this exchange, and this one's on theirs.
    std::array<std::int32_t, 12> near;
  };

  bool movable(std::int32_t cell) const;  // has samples only for corners
  bool is_disc(std::int32_t site) const;
  std::int32_t count_pinches(std::int32_t site);
  template <class Visit>
  void flood(std::int32_t site, std::int32_t first, Visit&& visit);
  void collect_candidates(std::int32_t site);
  void resolve(Moves moves);
  bool improve(std::int32_t site, Moves moves);
  bool tired(const Chosen& chosen) const;
  bool clear(std::int32_t site);
  void turn(const Chosen& chosen);
  void collect_touched(const Chosen& chosen);
  double growth(const Chosen& chosen) const;
  Pieces pieces() const;
  bool turn_pieces(const Pieces& pieces, std::int64_t smallest, Side side);
  double facet_area(std::int32_t cell, int corner) const;
  bool is_off(std::int32_t sample) const;
  bool take_in(std::int32_t sample);
  std::int32_t next_cell(const Turn& turn) const;
  void step(Turn& turn, std::int32_t next) const;
  bool has_pair(std::int32_t cell) const;
  Halves halves(std::int32_t cell) const;
  std::int32_t leave_side(Turn& turn) const;
  template <class Visit>
  void go_round(std::int32_t cell, const std::int32_t (&edge)[2], const std::int32_t (&facing)[2],
                Visit&& visit) const;
  Exchange exchange(std::int32_t cell) const;
  bool is_greatest(const Exchange& exchange, const std::vector<double>& gains) const;
  double bend(std::int32_t from, std::int32_t to, std::int32_t left, std::int32_t right) const;

  const std::int32_t samples_;
  const View<Position> sites_;
  std::vector<std::int32_t> given_cell_;  // the numbers of the cells with the caller
  std::vector<Corners> cells_;
  std::vector<std::uint8_t> sides_;
  std::vector<std::int32_t> start_, around_;  // the cells round each sample
  std::vector<std::int32_t> pinches_;         // of each sample
  std::vector<std::uint8_t> detours_;         // that each cell was turned over on
  std::vector<std::uint32_t> seen_;
  std::uint32_t stamp_ = 0;
  std::vector<std::int32_t> stack_, touched_;
  std::vector<Chosen> candidates_;
};

inline bool CellSides::movable(std::int32_t cell) const {
  const Quad& sites = cells_[cell].site;
  return sites[0] < samples_ && sites[1] < samples_ && sites[2] < samples_ && sites[3] < samples_;
}

}  // namespace symrecon
