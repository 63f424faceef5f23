#include "affinity_messages.hpp"

#include <algorithm>
#include <array>
#include <limits>

namespace symrecon {
namespace {

constexpr double nothing = -std::numeric_limits<double>::infinity();
constexpr std::uint8_t oscillation = 8;  // turns of one point between exemplar and not; settling takes fewer

struct TopTwo {
  double largest = nothing, second = nothing;

  void take(double value) {
    const double smaller = value < largest ? value : largest;
    second = smaller > second ? smaller : second;
    largest = value > largest ? value : largest;
  }
};

// Without a branch, in lanes that do not wait for each other.
TopTwo top_two(const double* values, std::size_t count) {
  constexpr std::size_t lanes = 4;
  std::array<double, lanes> largest, second;
  largest.fill(nothing);
  second.fill(nothing);
  std::size_t place = 0;
  for (; place + lanes <= count; place += lanes)
    for (std::size_t lane = 0; lane < lanes; ++lane) {
      const double value = values[place + lane];
      const double smaller = value < largest[lane] ? value : largest[lane];
      second[lane] = smaller > second[lane] ? smaller : second[lane];
      largest[lane] = value > largest[lane] ? value : largest[lane];
    }
  TopTwo found;
  for (; place < count; ++place) found.take(values[place]);
  for (std::size_t lane = 0; lane < lanes; ++lane) {
    found.take(largest[lane]);
    found.take(second[lane]);
  }
  return found;
}

template <class Similarities>
class Messages {
 public:
  Messages(const Similarities& similarities, const Checkpoint& checkpoint)
      : similarities_(similarities),
        checkpoint_(checkpoint),
        responsibilities_(similarities.values.size(), 0.0),
        availabilities_(similarities.values.size(), 0.0),
        received_(similarities.size(), 0.0),
        levels_(similarities.size(), 0.0),
        next_received_(similarities.size()),
        next_levels_(similarities.size()),
        needed_(similarities.size(), -nothing),
        evidence_(similarities.size(), 0.0),
        undamped_(similarities.size(), 0.0) {}

  // The availabilities from the last responsibilities, then new responsibilities, row by row: each edge is read once.
  void iterate(double damping) {
    std::fill(next_received_.begin(), next_received_.end(), 0.0);
    for (std::size_t i = 0; i < similarities_.size(); ++i) {
      update_availabilities(i, damping);
      update_responsibilities(i, damping);
      work_ += similarities_.count(i);
      if (work_ >= cells_per_checkpoint) {
        work_ = 0;
        checkpoint_();
      }
    }
    for (std::size_t i = 0; i < similarities_.size(); ++i) {
      const std::size_t own = similarities_.first(i) + similarities_.own(i);
      next_levels_[i] = responsibilities_[own] + next_received_[i];
      evidence_[i] = responsibilities_[own] + damped(damping, availabilities_[own], next_received_[i]);
      undamped_[i] += next_received_[i];
    }
    received_.swap(next_received_);
    levels_.swap(next_levels_);
  }

  const std::vector<double>& evidence() const { return evidence_; }  // r(i, i) + a(i, i)
  const std::vector<double>& undamped() const { return undamped_; }  // the same of the last updates alone
  std::vector<double>& needed() { return needed_; }

 private:
  static double damped(double damping, double old, double update) {
    return damping * old + (1.0 - damping) * update;
  }

  // a(i, k) = min(0, r(k, k) + sum over i' not in {i, k} of max(0, r(i', k))); no minimum and no r(k, k) for k = i.
  void update_availabilities(std::size_t i, double damping) {
    const std::size_t own = similarities_.own(i), count = similarities_.count(i);
    const double* responsibility = responsibilities_.data() + similarities_.first(i);
    double* availability = availabilities_.data() + similarities_.first(i);
    const double kept = availability[own];
    for (std::size_t place = 0; place < count; ++place) {
      const double given = responsibility[place] > 0.0 ? responsibility[place] : 0.0;
      const double level = levels_[similarities_.target(i, place)] - given;
      availability[place] = damped(damping, availability[place], level < 0.0 ? level : 0.0);
    }
    availability[own] = damped(damping, kept, received_[i]);
  }

