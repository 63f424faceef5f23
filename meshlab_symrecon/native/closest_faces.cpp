#include "closest_faces.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>

#include "vectors.hpp"

namespace symrecon {
namespace {

constexpr double nowhere = std::numeric_limits<double>::infinity();
constexpr std::size_t largest_leaf = 6;
constexpr int most_waiting = 64;  // more than the tree is deep
constexpr double needle = 1e-8;   // squared sine below which rounding may misplace the foot in a face's plane

struct Face {
  Position corner, second, third;  // the sides from the first corner to the others
  Position normal;
  std::int32_t index;
};

struct Box {
  Position low{nowhere, nowhere, nowhere}, high{-nowhere, -nowhere, -nowhere};

  void take(const Position& point) {
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], point[axis]);
      high[axis] = std::max(high[axis], point[axis]);
    }
  }

  double square_to(const Position& place) const {
    double square = 0.0;
    for (int axis = 0; axis < 3; ++axis) {
      const double outside = std::max({low[axis] - place[axis], place[axis] - high[axis], 0.0});
      square += outside * outside;
    }
    return square;
  }
};

struct Touch {
  double square, second, third;  // distance, and the weights of two corners
};

// The point of a side, from `start` along `side`, that is closest to a place at `offset` from the start.
double along(const Position& side, const Position& offset) {
  const double length = dot(side, side);
  return length > 0.0 ? std::clamp(dot(side, offset) / length, 0.0, 1.0) : 0.0;
}

double square_at(const Face& face, const Position& offset, double second, double third) {
  double square = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double apart = offset[axis] - second * face.second[axis] - third * face.third[axis];
    square += apart * apart;
  }
  return square;
}

// The foot in the face's plane, when it lies within the face, or else the best point of the three sides.
Touch closest_on(const Face& face, const Position& place) {
  const Position offset = minus(place, face.corner);
  const double aa = dot(face.second, face.second), ab = dot(face.second, face.third), bb = dot(face.third, face.third);
  if (aa == 0.0 && bb == 0.0) return {dot(offset, offset), 0.0, 0.0};
  const double a = dot(face.second, offset), b = dot(face.third, offset), area = aa * bb - ab * ab;
  const double second = bb * a - ab * b, third = aa * b - ab * a;
  Touch best{nowhere, 0.0, 0.0};
  if (area > 0.0 && second > 0.0 && third > 0.0 && second + third < area) {
    best = {square_at(face, offset, second / area, third / area), second / area, third / area};
    if (area > needle * aa * bb) return best;
  }
  const double first_side = along(face.second, offset), last_side = along(face.third, offset);
  const double far_side = along(minus(face.third, face.second), minus(offset, face.second));
  const std::array<std::array<double, 2>, 3> on_sides = {
      {{first_side, 0.0}, {0.0, last_side}, {1.0 - far_side, far_side}}};
  for (const auto& [second_weight, third_weight] : on_sides) {
    const double square = square_at(face, offset, second_weight, third_weight);
    if (square < best.square) best = {square, second_weight, third_weight};
  }
  return best;
}

// A balanced tree of boxes. Node k has the children 2k + 1 and 2k + 2, and each takes half of its parent's faces.
class FaceTree {
 public:
  explicit FaceTree(const FacingSurface& surface) {
    const std::size_t count = surface.faces.size();
    std::size_t leaves = 1;
    while (leaves * largest_leaf < count) leaves *= 2;
    first_leaf_ = leaves - 1;
    boxes_.resize(2 * leaves - 1);
    std::vector<Position> middles(count);
    for (std::size_t k = 0; k < count; ++k)
      for (int axis = 0; axis < 3; ++axis)
        for (const std::int32_t corner : surface.faces[k]) middles[k][axis] += surface.points[corner][axis];
    std::vector<std::int32_t> order(count);
    std::iota(order.begin(), order.end(), 0);
    arrange(middles, 0, order.data(), order.data() + count);
    faces_.reserve(count);
    for (const std::int32_t k : order) {
      const Triangle& corners = surface.faces[k];
      const Position& corner = surface.points[corners[0]];
      faces_.push_back({corner, minus(surface.points[corners[1]], corner), minus(surface.points[corners[2]], corner),
                        surface.normals[k], k});
    }
    enclose(surface, 0, 0, count);
  }

  std::size_t size() const { return faces_.size(); }

  class Search;

