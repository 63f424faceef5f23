// Stage 2 of the power test, on machines with and without a fused multiply-add.
#include "paired_lanes.hpp"
#include "predicates.hpp"

#if (defined(__GNUC__) || defined(__clang__)) && defined(__x86_64__)
#define SYMRECON_ASK_FOR_FMA
#define SYMRECON_WITH_FMA __attribute__((target("avx2,fma")))
#elif defined(__FP_FAST_FMA) || defined(__ARM_FEATURE_FMA)
#define SYMRECON_WITH_FMA
#endif

namespace symrecon {

namespace {

#if defined(SYMRECON_WITH_FMA)
struct Fused {
  static SYMRECON_INLINE Lanes error_of_product(const Lanes& a, const Lanes& b, const Lanes& product) {
    return Lanes{__builtin_fma(a[0], b[0], -product[0]), __builtin_fma(a[1], b[1], -product[1]),
                 __builtin_fma(a[2], b[2], -product[2]), __builtin_fma(a[3], b[3], -product[3])};
  }
};
#endif

// The determinant of predicates.hpp with the rows of a, b, c, d in the four lanes.
template <class Machine>
SYMRECON_INLINE double power_determinant(const Site& a, const Site& b, const Site& c, const Site& d, const Site& e) {
  using Number = Pairs<Machine>;
  const Number x = difference<Machine>(Lanes{a.x, b.x, c.x, d.x}, Lanes{e.x, e.x, e.x, e.x});
  const Number y = difference<Machine>(Lanes{a.y, b.y, c.y, d.y}, Lanes{e.y, e.y, e.y, e.y});
  const Number z = difference<Machine>(Lanes{a.z, b.z, c.z, d.z}, Lanes{e.z, e.z, e.z, e.z});
  const Number weight = difference<Machine>(Lanes{a.weight, b.weight, c.weight, d.weight},
                                             Lanes{e.weight, e.weight, e.weight, e.weight});
  const Number lift = ((x * x + y * y) + z * z) - weight;                // lambda 6, delta 35
  const Number next = x * turned<1>(y) - turned<1>(x) * y;               // ab, bc, cd, da: lambda 4, delta 15
  const Number opposite = x * turned<2>(y) - turned<2>(x) * y;           // ac, bd, ca, db
  const Number minor = (turned<1>(z) * turned<2>(next) - turned<2>(z) * turned<1>(opposite)) +
                       turned<3>(z) * turned<1>(next);                   // bcd, cda, dab, abc: lambda 8, delta 63
  const Number term = lift * minor;                                      // lambda 15, delta 189
  const Number half = term - turned<1>(term);                            // lanes 0 and 2: lambda 16, delta 220
  const Number whole = half + turned<2>(half);                           // lambda 17, delta 253
  return whole.high[0] + whole.low[0];
}

double power_determinant_by_splitting(const Site& a, const Site& b, const Site& c, const Site& d, const Site& e) {
  return power_determinant<Splitting>(a, b, c, d, e);
}

#if defined(SYMRECON_WITH_FMA)
SYMRECON_WITH_FMA double power_determinant_by_fma(const Site& a, const Site& b, const Site& c, const Site& d,
                                                  const Site& e) {
  return power_determinant<Fused>(a, b, c, d, e);
}
#endif

}  // namespace

bool has_fma() {
#if defined(SYMRECON_ASK_FOR_FMA)
  return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
#elif defined(SYMRECON_WITH_FMA)
  return true;
#else
  return false;
#endif
}

double fine_power_determinant(const Site& a, const Site& b, const Site& c, const Site& d, const Site& e, bool fused) {
#if defined(SYMRECON_WITH_FMA)
  if (fused) return power_determinant_by_fma(a, b, c, d, e);
#endif
  (void)fused;
  return power_determinant_by_splitting(a, b, c, d, e);
}

int fine_power_test(const Site& a, const Site& b, const Site& c, const Site& d, const Site& e, double bound) {
  return certified_sign(fine_power_determinant(a, b, c, d, e, has_fma()), bound);
}

}  // namespace symrecon
