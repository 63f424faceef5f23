// Minimum cuts of an undirected graph between the outside and the inside, to which nodes are tied.
//
// Augmenting paths between two search trees, one from each side, that are mended rather than grown
// anew after each path (Boykov, Kolmogorov: An experimental comparison of min-cut/max-flow
// algorithms for energy minimization in vision, 2004).
#pragma once

#include <cstdint>
#include <deque>
#include <vector>

#include "view.hpp"
#include "patience.hpp"

namespace symrecon {

class MinimumCut {
 public:
  // Neighbours of each node in rising order, every edge there from both ends with equal capacity of
  // at most 32767.  The arrays must outlive the object.
  MinimumCut(View<std::int64_t> offsets, View<std::int32_t> ends, View<std::uint16_t> capacities);

  // 1 for the nodes on the inner side of a minimum cut; of several cuts the one with the most.
  // `ties` are capacities: to the outside where positive, to the inside where negative.  The flow of
  // the last call is kept, which saves time and changes nothing.
  std::vector<std::uint8_t> inner_side(View<std::int32_t> ties, const Progress& progress);

 private:
  enum Tree : std::uint8_t { free_node, outer_tree, inner_tree };
  enum Root : std::int32_t { no_parent = -1, tied = -2, orphan = -3 };
  using Node = std::int32_t;
  using Arc = std::int64_t;

  void require_both_ways() const;
  void plant(View<std::int32_t> ties);
  void activate(Node node);
  void grow(Node node, Patience& patience);
  void augment(Node outer, Node inner, Arc arc, bool forward);
  void mend(Patience& patience);
  void adopt(Node node);
  void let_go(Node node);
  std::int32_t depth_of(Node node);
  Arc arc_between(Node from, Node to) const;
  void push(Arc arc, Node from, Node to, std::int32_t amount);
  void make_orphan(Node node);

  // what can still flow from the start of the arc to its end, and back
  std::int32_t ahead(Arc arc) const { return capacities_[arc] - flow_[arc]; }
  std::int32_t back(Arc arc) const { return capacities_[arc] + flow_[arc]; }

  View<std::int64_t> offsets_;
  View<std::int32_t> ends_;
  View<std::uint16_t> capacities_;
  std::vector<std::int16_t> flow_;   // along each arc; the opposite of its reverse's
  std::vector<std::int32_t> given_;  // the ties asked for
  std::vector<std::int32_t> tie_;    // what is left of them
  std::vector<Tree> tree_;
  std::vector<Node> parent_;
  std::vector<Arc> parent_arc_;      // from the parent to the node
  std::vector<std::int32_t> depth_, checked_;  // distance to the root, and when it was right
  std::vector<std::uint8_t> waiting_;
  std::deque<Node> active_, orphans_;
  std::int32_t time_ = 0;
};

}  // namespace symrecon
