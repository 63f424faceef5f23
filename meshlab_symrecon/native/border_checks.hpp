// What arrays from Python must be before the loops use them as indices.  Each check passes over its array once and
// throws std::invalid_argument, which Python sees as a ValueError.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <stdexcept>

#include "view.hpp"

namespace symrecon {

inline void require(bool right, const char* otherwise) {
  if (!right) throw std::invalid_argument(otherwise);
}

// The numbers of rows of any width, as one row.
template <class Number, std::size_t Width>
View<Number> flat(View<std::array<Number, Width>> rows) {
  static_assert(sizeof(std::array<Number, Width>) == Width * sizeof(Number), "rows lie side by side");
  return {reinterpret_cast<const Number*>(rows.data()), Width * rows.size()};
}

inline void require_finite(View<double> numbers, const char* otherwise) {
  bool finite = true;
  for (const double number : numbers) finite &= std::isfinite(number);
  require(finite, otherwise);
}

template <std::size_t Width>
void require_finite(View<std::array<double, Width>> rows, const char* otherwise) {
  require_finite(flat(rows), otherwise);
}

// No branch a number: what is negative is a large unsigned number.
inline void require_known(View<std::int32_t> numbers, std::size_t count, const char* otherwise) {
  bool known = true;
  for (const std::int32_t number : numbers) known &= static_cast<std::uint32_t>(number) < count;
  require(known, otherwise);
}

template <std::size_t Width>
void require_known(View<std::array<std::int32_t, Width>> rows, std::size_t count, const char* otherwise) {
  require_known(flat(rows), count, otherwise);
}

// The same where -1 stands for none.
inline void require_known_or_none(View<std::int32_t> numbers, std::size_t count, const char* otherwise) {
  bool known = true;
  for (const std::int32_t number : numbers) known &= static_cast<std::uint32_t>(number) + 1u <= count;
  require(known, otherwise);
}

// 0 and 1, on which the loops do arithmetic.
inline void require_marks(View<std::uint8_t> marks, const char* otherwise) {
  std::uint8_t all = 0;
  for (const std::uint8_t mark : marks) all |= mark;
  require(all <= 1, otherwise);
}

// Rows of a table whose row i is offsets[i] .. offsets[i + 1].
template <class Offset>
void require_rows(View<Offset> offsets, std::size_t items) {
  constexpr auto wrong = "offsets must rise from 0 to the number of entries";
  require(offsets.size() > 0 && offsets[0] == 0, wrong);
  bool rising = true;
  for (std::size_t row = 0; row + 1 < offsets.size(); ++row) rising &= offsets[row] <= offsets[row + 1];
  require(rising && static_cast<std::size_t>(offsets[offsets.size() - 1]) == items, wrong);
}

using CellCorners = std::array<std::int32_t, 4>;

// Four known sites, all of them different.
inline void require_cells(View<CellCorners> cells, std::size_t sites) {
  bool known = true, distinct = true;
  for (const auto& [a, b, c, d] : cells) {
    for (const std::int32_t site : {a, b, c, d}) known &= static_cast<std::uint32_t>(site) < sites;
    distinct &= (a != b) & (a != c) & (a != d) & (b != c) & (b != d) & (c != d);
  }
  require(known, "cell of unknown sites");
  require(distinct, "cell that has a site twice");
}

inline void require_neighbours(View<CellCorners> neighbours, View<CellCorners> cells) {
  require(neighbours.size() == cells.size(), "one row of neighbours a cell is needed");
  require_known_or_none(flat(neighbours), cells.size(), "neighbours among unknown cells");
}

// Neighbours share the facet that each has opposite its fourth site, and both know of it.
inline void require_shared_facets(View<CellCorners> cells, View<CellCorners> neighbours) {
  require_neighbours(neighbours, cells);
  bool shared = true;
  for (std::size_t cell = 0; cell < cells.size(); ++cell)
    for (int k = 0; k < 4; ++k) {
      const std::int32_t next = neighbours[cell][k];
      if (next < 0) continue;
      int common = 0, back = 0;
      for (int other = 0; other < 4; ++other) {
        bool on_facet = false;
        for (int corner = 0; corner < 4; ++corner)
          on_facet |= corner != k && cells[next][other] == cells[cell][corner];
        common += on_facet;
        if (!on_facet) back = other;
      }
      shared &= common == 3 && neighbours[next][back] == static_cast<std::int32_t>(cell);
    }
  require(shared, "neighbouring cells of the triangulation do not share a facet");
}

}  // namespace symrecon
