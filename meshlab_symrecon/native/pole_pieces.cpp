#include "pole_pieces.hpp"

#include <algorithm>

#include "disjoint_sets.hpp"

namespace symrecon {
namespace {

// The piece of each site, connected by edges of the cells between sites of equal label.
std::vector<std::int32_t> label_pieces(View<Quad> cells, View<std::uint8_t> labels) {
  DisjointSets sets(labels.size());
  for (const Quad& cell : cells) {
    std::int32_t first[2] = {-1, -1};  // corner of each label; the others of that label join it
    for (const std::int32_t site : cell) {
      std::int32_t& root = first[labels[site] != 0];
      if (root < 0)
        root = site;
      else
        sets.join(root, site);
    }
  }
  return sets.numbers();
}

struct Pieces {
  std::vector<std::int32_t> of;     // site -> piece
  std::vector<std::int64_t> sizes;  // samples
  std::vector<std::uint8_t> kept;
};

// Turn over the small pieces of one label; false when there are none.
bool turn(std::vector<std::uint8_t>& labels, const Pieces& pieces, std::uint8_t label) {
  bool turned = false;
  for (std::size_t i = 0; i < labels.size(); ++i)
    if (labels[i] == label && !pieces.kept[pieces.of[i]]) {
      labels[i] = 1 - label;
      turned = true;
    }
  return turned;
}

Pieces measure(View<Quad> cells, View<std::uint8_t> labels, View<std::uint8_t> fixed,
               View<std::int32_t> samples, double smallest) {
  Pieces pieces;
  pieces.of = label_pieces(cells, labels);
  const std::size_t count =
      pieces.of.empty() ? 0 : 1 + *std::max_element(pieces.of.begin(), pieces.of.end());
  pieces.sizes.assign(count, 0);
  for (std::size_t i = 0; i < labels.size(); ++i) pieces.sizes[pieces.of[i]] += samples[i];
  pieces.kept.assign(count, 0);
  for (std::size_t k = 0; k < count; ++k)
    pieces.kept[k] = static_cast<double>(pieces.sizes[k]) >= smallest;
  for (std::size_t i = 0; i < labels.size(); ++i)
    if (fixed[i]) pieces.kept[pieces.of[i]] = 1;
  return pieces;
}

void keep_largest_island(Pieces& pieces, const std::vector<std::uint8_t>& labels) {
  std::int32_t largest = -1;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    const std::int32_t piece = pieces.of[i];
    if (labels[i] && (largest < 0 || pieces.sizes[piece] > pieces.sizes[largest] ||
                      (pieces.sizes[piece] == pieces.sizes[largest] && piece < largest)))
      largest = piece;
  }
  if (largest >= 0) pieces.kept[largest] = 1;
}

}  // namespace

std::vector<std::uint8_t> turn_small_pieces(View<Quad> cells, View<std::uint8_t> labels,
                                            View<std::uint8_t> fixed, View<std::int32_t> samples,
                                            double smallest) {
  std::vector<std::uint8_t> turned(labels.begin(), labels.end());
  Pieces pieces = measure(cells, turned, fixed, samples, smallest);
  keep_largest_island(pieces, turned);
  if (turn(turned, pieces, 1)) pieces = measure(cells, turned, fixed, samples, smallest);
  turn(turned, pieces, 0);
  return turned;
}

}  // namespace symrecon
