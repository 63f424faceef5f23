#include "mirror_pairs.hpp"

#include <cmath>

#include "vectors.hpp"

namespace symrecon {

std::vector<std::array<std::int32_t, 2>> mirror_pairs(View<Position> points, View<Position> normals,
                                                      View<std::uint8_t> oriented, double shortest,
                                                      double least_cosine) {
  std::vector<std::array<std::int32_t, 2>> pairs;
  for (std::size_t i = 0; i < points.size(); ++i)
    for (std::size_t j = i + 1; j < points.size(); ++j) {
      const Position apart = minus(points[i], points[j]);
      const double square = dot(apart, apart);
      // (I - 2 n n^T) N_i . N_j  with  n = (p_i - p_j) / |p_i - p_j|,  times the square
      const double cosine =
          dot(normals[i], normals[j]) * square - 2.0 * dot(apart, normals[i]) * dot(apart, normals[j]);
      const double judged = oriented[i] && oriented[j] ? cosine : std::abs(cosine);
      if (square > shortest * shortest && judged > least_cosine * square)
        pairs.push_back({std::int32_t(i), std::int32_t(j)});
    }
  return pairs;
}

}  // namespace symrecon
