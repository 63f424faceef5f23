// The messages of affinity propagation (Frey and Dueck, "Clustering by passing messages between data points", 2007).
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "progress.hpp"
#include "view.hpp"

namespace symrecon {

// Similarities s(i, k) along some edges, in rows of equal length by falling similarity; the first edge of row i leads to
// i itself, and its similarity is the preference.  An edge with a similarity of minus infinity does not exist.
struct EdgeTable {
  std::size_t width = 0;
  View<std::int32_t> targets;
  View<double> similarities;
};

// Longer rows for some points, or a table of width 0 when there is no room for them.  What it looks at stays valid until
// the next call.
using MoreEdges = std::function<EdgeTable(const std::vector<std::int32_t>& points, std::size_t width)>;

struct MessageSchedule {
  double damping;     // share of the old message kept
  std::int32_t most;  // iterations
  std::int32_t calm;  // iterations with the same exemplars that count as converged
};

struct Exemplars {
  std::vector<std::uint8_t> chosen;   // at least one, even when stopped early
  std::vector<std::uint8_t> earlier;  // those of `calm` iterations before a stop at the limit; none if there were fewer
  bool converged = false;
  bool exact = true;  // no edge was missing that could have changed a message
  std::int32_t iterations = 0;
  double damping = 0.0;   // in the end: oscillation raises it
  std::size_t edges = 0;  // in the end
};

// Messages along the edges of the table.  `more`, if given, is asked for longer rows where the least similar edge is not
// certainly without influence, so that the messages are those between all points.
Exemplars propagate_sparse_affinity(const EdgeTable& table, const MessageSchedule& schedule, const MoreEdges& more,
                                    const Checkpoint& checkpoint);

// Messages between all points: `similarities` is square, with the preferences on its diagonal.
Exemplars propagate_dense_affinity(std::size_t points, View<double> similarities, const MessageSchedule& schedule,
                                   const Checkpoint& checkpoint);

}  // namespace symrecon
