// The opposite poles of each pole, with what is known of each pair.
#pragma once

#include <cstdint>
#include <numeric>
#include <vector>

#include "view.hpp"

namespace symrecon {

struct OppositePoles {
  struct Arc {
    std::int32_t pole;
    double value;
  };
  std::vector<std::int64_t> offsets;  // those of pole i are arcs[offsets[i]] .. arcs[offsets[i + 1] - 1]
  std::vector<Arc> arcs;

  OppositePoles(std::size_t poles, View<std::int32_t> first, View<std::int32_t> second,
                View<double> values)
      : offsets(poles + 1, 0), arcs(2 * first.size()) {
    for (std::size_t k = 0; k < first.size(); ++k) {
      ++offsets[first[k] + 1];
      ++offsets[second[k] + 1];
    }
    std::partial_sum(offsets.begin(), offsets.end(), offsets.begin());
    std::vector<std::int64_t> next(offsets.begin(), offsets.end() - 1);
    for (std::size_t k = 0; k < first.size(); ++k) {
      arcs[next[first[k]]++] = {second[k], values[k]};
      arcs[next[second[k]]++] = {first[k], values[k]};
    }
  }
};

}  // namespace symrecon
