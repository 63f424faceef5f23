#include "poles.hpp"

#include "disjoint_sets.hpp"

namespace symrecon {
namespace {

Position arm(const Position& from, const Position& to) {
  return {to[0] - from[0], to[1] - from[1], to[2] - from[2]};
}

double dot(const Position& a, const Position& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

}  // namespace

PoleCells pole_cells(const std::vector<Position>& sites, const std::vector<Position>& centres,
                     const std::vector<Quad>& cells, std::int32_t samples) {
  PoleCells poles{std::vector<std::int32_t>(samples, -1), std::vector<std::int32_t>(samples, -1)};
  std::vector<double> farthest(samples, -1.0);
  const auto for_each_corner = [&](auto&& visit) {
    for (std::size_t cell = 0; cell < cells.size(); ++cell)
      for (const std::int32_t sample : cells[cell])
        if (sample < samples) visit(static_cast<std::int32_t>(cell), sample);
  };
  for_each_corner([&](std::int32_t cell, std::int32_t sample) {
    const Position reach = arm(sites[sample], centres[cell]);
    const double square = dot(reach, reach);
    if (square > farthest[sample]) {
      farthest[sample] = square;
      poles.first[sample] = cell;
    }
  });
  std::fill(farthest.begin(), farthest.end(), -1.0);
  for_each_corner([&](std::int32_t cell, std::int32_t sample) {
    const Position reach = arm(sites[sample], centres[cell]);
    const Position ahead = arm(sites[sample], centres[poles.first[sample]]);
    const double square = dot(reach, reach);
    if (dot(reach, ahead) <= 0.0 && square > farthest[sample]) {
      farthest[sample] = square;
      poles.second[sample] = cell;
    }
  });
  return poles;
}

std::vector<std::int32_t> label_pieces(const std::vector<Quad>& cells,
                                       const std::vector<std::uint8_t>& labels) {
  DisjointSets sets(labels.size());
  for (const Quad& cell : cells)
    for (int a = 0; a < 3; ++a)
      for (int b = a + 1; b < 4; ++b)
        if (labels[cell[a]] == labels[cell[b]]) sets.join(cell[a], cell[b]);
  return sets.numbers();
}

}  // namespace symrecon