 private:
  void arrange(View<Position> middles, std::size_t node, std::int32_t* begin, std::int32_t* end) {
    if (node >= first_leaf_) return;
    Box box;
    for (const std::int32_t* face = begin; face != end; ++face) box.take(middles[*face]);
    const Position widths = minus(box.high, box.low);
    const auto axis = std::max_element(widths.begin(), widths.end()) - widths.begin();
    std::int32_t* const middle = begin + (end - begin) / 2;
    std::nth_element(begin, middle, end, [&](std::int32_t a, std::int32_t b) {
      return middles[a][axis] < middles[b][axis] || (middles[a][axis] == middles[b][axis] && a < b);
    });
    arrange(middles, 2 * node + 1, begin, middle);
    arrange(middles, 2 * node + 2, middle, end);
  }

  void enclose(const FacingSurface& surface, std::size_t node, std::size_t begin, std::size_t end) {
    if (node >= first_leaf_) {
      for (std::size_t k = begin; k < end; ++k)
        for (const std::int32_t corner : surface.faces[faces_[k].index]) boxes_[node].take(surface.points[corner]);
      return;
    }
    const std::size_t middle = begin + (end - begin) / 2;
    enclose(surface, 2 * node + 1, begin, middle);
    enclose(surface, 2 * node + 2, middle, end);
    for (const std::size_t child : {2 * node + 1, 2 * node + 2}) {
      boxes_[node].take(boxes_[child].low);
      boxes_[node].take(boxes_[child].high);
    }
  }

  std::vector<Box> boxes_;
  std::vector<Face> faces_;  // those of a leaf side by side
  std::size_t first_leaf_;
};

class FaceTree::Search {
 public:
  Search(const FaceTree& tree, const FacingRules& rules) : tree_(tree), rules_(rules) {}

  // Places that follow each other should be near each other: the last face found begins the search.
  Touch find(const Position& place, const Position& direction) {
    place_ = place;
    direction_ = direction;
    best_ = {rules_.within * rules_.within, 0.0, 0.0};
    face_ = -1;
    if (tree_.size() == 0) return best_;
    try_face(guess_);
    descend();
    if (face_ >= 0) guess_ = found_;
    return best_;
  }

  std::int32_t face() const { return face_; }

 private:
  struct Waiting {
    std::size_t node, begin, end;
    double square;
  };

  void try_face(std::size_t k) {
    const Face& face = tree_.faces_[k];
    const double cosine = dot(face.normal, direction_);
    if (!((rules_.sided ? cosine : std::abs(cosine)) >= rules_.least_cosine)) return;
    const Touch touch = closest_on(face, place_);
    const bool first = face_ < 0 || face.index < face_;  // of several at one distance
    if (touch.square > best_.square || (touch.square == best_.square && !first)) return;
    best_ = touch;
    face_ = face.index;
    found_ = k;
  }

  void descend() {
    Waiting stack[most_waiting];
    int waiting = 0;
    stack[waiting++] = {0, 0, tree_.size(), 0.0};
    while (waiting > 0) {
      Waiting here = stack[--waiting];
      while (here.square <= best_.square && here.node < tree_.first_leaf_) {
        const std::size_t middle = here.begin + (here.end - here.begin) / 2, left = 2 * here.node + 1;
        Waiting near{left, here.begin, middle, tree_.boxes_[left].square_to(place_)};
        Waiting far{left + 1, middle, here.end, tree_.boxes_[left + 1].square_to(place_)};
        if (far.square < near.square) std::swap(near, far);
        if (far.square <= best_.square) stack[waiting++] = far;
        here = near;
      }
      if (here.square > best_.square) continue;
      for (std::size_t k = here.begin; k < here.end; ++k) try_face(k);
    }
  }

  const FaceTree& tree_;
  FacingRules rules_;
  Position place_{}, direction_{};
  Touch best_{};
  std::int32_t face_ = -1;
  std::size_t guess_ = 0, found_ = 0;
};

}  // namespace

Feet closest_faces(const FacingSurface& surface, View<Position> places, View<Position> directions,
                   const FacingRules& rules) {
  const FaceTree tree(surface);
  FaceTree::Search search(tree, rules);
  Feet feet;
  feet.faces.reserve(places.size());
  feet.weights.reserve(places.size());
  for (std::size_t k = 0; k < places.size(); ++k) {
    const Touch touch = search.find(places[k], directions[k]);
    feet.faces.push_back(search.face());
    feet.weights.push_back({touch.second, touch.third});
  }
  return feet;
}

}  // namespace symrecon
