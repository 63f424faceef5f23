#include "handles.hpp"

#include <algorithm>
#include <queue>

#include "disjoint_sets.hpp"
#include "memory_pages.hpp"
#include "prefetch.hpp"

namespace symrecon {
namespace {

constexpr std::int64_t kStepsPerCheckpoint = 1 << 13;

// The facets opposite each candidate in its cells, as rows of one array: whoever goes round a candidate reads them in
// order, and the cells would lie far apart.
struct Stars {
  std::vector<std::int32_t> start;
  LargeVector<Triangle> facet;

  Stars(View<Quad> cells, const std::vector<std::uint8_t>& candidate) : start(candidate.size() + 1, 0) {
    for (const Quad& corners : cells)
      for (const std::int32_t site : corners) start[site + 1] += candidate[site];
    for (std::size_t i = 0; i < candidate.size(); ++i) start[i + 1] += start[i];
    facet.resize(start.back());
    std::vector<std::int32_t> place(start.begin(), start.end() - 1);
    for (const Quad& corners : cells)
      for (int k = 0; k < 4; ++k)
        if (candidate[corners[k]])
          facet[place[corners[k]]++] = {corners[(k + 1) % 4], corners[(k + 2) % 4], corners[(k + 3) % 4]};
  }
};

std::vector<std::uint8_t> uncertain(View<std::uint8_t> wanted, View<std::uint8_t> certain) {
  std::vector<std::uint8_t> result(wanted.size());
  for (std::size_t i = 0; i < wanted.size(); ++i) result[i] = wanted[i] && !certain[i];
  return result;
}

struct Candidate {
  double size;
  std::int32_t site;
  bool operator<(const Candidate& other) const {
    return size != other.size ? size < other.size : site > other.site;
  }
};

class Growth {
 public:
  Growth(View<Quad> cells, View<std::uint8_t> wanted, View<std::uint8_t> certain, View<double> size)
      : cells_(cells),
        candidate_(uncertain(wanted, certain)),
        size_(size),
        stars_(cells, candidate_),
        grown_(certain.begin(), certain.end()),
        queued_(candidate_),
        place_(wanted.size(), -1),
        pieces_(wanted.size()) {
    first_.reserve(std::count(candidate_.begin(), candidate_.end(), std::uint8_t(1)));
    for (std::size_t site = 0; site < candidate_.size(); ++site)
      if (candidate_[site]) first_.push_back({size[site], static_cast<std::int32_t>(site)});
    std::sort(first_.begin(), first_.end(), [](const Candidate& a, const Candidate& b) { return b < a; });
  }

  std::vector<std::uint8_t> run(const Checkpoint& checkpoint) {
    for (std::int64_t step = 0; next_ < first_.size() || !again_.empty(); ++step) {
      if (step % kStepsPerCheckpoint == 0) checkpoint();
      const std::int32_t site = take();
      queued_[site] = 0;
      gather(site);
      if (!closes_loop()) add(site);
    }
    return std::move(grown_);
  }

 private:
  void offer(std::int32_t site) {
    if (!candidate_[site] || grown_[site] || queued_[site]) return;
    queued_[site] = 1;
    again_.push({size_[site], site});
  }

  // The largest of those that wait.
  std::int32_t take() {
    if (!again_.empty() && (next_ == first_.size() || first_[next_] < again_.top())) {
      const std::int32_t site = again_.top().site;
      again_.pop();
      return site;
    }
    send_for_stars();
    return first_[next_++].site;
  }

  // Sites of one size lie far apart: so their stars are sent for some sites ahead.
  void send_for_stars() const {
    constexpr std::size_t soon = 4, late = 8;
    constexpr std::int32_t line = 5;  // facets in a line of the cache
    if (next_ + late < first_.size()) prefetch(&stars_.start[first_[next_ + late].site]);
    if (next_ + soon >= first_.size()) return;
    const std::int32_t site = first_[next_ + soon].site;
    for (std::int32_t i = stars_.start[site]; i < stars_.start[site + 1]; i += line) prefetch(&stars_.facet[i]);
  }

  // The neighbours of a site, and the parts of the grown set among them.
  void gather(std::int32_t site) {
    ring_.clear();
    parts_.clear();
    for (std::int32_t i = stars_.start[site]; i < stars_.start[site + 1]; ++i) {
      std::int32_t first = -1;
      for (const std::int32_t other : stars_.facet[i]) {
        if (place_[other] < 0) {
          place_[other] = static_cast<std::int32_t>(ring_.size());
          parts_.push_back(place_[other]);
          ring_.push_back(other);
        }
        if (!grown_[other]) continue;
        const std::int32_t joined = part(place_[other]);
        if (first < 0) first = joined;
        parts_[joined] = first;
      }
    }
    for (const std::int32_t other : ring_) place_[other] = -1;
  }

  std::int32_t part(std::int32_t k) {
    while (parts_[k] != k) k = parts_[k] = parts_[parts_[k]];
    return k;
  }

  // Join what is grown so far.  Where nothing is at stake, as in most clean scans, it is never asked for.
  void join_pieces() {
    joined_ = true;
    for (const Quad& corners : cells_) {
      std::int32_t first = -1;
      for (const std::int32_t site : corners) {
        if (!grown_[site]) continue;
        if (first < 0) {
          first = site;
        } else {
          pieces_.join(first, site);
        }
      }
    }
  }

  // Whether two parts round the gathered site are joined elsewhere already.
  bool closes_loop() {
    std::int32_t parts = 0;
    for (std::size_t k = 0; k < ring_.size(); ++k)
      parts += grown_[ring_[k]] && parts_[k] == static_cast<std::int32_t>(k);
    if (parts < 2) return false;
    if (!joined_) join_pieces();
    met_.clear();
    for (std::size_t k = 0; k < ring_.size(); ++k)
      if (grown_[ring_[k]] && parts_[k] == static_cast<std::int32_t>(k)) met_.push_back(pieces_.find(ring_[k]));
    std::sort(met_.begin(), met_.end());
    return std::adjacent_find(met_.begin(), met_.end()) != met_.end();
  }

  void add(std::int32_t site) {
    grown_[site] = 1;
    for (const std::int32_t other : ring_) {
      if (grown_[other]) {
        if (joined_) pieces_.join(site, other);
      } else {
        offer(other);  // it may have been refused before
      }
    }
  }

  const View<Quad> cells_;
  const std::vector<std::uint8_t> candidate_;
  const View<double> size_;
  Stars stars_;
  std::vector<std::uint8_t> grown_, queued_;
  std::vector<std::int32_t> place_;  // of a site in the ring while it is gathered, else -1
  std::vector<std::int32_t> ring_, parts_, met_;
  DisjointSets pieces_;
  bool joined_ = false;  // whether the pieces are up to date
  std::vector<Candidate> first_;  // all candidates, the largest first; those from the next one on wait
  std::size_t next_ = 0;
  std::priority_queue<Candidate> again_;  // refused ones that wait once more
};

}  // namespace

std::vector<std::uint8_t> grow_without_loops(View<Quad> cells, View<std::uint8_t> wanted,
                                             View<std::uint8_t> certain, View<double> size,
                                             const Checkpoint& checkpoint) {
  if (std::equal(wanted.begin(), wanted.end(), certain.begin())) return {wanted.begin(), wanted.end()};
  return Growth(cells, wanted, certain, size).run(checkpoint);
}

}  // namespace symrecon
