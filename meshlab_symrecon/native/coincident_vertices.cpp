// Vertices of the crust at one place: joined where that keeps the manifold, moved apart where it does not.
#include <algorithm>
#include <cmath>

#include "contraction.hpp"
#include "position_table.hpp"
#include "vectors.hpp"

namespace symrecon {
namespace {

constexpr double kStepAside = 0.01;  // of the way to the mean of the neighbours
constexpr double kNoStep = 1e-4;     // of the way to the farthest neighbour: no step at all
constexpr int kSteps = 16;           // aside, at the most

}  // namespace

bool Contraction::join_at(std::int32_t hub) {
  walk(hub);
  for (const Spoke& spoke : spokes_)
    if (spoke.squared == 0.0 && link_condition(spoke.vertex)) {
      halves_.contract(spoke.half);
      return true;
    }
  return false;
}

// Vertices at one sample that do not form a disc: edge by edge, again and again, since an edge that is
// refused may be free once its neighbours are gone.
void Contraction::join_coincident() {
  std::vector<std::int32_t> doubled, first(samples_.spacing.size(), -1);
  for (std::int32_t vertex = 0; vertex < count(); ++vertex) {
    if (!halves_.exists(vertex) || !is_at_sample(vertex)) continue;
    std::int32_t& keeper = first[nearest_[vertex]];
    if (keeper < 0) keeper = vertex;
    else doubled.push_back(vertex);
  }
  std::size_t before;
  do {
    before = doubled.size();
    doubled.erase(std::remove_if(doubled.begin(), doubled.end(), [&](std::int32_t vertex) { return join_at(vertex); }),
                  doubled.end());
  } while (doubled.size() < before);
}

// Vertices at one place that could not be joined: all but the first, a sample if there is one, move a
// little towards their neighbours, so that no reader joins them and pinches the surface.
void Contraction::part_coincident() {
  std::size_t living = 0;
  double largest = 0.0;
  for (std::int32_t vertex = 0; vertex < count(); ++vertex) {
    if (!halves_.exists(vertex)) continue;
    ++living;
    for (const double coordinate : points_[vertex]) largest = std::max(largest, std::fabs(coordinate));
  }
  PositionTable table(living, largest);
  std::vector<std::int32_t> doubled;
  for (const bool samples : {true, false})
    for (std::int32_t vertex = 0; vertex < count(); ++vertex)
      if (halves_.exists(vertex) && is_at_sample(vertex) == samples && !table.enter(points_, vertex))
        doubled.push_back(vertex);
  // again and again, since a vertex among vertices of its own place cannot move before them
  for (int step = 0; step < kSteps && !doubled.empty(); ++step)
    doubled.erase(std::remove_if(doubled.begin(), doubled.end(),
                                 [&](std::int32_t vertex) {
                                   step_aside(vertex);
                                   return table.enter(points_, vertex);
                                 }),
                  doubled.end());
}

// Towards the mean of the neighbours; from there, towards the farthest of them.
void Contraction::step_aside(std::int32_t vertex) {
  walk(vertex);
  Position target{0.0, 0.0, 0.0};
  for (const Spoke& spoke : spokes_)
    for (int axis = 0; axis < 3; ++axis) target[axis] += spoke.tip[axis] / static_cast<double>(spokes_.size());
  const Position before = points_[vertex];
  const auto step = [&](const Position& end) {
    for (int axis = 0; axis < 3; ++axis) points_[vertex][axis] += kStepAside * (end[axis] - before[axis]);
  };
  step(target);
  const Spoke& farthest = *std::max_element(
      spokes_.begin(), spokes_.end(), [](const Spoke& a, const Spoke& b) { return a.squared < b.squared; });
  const Position moved = minus(points_[vertex], before);
  if (dot(moved, moved) < kNoStep * kNoStep * farthest.squared) step(farthest.tip);
}

}  // namespace symrecon
