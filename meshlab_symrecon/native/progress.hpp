// How long work tells how far it is, and learns that nobody waits for it any more.
#pragma once

#include <cstdint>
#include <functional>

namespace symrecon {

// Called several times a second with the share of sites inserted, before the first and after the last one too; may
// throw to stop the work.
using Progress = std::function<void(double)>;

inline constexpr std::int32_t insertions_per_report = 1 << 14;

}  // namespace symrecon
