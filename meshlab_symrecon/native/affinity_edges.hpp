// The edges along which messages travel, with the messages on them: between all points, or in rows that may grow.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "affinity_messages.hpp"
#include "view.hpp"

namespace symrecon {

// The edges that leave one point; `own` is the place of the one to itself.
template <class Targets>
struct MessageRow {
  std::size_t count, own;
  Targets target;
  const double* similarity;
  double* availability;
  double* responsibility;
};

struct EveryPoint {
  std::size_t operator[](std::size_t place) const { return place; }
};

class DenseEdges {
 public:
  DenseEdges(std::size_t points, View<double> similarities)
      : points_(points),
        similarities_(similarities),
        availabilities_(similarities.size(), 0.0),
        responsibilities_(similarities.size(), 0.0) {}

  std::size_t size() const { return points_; }
  std::size_t edges() const { return similarities_.size(); }
  double missing(std::size_t) const { return -std::numeric_limits<double>::infinity(); }

  MessageRow<EveryPoint> row(std::size_t i) {
    const std::size_t first = i * points_;
    return {points_, i, {}, similarities_.data() + first, availabilities_.data() + first,
            responsibilities_.data() + first};
  }

 private:
  std::size_t points_;
  View<double> similarities_;
  std::vector<double> availabilities_, responsibilities_;
};

// What the messages on an edge that was missing would be: it never took part, so that its availability depends only on
// its target, its responsibility only on its similarity and its row.
struct IdleMessages {
  View<double> availability;  // of each target
  double share;               // of the similarity in a responsibility: how much the damping has let through
  View<double> rival;         // of each row: the damped largest sum
};

class SparseEdges {
 public:
  SparseEdges(const EdgeTable& table, bool may_grow)
      : rows_(table.width == 0 ? 0 : table.targets.size() / table.width), known_(rows_.size(), 0) {
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      Row& row = rows_[i];
      row.reserve(table.width);
      row.width = table.width;
      row.missing = may_grow ? reach(table, i) : nothing;
      for (std::size_t edge = i * table.width; edge < (i + 1) * table.width; ++edge)
        if (table.similarities[edge] > nothing) row.add(table.targets[edge], table.similarities[edge], 0.0, 0.0);
    }
  }

  std::size_t size() const { return rows_.size(); }
  double missing(std::size_t i) const { return rows_[i].missing; }  // no missing edge of row i is more similar
  std::size_t width(std::size_t i) const { return rows_[i].width; }

  std::size_t edges() const {
    std::size_t count = 0;
    for (const Row& row : rows_) count += row.targets.size();
    return count;
  }

  MessageRow<const std::int32_t*> row(std::size_t i) {
    Row& row = rows_[i];
    return {row.targets.size(),    0, row.targets.data(), row.similarities.data(), row.availabilities.data(),
            row.responsibilities.data()};
  }

  // Adds the edges of a table whose rows are those of `points`, except those there are.
  void extend(const std::vector<std::int32_t>& points, const EdgeTable& table, const IdleMessages& idle) {
    for (std::size_t place = 0; place < points.size(); ++place) {
      const std::int32_t i = points[place];
      Row& row = rows_[i];
      for (const std::int32_t target : row.targets) known_[target] = 1;
      const std::vector<std::int32_t> before = row.targets;
      row.reserve(table.width);
      for (std::size_t edge = place * table.width; edge < (place + 1) * table.width; ++edge) {
        const std::int32_t target = table.targets[edge];
        const double similarity = table.similarities[edge];
        if (!known_[target])
          row.add(target, similarity, idle.availability[target], idle.share * similarity - idle.rival[i]);
      }
      for (const std::int32_t target : before) known_[target] = 0;
      row.width = table.width;
      row.missing = reach(table, place);
    }
  }

  void stop_growing() {
    for (Row& row : rows_) row.missing = nothing;
  }

 private:
  static constexpr double nothing = -std::numeric_limits<double>::infinity();

  struct Row {
    std::vector<std::int32_t> targets;
    std::vector<double> similarities, availabilities, responsibilities;
    std::size_t width;
    double missing;

    void add(std::int32_t target, double similarity, double availability, double responsibility) {
      targets.push_back(target);
      similarities.push_back(similarity);
      availabilities.push_back(availability);
      responsibilities.push_back(responsibility);
    }

    void reserve(std::size_t count) {
      targets.reserve(count);
      similarities.reserve(count);
      availabilities.reserve(count);
      responsibilities.reserve(count);
    }
  };

  // The similarity that no edge beyond a row of the table exceeds.
  double reach(const EdgeTable& table, std::size_t place) const {
    return table.width >= rows_.size() ? nothing : table.similarities[(place + 1) * table.width - 1];
  }

  std::vector<Row> rows_;
  std::vector<std::uint8_t> known_;  // whether a point is among the targets of the row looked at
};

}  // namespace symrecon
