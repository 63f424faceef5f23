// Long loops that report how far they are, and that can be stopped.
#pragma once

#include <algorithm>
#include <cstddef>

#include "progress.hpp"

namespace symrecon {

class Patience {
 public:
  Patience(const Progress& report, std::size_t work)
      : report_(report), work_(std::max<std::size_t>(1, work)) {}

  // To be called once a step.  More steps than expected report as all of them.
  void step() {
    if ((++done_ & 0xfff) == 0 && report_)
      report_(std::min(1.0, static_cast<double>(done_) / static_cast<double>(work_)));
  }

 private:
  const Progress& report_;
  std::size_t work_;
  std::size_t done_ = 0;
};

}  // namespace symrecon
