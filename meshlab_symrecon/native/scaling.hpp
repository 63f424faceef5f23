// Sites of unusual size are brought near 1, where the floating-point stages of the predicates work.
#pragma once

#include <vector>

#include "predicates.hpp"
#include "site.hpp"

namespace symrecon {

// Margins with which the predicates are right for differences between these sites (at least one).
Margins margins_for(const std::vector<Site>& sites);

// Multiply by a power of two (weights by its square) when the sites are unusually large or small and that loses no
// bit; return the margins for the result.
Margins bring_to_usual_size(std::vector<Site>& sites);

}  // namespace symrecon
