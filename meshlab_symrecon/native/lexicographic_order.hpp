// Distinct points in lexicographic order.
#pragma once

#include <cstdint>
#include <vector>

namespace symrecon {

// Indices of the points (rows x, y, z; finite) in lexicographic order, of equal ones only the first. Zeros of either
// sign are equal.
std::vector<std::int32_t> lexicographic_order(const double* points, std::size_t count);

}  // namespace symrecon
