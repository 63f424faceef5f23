#include "poles.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "prefetch.hpp"

namespace symrecon {
namespace {

// A sample amid three in its plane may have no other neighbour near: the fourth then lies across the body.
constexpr double kFarFourth = 3.0;  // distances of the third

Point arm(const Site& from, const Point& to) { return {to.x - from.x, to.y - from.y, to.z - from.z}; }

double dot(const Point& a, const Point& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

double square_distance(const Site& a, const Site& b) {
  const Point apart = {b.x - a.x, b.y - a.y, b.z - a.z};
  return dot(apart, apart);
}

// A hint that the entries of a cell's samples will be read soon: neighbours in space are far apart in memory, and a
// million of them do not fit the cache.
template <class Entry>
void announce(const std::vector<Entry>& entries, const Quad& cell) {
  for (const std::int32_t sample : cell) prefetch(entries.data() + sample);
}

// Distances whose squares would be lost; spacings are divided by.
constexpr double kLeastDistance = 0x1p-500;

constexpr std::size_t ahead_of_use = 8;  // cells

// What one sample knows of its poles; together, since a pass over the cells visits the samples at random.
struct Search {
  double farthest = -1.0;
  Point ahead = {0.0, 0.0, 0.0};  // from the sample to its first pole
  double farthest_behind = -1.0;
  std::int32_t first = -1, second = -1;
};

std::vector<Point> find_first(const std::vector<Site>& sites, View<Quad> cells,
                              std::vector<Search>& searches, const Checkpoint& checkpoint) {
  std::vector<Point> centres(cells.size());
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (i % cells_per_checkpoint == 0) checkpoint();
    const Quad& soon = cells[std::min(i + ahead_of_use, cells.size() - 1)];
    announce(sites, soon);
    announce(searches, soon);
    const Quad& cell = cells[i];
    centres[i] = orthocentre(sites[cell[0]], sites[cell[1]], sites[cell[2]], sites[cell[3]]);
    for (const std::int32_t sample : cell) {
      if (std::size_t(sample) >= searches.size()) continue;
      Search& search = searches[sample];
      const Point reach = arm(sites[sample], centres[i]);
      const double square = dot(reach, reach);
      if (square > search.farthest) {
        search.farthest = square;
        search.ahead = reach;
        search.first = std::int32_t(i);
      }
    }
  }
  return centres;
}

void find_second(const std::vector<Site>& sites, View<Quad> cells, const std::vector<Point>& centres,
                 std::vector<Search>& searches, const Checkpoint& checkpoint) {
  for (std::size_t i = 0; i < centres.size(); ++i) {
    if (i % cells_per_checkpoint == 0) checkpoint();
    const Quad& soon = cells[std::min(i + ahead_of_use, centres.size() - 1)];
    announce(sites, soon);
    announce(searches, soon);
    for (const std::int32_t sample : cells[i]) {
      if (std::size_t(sample) >= searches.size()) continue;
      Search& search = searches[sample];
      const Point reach = arm(sites[sample], centres[i]);
      const double square = dot(reach, reach);
      if (square > search.farthest_behind && dot(reach, search.ahead) <= 0.0) {
        search.farthest_behind = square;
        search.second = std::int32_t(i);
      }
    }
  }
}

// The four nearest of the neighbours offered, each once, nearest first.
struct Nearest {
  std::array<double, 4> square;
  std::array<std::int32_t, 4> who;

  Nearest() {
    square.fill(std::numeric_limits<double>::infinity());
    who.fill(-1);
  }

  void offer(std::int32_t other, double distance) {
    // one branch, nearly always taken: an edge is offered by each of the cells round it
    const bool known = (who[0] == other) | (who[1] == other) | (who[2] == other) | (who[3] == other);
    if (known | !(distance < square[3])) return;
    int place = 3;
    for (; place > 0 && distance < square[place - 1]; --place) {
      square[place] = square[place - 1];
      who[place] = who[place - 1];
    }
    square[place] = distance;
    who[place] = other;
  }
};

}  // namespace

FoundPoles find_poles(const std::vector<Site>& sites, View<Quad> cells,
                      std::int32_t samples, const Checkpoint& checkpoint) {
  std::vector<Search> searches(samples);
  const std::vector<Point> centres = find_first(sites, cells, searches, checkpoint);
  find_second(sites, cells, centres, searches, checkpoint);
  FoundPoles poles;
  std::vector<std::int32_t> number(cells.size(), -1);
  for (const Search& search : searches)
    for (const std::int32_t cell : {search.first, search.second})
      if (cell >= 0) number[cell] = 0;
  for (std::size_t cell = 0; cell < cells.size(); ++cell) {
    if (number[cell] < 0) continue;
    number[cell] = std::int32_t(poles.cells.size());
    poles.cells.push_back(std::int32_t(cell));
    poles.centres.push_back(centres[cell]);
  }
  const auto pole_of = [&](std::int32_t cell) { return cell < 0 ? std::int32_t(-1) : number[cell]; };
  poles.first.reserve(samples);
  poles.second.reserve(samples);
  for (const Search& search : searches) {
    poles.first.push_back(pole_of(search.first));
    poles.second.push_back(pole_of(search.second));
  }
  return poles;
}

Spacings sample_spacings(const std::vector<Site>& sites, View<Quad> cells,
                         std::int32_t samples, const Checkpoint& checkpoint) {
  std::vector<Nearest> nearest(samples);
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (i % cells_per_checkpoint == 0) checkpoint();
    const Quad& soon = cells[std::min(i + ahead_of_use, cells.size() - 1)];
    announce(sites, soon);
    announce(nearest, soon);
    const Quad& cell = cells[i];
    for (int a = 0; a < 3; ++a)
      for (int b = a + 1; b < 4; ++b) {
        if (cell[a] >= samples || cell[b] >= samples) continue;
        const double square = square_distance(sites[cell[a]], sites[cell[b]]);
        nearest[cell[a]].offer(cell[b], square);
        nearest[cell[b]].offer(cell[a], square);
      }
  }
  Spacings spacings{std::vector<double>(samples), std::vector<double>(samples)};
  for (std::int32_t sample = 0; sample < samples; ++sample) {
    const Nearest& found = nearest[sample];
    double sum = 0.0;
    int count = 0;
    for (; count < 4 && found.who[count] >= 0; ++count) {
      if (count == 3 && found.square[3] > kFarFourth * kFarFourth * found.square[2]) break;
      sum += std::sqrt(found.square[count]);
    }
    spacings.next[sample] = std::max(std::sqrt(found.square[0]), kLeastDistance);
    spacings.mean[sample] = count > 0 ? std::max(sum / count, kLeastDistance) : found.square[0];
  }
  return spacings;
}

}  // namespace symrecon
