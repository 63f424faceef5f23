#include "regular_triangulation.hpp"

#include <algorithm>

#include "predicates.hpp"
#include "scaling.hpp"
#include "spatial_order.hpp"
#include "triangulator.hpp"

namespace symrecon {

namespace {

// The first four sites that span three dimensions, as far as they exist.
int find_simplex(const std::vector<Site>& sites, const Margins& margins, Four& simplex) {
  int rank = -1;
  for (std::int32_t i = 0; i < std::int32_t(sites.size()) && rank < 3; ++i) {
    const Site& site = sites[i];
    const bool wider = rank < 1 || (rank == 1 ? !collinear(sites[simplex[0]], sites[simplex[1]], site)
                                              : orientation(sites[simplex[0]], sites[simplex[1]], sites[simplex[2]],
                                                            site, margins) != 0);
    if (wider) simplex[++rank] = i;
  }
  return std::max(rank, 0);
}

// Sites in order of insertion without those at a position that came before.
struct Distinct {
  std::vector<Site> sites;
  std::vector<std::int32_t> original;        // per distinct site: index in the input
  std::vector<std::int32_t> representative;  // per input site
};

Distinct distinct_in_order(const std::vector<Site>& sites, const Progress& progress) {
  Distinct distinct;
  distinct.representative.resize(sites.size());
  distinct.sites.reserve(sites.size());
  distinct.original.reserve(sites.size());
  for (std::int32_t index : spatial_order(sites, progress)) {
    if (distinct.sites.empty() || !same_position(distinct.sites.back(), sites[index])) {
      distinct.sites.push_back(sites[index]);
      distinct.original.push_back(index);
    }
    distinct.representative[index] = distinct.original.back();
  }
  return distinct;
}

// Consecutive numbers for the finite cells in the order of their first sites, -1 for others. Sites that are near each
// other in the input are likely to be near in space; then so are cells, for everybody who passes over them later.
std::vector<std::int32_t> number_finite_cells(const CellComplex& complex, const std::vector<std::int32_t>& original,
                                              std::size_t sites, std::size_t& count) {
  const auto first_site = [&](std::int32_t i) {
    const Four& vertex = complex[i].vertex;
    return std::min(std::min(original[vertex[0]], original[vertex[1]]),
                    std::min(original[vertex[2]], original[vertex[3]]));
  };
  std::vector<std::int32_t> number(complex.size(), -1), next(sites + 1, 0);
  for (std::int32_t i = 0; i < complex.size(); ++i)
    if (complex.exists(i) && !complex[i].is_infinite()) ++next[number[i] = first_site(i)];
  count = 0;
  for (std::int32_t& start : next) {
    const std::int32_t cells = start;
    start = std::int32_t(count);
    count += cells;
  }
  for (std::int32_t& entry : number)
    if (entry >= 0) entry = next[entry]++;
  return number;
}

}  // namespace

RegularTriangulation regular_triangulation(std::vector<Site> sites, const Progress& progress) {
  RegularTriangulation result;
  if (sites.empty()) return result;
  for (Site& site : sites) {  // -0.0 and 0.0 are one position
    site.x += 0.0;
    site.y += 0.0;
    site.z += 0.0;
  }
  if (progress) progress(0.0);
  const std::size_t total = sites.size();
  const Margins margins = bring_to_usual_size(sites);
  Distinct distinct = distinct_in_order(sites, progress);
  std::vector<Site>().swap(sites);
  result.representative.swap(distinct.representative);
  result.hidden_cell.assign(total, -1);

  Four simplex = {0, 0, 0, 0};
  result.rank = find_simplex(distinct.sites, margins, simplex);
  if (result.rank < 3) return result;
  Triangulator triangulator(distinct.sites, margins);
  triangulator.build(simplex, progress);

  std::size_t count;
  const std::vector<std::int32_t> number = number_finite_cells(triangulator.complex(), distinct.original, total, count);
  for (std::int32_t i = 0; i < std::int32_t(distinct.sites.size()); ++i) {
    if (i % insertions_per_report == 0 && progress) progress(1.0);
    if (triangulator.is_hidden(i)) result.hidden_cell[distinct.original[i]] = number[triangulator.locate(i)];
  }
  result.cells = triangulator.complex().numbered_vertices(number, count);
  for (Four& cell : result.cells)
    for (std::int32_t& vertex : cell) vertex = distinct.original[vertex];
  if (progress) progress(1.0);
  result.neighbours = triangulator.complex().take_numbered_neighbours(number, count, [&] {
    if (progress) progress(1.0);
  });
  if (progress) progress(1.0);
  return result;
}

}  // namespace symrecon
