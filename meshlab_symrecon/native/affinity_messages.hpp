// The messages of affinity propagation (Frey and Dueck, "Clustering by passing messages between data points", 2007).
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "progress.hpp"
#include "view.hpp"

namespace symrecon {

// Similarities s(i, k) along the edges that there are, in rows; the first edge of row i leads to i itself.
struct SparseSimilarities {
  View<std::int64_t> offsets;  // n + 1
  View<std::int32_t> targets;
  View<double> values;

  std::size_t size() const { return offsets.size() - 1; }
  std::size_t first(std::size_t i) const { return offsets[i]; }
  std::size_t count(std::size_t i) const { return offsets[i + 1] - offsets[i]; }
  std::size_t own(std::size_t) const { return 0; }
  std::size_t target(std::size_t i, std::size_t place) const { return targets[offsets[i] + place]; }
};

// Similarities between all: row i leads to 0 .. n - 1.
struct DenseSimilarities {
  std::size_t points;
  View<double> values;

  std::size_t size() const { return points; }
  std::size_t first(std::size_t i) const { return i * points; }
  std::size_t count(std::size_t) const { return points; }
  std::size_t own(std::size_t i) const { return i; }
  std::size_t target(std::size_t, std::size_t place) const { return place; }
};

struct MessageSchedule {
  double damping;     // share of the old message kept
  std::int32_t most;  // iterations
  std::int32_t calm;  // iterations with the same exemplars that count as converged
};

struct Exemplars {
  std::vector<std::uint8_t> chosen;  // at least one, even when stopped early
  std::vector<double> needed;        // an edge of row i that is no more similar would never have changed a message
  bool converged = false;
  std::int32_t iterations = 0;
  double damping = 0.0;  // in the end: oscillation raises it
};

Exemplars propagate_affinity(const SparseSimilarities& similarities, const MessageSchedule& schedule,
                             const Checkpoint& checkpoint);
Exemplars propagate_affinity(const DenseSimilarities& similarities, const MessageSchedule& schedule,
                             const Checkpoint& checkpoint);

}  // namespace symrecon
