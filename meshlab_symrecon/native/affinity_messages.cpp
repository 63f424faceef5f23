#include "affinity_messages.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <map>

#include "affinity_edges.hpp"

namespace symrecon {
namespace {

constexpr double nothing = -std::numeric_limits<double>::infinity();
constexpr std::uint8_t oscillation = 20;  // turns of one point between exemplar and not; settling takes fewer

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

template <class Edges>
class Messages {
 public:
  Messages(Edges& edges, const Checkpoint& checkpoint)
      : edges_(edges),
        checkpoint_(checkpoint),
        received_(edges.size(), 0.0),
        levels_(edges.size(), 0.0),
        idle_availability_(edges.size(), 0.0),
        idle_rival_(edges.size(), 0.0),
        top_(edges.size()),
        evidence_(edges.size(), 0.0),
        undamped_(edges.size(), 0.0) {}

  // The availabilities that end the last iteration, and the largest sums of each row.
  void update_availabilities() {
    for (std::size_t k = 0; k < edges_.size(); ++k)
      idle_availability_[k] = damped(damping_, idle_availability_[k], std::min(0.0, levels_[k]));
    for (std::size_t i = 0; i < edges_.size(); ++i) {
      update_availabilities(i);
      find_top(i);
      pause(i);
    }
  }

  // Rows in which a missing edge might be among the two with the largest sums: availabilities are never positive.
  std::map<std::size_t, std::vector<std::int32_t>> short_rows() const {
    std::map<std::size_t, std::vector<std::int32_t>> found;  // by their width
    for (std::size_t i = 0; i < edges_.size(); ++i)
      if (edges_.missing(i) > top_[i].second) found[edges_.width(i)].push_back(static_cast<std::int32_t>(i));
    return found;
  }

  void extend(const std::vector<std::int32_t>& points, const EdgeTable& table) {
    edges_.extend(points, table, {idle_availability_, idle_share_, idle_rival_});
    for (const std::int32_t i : points) find_top(i);
  }

  // The responsibilities of an iteration, and the evidence for each exemplar at its end.
  void update_responsibilities(double damping) {
    damping_ = damping;
    std::fill(received_.begin(), received_.end(), 0.0);
    for (std::size_t i = 0; i < edges_.size(); ++i) {
      update_responsibilities(i);
      idle_rival_[i] = damped(damping_, idle_rival_[i], top_[i].largest);
      pause(i);
    }
    idle_share_ = damped(damping_, idle_share_, 1.0);
    for (std::size_t i = 0; i < edges_.size(); ++i) {
      const auto row = edges_.row(i);
      const double own = row.responsibility[row.own];
      levels_[i] = own + received_[i];
      evidence_[i] = own + damped(damping_, row.availability[row.own], received_[i]);
      undamped_[i] += received_[i];
    }
  }

  const std::vector<double>& evidence() const { return evidence_; }  // r(i, i) + a(i, i)
  const std::vector<double>& undamped() const { return undamped_; }  // the same of the last updates alone

 private:
  static double damped(double damping, double old, double update) {
    return damping * old + (1.0 - damping) * update;
  }

  // a(i, k) = min(0, r(k, k) + sum over i' not in {i, k} of max(0, r(i', k))); no minimum and no r(k, k) for k = i.
  void update_availabilities(std::size_t i) {
    const auto row = edges_.row(i);
    const double damping = damping_, kept = row.availability[row.own];
    for (std::size_t place = 0; place < row.count; ++place) {
      const double given = row.responsibility[place] > 0.0 ? row.responsibility[place] : 0.0;
      const double level = levels_[row.target[place]] - given;
      row.availability[place] = damped(damping, row.availability[place], level < 0.0 ? level : 0.0);
    }
    row.availability[row.own] = damped(damping, kept, received_[i]);
  }

  void find_top(std::size_t i) {
    const auto row = edges_.row(i);
    if (sums_.size() < row.count) sums_.resize(row.count);
    for (std::size_t place = 0; place < row.count; ++place)
      sums_[place] = row.availability[place] + row.similarity[place];
    top_[i] = top_two(sums_.data(), row.count);
  }

