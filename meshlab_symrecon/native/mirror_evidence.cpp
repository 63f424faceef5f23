#include "mirror_evidence.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace symrecon {
namespace {

constexpr double tiny = std::numeric_limits<double>::min();

// A mirror image beside the surface point it falls on.
struct Landing {
  double distance;      // to that point
  double off_square;    // to its tangent plane, squared
  double aside_square;  // along that plane, squared
  double cosine;        // between the normals
  double border_distance;
  bool broken_off;  // it lies where the cloud is known to end
};

Landing land(const SurfacePoint& query, const Image& image, const SurfacePoint& partner, const Position& normal,
             const EvidenceRules& rules) {
  const Position gap = minus(image.place, partner.place);
  const double square = dot(gap, gap), off = dot(gap, partner.normal);
  const double cosine = mirrored_cosine(query.normal, partner.normal, normal);
  return {std::sqrt(square), off * off, std::max(square - off * off, 0.0),
          query.oriented && partner.oriented ? cosine : std::abs(cosine), partner.border_distance,
          rules.broken_off.height(image.place) < 0.0};
}

// How well an image matches the surface, 0 to 1.
double match(const Landing& landing, const EvidenceRules& rules) {
  if (landing.aside_square > rules.sideways * rules.sideways) return 0.0;
  const double direction = ramp(landing.cosine, rules.no_direction, rules.full_direction);
  if (direction == 0.0) return 0.0;
  return direction * std::exp(-0.5 * landing.off_square / (rules.tolerance * rules.tolerance));
}

// Points near the plane match themselves.
double weight(double height, const EvidenceRules& rules) { return std::min(1.0, std::abs(height) / rules.near_plane); }

bool near_rim(const Landing& landing, const EvidenceRules& rules) {
  return landing.border_distance <= rules.rim_reach * landing.distance;
}

enum Excuse : std::uint8_t { none, hole, broken_off };

// The image may have fallen into a hole, or is known to have.
Excuse excuse(const Landing& landing, double worth, const EvidenceRules& rules) {
  if (worth >= rules.no_match) return none;
  if (landing.broken_off) return broken_off;
  return landing.distance > rules.least_gap && near_rim(landing, rules) ? hole : none;
}

bool contradicts(const Landing& landing, const EvidenceRules& rules) {
  return landing.distance > rules.far && landing.distance < rules.beyond && !near_rim(landing, rules) &&
         !landing.broken_off;
}

struct Sums {
  double total = 0.0, judged = 0.0;  // weights of all queries, and of those that no hole excuses
  double matched = 0.0, agreed = 0.0, contradicted = 0.0, squares = 0.0;

  Evidence shares() const {
    return {matched / std::max(total, tiny), agreed / std::max(judged, tiny), contradicted / std::max(total, tiny),
            std::sqrt(squares / std::max(matched, tiny))};
  }
};

Evidence judge(const Plane& plane, const MirrorCloud& cloud, View<SurfacePoint> queries, View<Image> images,
               View<double> distinctness, const EvidenceRules& rules) {
  Sums sums;
  for (std::size_t i = 0; i < queries.size(); ++i) {
    const Landing landing = land(queries[i], images[i], cloud.points[images[i].partner], plane.normal, rules);
    const double counts = weight(images[i].height, rules), worth = match(landing, rules);
    sums.total += counts;
    sums.matched += counts * worth;
    sums.squares += counts * worth * landing.off_square;
    if (excuse(landing, worth, rules) == none) {
      sums.judged += counts;
      sums.agreed += counts * worth;
    }
    if (contradicts(landing, rules)) sums.contradicted += counts * distinctness[i];
  }
  return sums.shares();
}

}  // namespace

std::vector<Evidence> examine(View<Plane> planes, const MirrorCloud& cloud, View<std::int32_t> queries,
                              View<double> distinctness, const EvidenceRules& rules) {
  std::vector<SurfacePoint> asked;
  for (const std::int32_t query : queries) asked.push_back(cloud.points[query]);
  std::vector<Evidence> found;
  std::vector<Image> images;
  for (const Plane& plane : planes) {
    cast_images(plane, cloud, asked, std::numeric_limits<double>::infinity(), images);
    found.push_back(judge(plane, cloud, asked, images, distinctness, rules));
  }
  return found;
}

Landings landings(View<Plane> planes, const MirrorCloud& cloud, View<std::int32_t> queries,
                  const EvidenceRules& rules) {
  std::vector<SurfacePoint> asked;
  for (const std::int32_t query : queries) asked.push_back(cloud.points[query]);
  Landings found;
  std::vector<Image> images;
  for (const Plane& plane : planes) {
    cast_images(plane, cloud, asked, std::numeric_limits<double>::infinity(), images);
    for (std::size_t i = 0; i < asked.size(); ++i) {
      const Landing landing = land(asked[i], images[i], cloud.points[images[i].partner], plane.normal, rules);
      const double worth = match(landing, rules);
      found.partners.push_back(images[i].partner);
      found.weights.push_back(weight(images[i].height, rules));
      found.distances.push_back(landing.distance);
      found.cosines.push_back(landing.cosine);
      found.worth.push_back(worth);
      found.excused.push_back(excuse(landing, worth, rules));
    }
  }
  return found;
}

}  // namespace symrecon
