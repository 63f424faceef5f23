#include "scaling.hpp"

#include <algorithm>
#include <cmath>

namespace symrecon {

namespace {

constexpr int usual_bits = 100;  // extents of 2^-100 .. 2^100 are usual, see Margins::safe

// Half the widest range of coordinates, or the root of a quarter of the range of the weights: overflow-free.
double extent_of(const std::vector<Site>& sites) {
  Site low = sites.front(), high = low;
  for (const Site& site : sites) {
    low = {std::min(low.x, site.x), std::min(low.y, site.y), std::min(low.z, site.z), std::min(low.weight, site.weight)};
    high = {std::max(high.x, site.x), std::max(high.y, site.y), std::max(high.z, site.z),
            std::max(high.weight, site.weight)};
  }
  const double sides[3] = {0.5 * high.x - 0.5 * low.x, 0.5 * high.y - 0.5 * low.y, 0.5 * high.z - 0.5 * low.z};
  const double weights = std::sqrt(0.25 * high.weight - 0.25 * low.weight);
  return std::max(std::max(sides[0], sides[1]), std::max(sides[2], weights));
}

bool rescale(std::vector<Site>& sites, int exponent) {
  const auto exactly = [](double& value, int power) {
    const double scaled = std::ldexp(value, power);
    const bool exact = std::isfinite(scaled) && std::ldexp(scaled, -power) == value;
    value = scaled;
    return exact;
  };
  std::vector<Site> scaled = sites;
  for (Site& site : scaled)
    if (!(exactly(site.x, exponent) && exactly(site.y, exponent) && exactly(site.z, exponent) &&
          exactly(site.weight, 2 * exponent)))
      return false;
  sites.swap(scaled);
  return true;
}

// Binary exponent of the extent; zero when all sites are equal.
int size_of(const std::vector<Site>& sites) {
  const double extent = extent_of(sites);
  int exponent = 0;
  if (extent != 0.0) std::frexp(extent, &exponent);
  return exponent;
}

}  // namespace

Margins margins_for(const std::vector<Site>& sites) {
  return size_of(sites) < usual_bits ? Margins::safe() : Margins::never();
}

Margins bring_to_usual_size(std::vector<Site>& sites) {
  const int size = size_of(sites);
  if (std::abs(size) >= usual_bits) rescale(sites, -size);
  return margins_for(sites);
}

}  // namespace symrecon