  // r(i, k) = s(i, k) - max over k' != k of (a(i, k') + s(i, k')).
  void update_responsibilities(std::size_t i, double damping) {
    const std::size_t own = similarities_.own(i), count = similarities_.count(i);
    const double* similarity = similarities_.values.data() + similarities_.first(i);
    const double* availability = availabilities_.data() + similarities_.first(i);
    double* responsibility = responsibilities_.data() + similarities_.first(i);
    if (sums_.size() < count) sums_.resize(count);
    for (std::size_t place = 0; place < count; ++place) sums_[place] = availability[place] + similarity[place];
    const TopTwo top = top_two(sums_.data(), count);
    needed_[i] = std::min(needed_[i], top.second);
    const auto update = [&](std::size_t begin, std::size_t end) {
      for (std::size_t place = begin; place < end; ++place) {
        const double rival = sums_[place] == top.largest ? top.second : top.largest;
        const double found = damped(damping, responsibility[place], similarity[place] - rival);
        responsibility[place] = found;
        next_received_[similarities_.target(i, place)] += found > 0.0 ? found : 0.0;
      }
    };
    update(0, own);
    update(own + 1, count);
    undamped_[i] = similarity[own] - (sums_[own] == top.largest ? top.second : top.largest);
    responsibility[own] = damped(damping, responsibility[own], undamped_[i]);
  }

  const Similarities& similarities_;
  const Checkpoint& checkpoint_;
  std::vector<double> responsibilities_, availabilities_;  // along the edges
  std::vector<double> received_, levels_;  // of each point: its positive responsibilities; with its own one
  std::vector<double> next_received_, next_levels_;
  std::vector<double> needed_, evidence_, undamped_, sums_;
  std::size_t work_ = 0;
};

// Which points are exemplars, for how long, and whether they oscillate.
class Choice {
 public:
  explicit Choice(std::size_t points) : chosen_(points, 0), turns_(points, 0) {}

  // Heavily damped messages may keep exemplars for a while that the updates no longer support: that is no calm.
  void update(const std::vector<double>& evidence, const std::vector<double>& undamped) {
    bool changed = false, supported = true;
    number_ = 0;
    for (std::size_t i = 0; i < chosen_.size(); ++i) {
      const std::uint8_t now = evidence[i] > 0.0;
      const std::uint8_t turned = now != chosen_[i];
      changed |= turned;
      turns_[i] += turned;
      supported &= now == (undamped[i] > 0.0);
      oscillating_ |= turns_[i] >= oscillation;
      number_ += now;
      chosen_[i] = now;
    }
    unchanged_ = !supported ? 0 : changed ? 1 : unchanged_ + 1;
  }

  // Whether a point has turned often since the last call that said so.
  bool oscillates() {
    if (!oscillating_) return false;
    oscillating_ = false;
    std::fill(turns_.begin(), turns_.end(), 0);
    return true;
  }

  std::size_t number() const { return number_; }
  std::int32_t unchanged() const { return unchanged_; }  // iterations
  std::vector<std::uint8_t>& chosen() { return chosen_; }

 private:
  std::vector<std::uint8_t> chosen_, turns_;
  std::size_t number_ = 0;
  std::int32_t unchanged_ = 0;
  bool oscillating_ = false;
};

template <class Similarities>
Exemplars propagate(const Similarities& similarities, const MessageSchedule& schedule, const Checkpoint& checkpoint) {
  Messages<Similarities> messages(similarities, checkpoint);
  Choice choice(similarities.size());
  Exemplars found;
  found.damping = schedule.damping;
  while (!found.converged && found.iterations < schedule.most) {
    messages.iterate(found.damping);
    choice.update(messages.evidence(), messages.undamped());
    if (choice.oscillates()) found.damping = 0.5 * (1.0 + found.damping);
    ++found.iterations;
    found.converged = choice.unchanged() >= schedule.calm && choice.number() > 0;
  }
  const std::vector<double>& evidence = messages.evidence();
  if (choice.number() == 0 && !evidence.empty())  // stopped early: the point nearest to being an exemplar
    choice.chosen()[std::max_element(evidence.begin(), evidence.end()) - evidence.begin()] = 1;
  found.chosen = std::move(choice.chosen());
  found.needed = std::move(messages.needed());
  return found;
}

}  // namespace

Exemplars propagate_affinity(const SparseSimilarities& similarities, const MessageSchedule& schedule,
                             const Checkpoint& checkpoint) {
  return propagate(similarities, schedule, checkpoint);
}

Exemplars propagate_affinity(const DenseSimilarities& similarities, const MessageSchedule& schedule,
                             const Checkpoint& checkpoint) {
  return propagate(similarities, schedule, checkpoint);
}

}  // namespace symrecon