  // r(i, k) = s(i, k) - max over k' != k of (a(i, k') + s(i, k')).
  void update_responsibilities(std::size_t i) {
    const auto row = edges_.row(i);
    const TopTwo top = top_[i];
    const auto fresh = [&](std::size_t place) {
      const bool is_largest = row.availability[place] + row.similarity[place] == top.largest;
      return row.similarity[place] - (is_largest ? top.second : top.largest);
    };
    const double damping = damping_, own = row.responsibility[row.own];
    for (std::size_t place = 0; place < row.count; ++place)
      row.responsibility[place] = damped(damping, row.responsibility[place], fresh(place));
    const auto give = [&](std::size_t begin, std::size_t end) {
      for (std::size_t place = begin; place < end; ++place)
        if (row.responsibility[place] > 0.0) received_[row.target[place]] += row.responsibility[place];
    };
    give(0, row.own);
    give(row.own + 1, row.count);
    undamped_[i] = fresh(row.own);
    row.responsibility[row.own] = damped(damping, own, undamped_[i]);
  }

  void pause(std::size_t i) {
    work_ += edges_.row(i).count;
    if (work_ < cells_per_checkpoint) return;
    work_ = 0;
    checkpoint_();
  }

  Edges& edges_;
  const Checkpoint& checkpoint_;
  std::vector<double> received_, levels_;  // of each point: its positive responsibilities; with its own one
  std::vector<double> idle_availability_, idle_rival_;
  double idle_share_ = 0.0;
  double damping_ = 0.0;  // of this iteration
  std::vector<TopTwo> top_;
  std::vector<double> evidence_, undamped_, sums_;
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

// Iterates until the exemplars stay; `complete` is called where missing edges can be added.
template <class Edges, class Complete>
Exemplars propagate(Edges& edges, const MessageSchedule& schedule, const Checkpoint& checkpoint, Complete&& complete) {
  Messages<Edges> messages(edges, checkpoint);
  Choice choice(edges.size());
  Exemplars found;
  found.damping = schedule.damping;
  while (!found.converged && found.iterations < schedule.most) {
    messages.update_availabilities();
    complete(messages, found);
    messages.update_responsibilities(found.damping);
    choice.update(messages.evidence(), messages.undamped());
    if (choice.oscillates()) found.damping = 0.5 * (1.0 + found.damping);
    ++found.iterations;
    found.converged = choice.unchanged() >= schedule.calm && choice.number() > 0;
    if (found.iterations == schedule.most - schedule.calm) found.earlier = choice.chosen();
  }
  const std::vector<double>& evidence = messages.evidence();
  if (choice.number() == 0 && !evidence.empty())  // stopped early: the point nearest to being an exemplar
    choice.chosen()[std::max_element(evidence.begin(), evidence.end()) - evidence.begin()] = 1;
  found.chosen = std::move(choice.chosen());
  if (found.converged) found.earlier = found.chosen;
  found.earlier.resize(found.chosen.size());
  found.edges = edges.edges();
  return found;
}

}  // namespace

Exemplars propagate_sparse_affinity(const EdgeTable& table, const MessageSchedule& schedule, const MoreEdges& more,
                                    const Checkpoint& checkpoint) {
  SparseEdges edges(table, bool(more));
  return propagate(edges, schedule, checkpoint, [&](Messages<SparseEdges>& messages, Exemplars& found) {
    for (auto lacking = messages.short_rows(); !lacking.empty(); lacking = messages.short_rows())
      for (const auto& [width, points] : lacking) {
        const EdgeTable longer = more(points, std::min(2 * width, edges.size()));
        if (longer.width > width) {
          messages.extend(points, longer);
        } else {
          found.exact = false;
          edges.stop_growing();
          break;
        }
      }
  });
}

Exemplars propagate_dense_affinity(std::size_t points, View<double> similarities, const MessageSchedule& schedule,
                                   const Checkpoint& checkpoint) {
  DenseEdges edges(points, similarities);
  return propagate(edges, schedule, checkpoint, [](auto&, Exemplars&) {});
}

}  // namespace symrecon
