// How long work tells how far it is, and learns that nobody waits for it any more.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>

namespace symrecon {

// Called several times a second with the share of the work done; may throw to stop it.
using Progress = std::function<void(double)>;

// Called several times a second; may throw to stop the work.
using Checkpoint = std::function<void()>;

inline constexpr std::size_t cells_per_checkpoint = std::size_t(1) << 18;
inline constexpr std::int32_t insertions_per_report = 1 << 14;

}  // namespace symrecon
