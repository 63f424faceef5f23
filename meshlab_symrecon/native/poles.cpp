#include "poles.hpp"

#include <cmath>
#include <limits>

namespace symrecon {
namespace {

Position arm(const Position& from, const Position& to) {
  return {to[0] - from[0], to[1] - from[1], to[2] - from[2]};
}

double dot(const Position& a, const Position& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

// The four nearest of the neighbours offered, each once, nearest first.
struct Nearest {
  std::array<double, 4> square;
  std::array<std::int32_t, 4> who;

  Nearest() {
    square.fill(std::numeric_limits<double>::infinity());
    who.fill(-1);
  }

  void offer(std::int32_t other, double distance) {
    if (distance > square[3]) return;
    int place = 0;
    for (; place < 4 && square[place] <= distance; ++place)
      if (who[place] == other) return;
    if (place == 4) return;
    for (int k = 3; k > place; --k) {
      square[k] = square[k - 1];
      who[k] = who[k - 1];
    }
    square[place] = distance;
    who[place] = other;
  }
};

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

Spacings sample_spacings(const std::vector<Position>& sites, const std::vector<Quad>& cells,
                         std::int32_t samples) {
  std::vector<Nearest> nearest(samples);
  for (const Quad& cell : cells)
    for (int a = 0; a < 3; ++a)
      for (int b = a + 1; b < 4; ++b) {
        if (cell[a] >= samples || cell[b] >= samples) continue;
        const Position apart = arm(sites[cell[a]], sites[cell[b]]);
        const double square = dot(apart, apart);
        nearest[cell[a]].offer(cell[b], square);
        nearest[cell[b]].offer(cell[a], square);
      }
  Spacings spacings{std::vector<double>(samples), std::vector<double>(samples)};
  for (std::int32_t sample = 0; sample < samples; ++sample) {
    const Nearest& found = nearest[sample];
    double sum = 0.0;
    int count = 0;
    for (; count < 4 && found.who[count] >= 0; ++count) sum += std::sqrt(found.square[count]);
    spacings.next[sample] = std::sqrt(found.square[0]);
    spacings.mean[sample] = count > 0 ? sum / count : found.square[0];
  }
  return spacings;
}

}  // namespace symrecon
