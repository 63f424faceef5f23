#include "minimum_cut.hpp"

#include <algorithm>
#include <cstdlib>
#include <limits>

#include "border_checks.hpp"

namespace symrecon {
namespace {

constexpr std::int64_t strongest = std::numeric_limits<std::int32_t>::max();  // tie and the flow through it
constexpr auto one_way = "edges must be there from both ends, with one capacity, and in rising order";
constexpr std::int32_t nowhere = std::numeric_limits<std::int32_t>::max();

std::size_t nodes_of(View<std::int64_t> offsets, View<std::int32_t> ends, View<std::uint16_t> capacities) {
  require_rows(offsets, ends.size());
  require(capacities.size() == ends.size(), "one capacity an edge is needed");
  require_known(ends, offsets.size() - 1, "edges to unknown nodes");
  return offsets.size() - 1;
}

}  // namespace

MinimumCut::MinimumCut(View<std::int64_t> offsets, View<std::int32_t> ends,
                       View<std::uint16_t> capacities)
    : offsets_(offsets),
      ends_(ends),
      capacities_(capacities),
      flow_(ends.size(), 0),
      given_(nodes_of(offsets, ends, capacities), 0),
      tie_(given_),
      tree_(given_.size()),
      parent_(given_.size()),
      parent_arc_(given_.size()),
      depth_(given_.size()),
      checked_(given_.size()),
      waiting_(given_.size()) {
  for (const std::uint16_t capacity : capacities)
    require(capacity <= std::numeric_limits<std::int16_t>::max(), "capacities must be at most 32767");
  require_both_ways();
}

// Nodes are visited in rising order, and so are the ends of a row: the edges back to them are then met in the order of
// the other rows.
void MinimumCut::require_both_ways() const {
  std::vector<Arc> next(offsets_.begin(), offsets_.end() - 1);
  bool both = true;
  for (Node node = 0; node < static_cast<Node>(given_.size()); ++node)
    for (Arc arc = offsets_[node]; arc < offsets_[node + 1]; ++arc) {
      const Arc back = next[ends_[arc]]++;
      require(back < offsets_[ends_[arc] + 1], one_way);
      both &= ends_[back] == node && capacities_[back] == capacities_[arc] && ends_[arc] != node &&
              (arc == offsets_[node] || ends_[arc - 1] < ends_[arc]);
    }
  require(both, one_way);
}

std::vector<std::uint8_t> MinimumCut::inner_side(View<std::int32_t> ties, const Progress& progress) {
  require(ties.size() == given_.size(), "one tie a node is needed");
  for (std::size_t i = 0; i < ties.size(); ++i)
    require(std::abs(std::int64_t(tie_[i]) + ties[i] - given_[i]) <= strongest, "ties must be at most 2^31 - 1, with what flows through them");
  plant(ties);
  Patience patience(progress, 2 * tie_.size());
  while (!active_.empty()) {
    const Node node = active_.front();
    active_.pop_front();
    waiting_[node] = 0;
    grow(node, patience);
  }
  // the outer tree holds every node that flow from the outside could still reach
  std::vector<std::uint8_t> inner(tree_.size());
  for (std::size_t i = 0; i < inner.size(); ++i) inner[i] = tree_[i] != outer_tree;
  return inner;
}

// Make every tied node the root of a tree.  Where a node passed on more than it is tied for now, the
// surplus counts as a tie to the other side: that adds the same to every cut.
void MinimumCut::plant(View<std::int32_t> ties) {
  active_.clear();
  orphans_.clear();
  time_ = 0;
  std::fill(checked_.begin(), checked_.end(), 0);
  std::fill(waiting_.begin(), waiting_.end(), 0);
  for (std::size_t i = 0; i < tie_.size(); ++i) {
    tie_[i] = static_cast<std::int32_t>(std::int64_t(tie_[i]) + ties[i] - given_[i]);
    given_[i] = ties[i];
    tree_[i] = tie_[i] > 0 ? outer_tree : tie_[i] < 0 ? inner_tree : free_node;
    parent_[i] = tie_[i] != 0 ? tied : no_parent;
    depth_[i] = 1;
    if (tie_[i] != 0) activate(static_cast<Node>(i));
  }
}

void MinimumCut::activate(Node node) {
  if (waiting_[node]) return;
  waiting_[node] = 1;
  active_.push_back(node);
}

// Take free neighbours into the node's tree, and send flow through those of the other tree.
void MinimumCut::grow(Node node, Patience& patience) {
  Arc arc = offsets_[node];
  while (arc < offsets_[node + 1]) {
    const Tree tree = tree_[node];
    if (tree == free_node) return;
    const bool forward = tree == outer_tree;
    const Node other = ends_[arc];
    if (tree_[other] == tree || (forward ? ahead(arc) : back(arc)) == 0) {
      ++arc;
    } else if (tree_[other] == free_node) {
      tree_[other] = tree;
      parent_[other] = node;
      parent_arc_[other] = arc++;
      checked_[other] = checked_[node];
      depth_[other] = depth_[node] + 1;
      activate(other);
    } else {
      augment(forward ? node : other, forward ? other : node, arc, forward);
      mend(patience);
    }
  }
  patience.step();
}

// Send what fits along the path root .. outer -> inner .. root; `arc` joins the two, `forward` tells
// whether it starts at the outer one.
void MinimumCut::augment(Node outer, Node inner, Arc arc, bool forward) {
  std::int32_t amount = forward ? ahead(arc) : back(arc);
  Node root = outer;
  for (; parent_[root] != tied; root = parent_[root]) amount = std::min(amount, ahead(parent_arc_[root]));
  amount = std::min(amount, tie_[root]);
  for (root = inner; parent_[root] != tied; root = parent_[root])
    amount = std::min(amount, back(parent_arc_[root]));
  amount = std::min(amount, -tie_[root]);

  push(arc, forward ? outer : inner, forward ? inner : outer, forward ? amount : -amount);
  for (root = outer; parent_[root] != tied;) {
    const Node parent = parent_[root];
    push(parent_arc_[root], parent, root, amount);
    if (ahead(parent_arc_[root]) == 0) make_orphan(root);
    root = parent;
  }
  if ((tie_[root] -= amount) == 0) make_orphan(root);
  for (root = inner; parent_[root] != tied;) {
    const Node parent = parent_[root];
    push(parent_arc_[root], parent, root, -amount);
    if (back(parent_arc_[root]) == 0) make_orphan(root);
    root = parent;
  }
  if ((tie_[root] += amount) == 0) make_orphan(root);
}

void MinimumCut::push(Arc arc, Node from, Node to, std::int32_t amount) {
  const auto change = static_cast<std::int16_t>(amount);
  flow_[arc] = static_cast<std::int16_t>(flow_[arc] + change);
  std::int16_t& reverse = flow_[arc_between(to, from)];
  reverse = static_cast<std::int16_t>(reverse - change);
}

MinimumCut::Arc MinimumCut::arc_between(Node from, Node to) const {
  const auto first = ends_.begin() + offsets_[from], last = ends_.begin() + offsets_[from + 1];
  return std::lower_bound(first, last, to) - ends_.begin();
}

void MinimumCut::make_orphan(Node node) {
  parent_[node] = orphan;
  orphans_.push_back(node);
}

// Find a new parent for every orphan, or let it go.
void MinimumCut::mend(Patience& patience) {
  ++time_;
  while (!orphans_.empty()) {
    const Node node = orphans_.front();
    orphans_.pop_front();
    adopt(node);
    patience.step();
  }
}

void MinimumCut::adopt(Node node) {
  const bool outer = tree_[node] == outer_tree;
  std::int32_t least = nowhere;
  Arc best = -1;
  for (Arc arc = offsets_[node]; arc < offsets_[node + 1]; ++arc) {
    const Node other = ends_[arc];
    if (tree_[other] != tree_[node] || (outer ? back(arc) : ahead(arc)) == 0) continue;
    const std::int32_t depth = depth_of(other);
    if (depth >= least) continue;
    least = depth;
    best = arc;
  }
  if (best < 0) return let_go(node);
  parent_[node] = ends_[best];
  parent_arc_[node] = arc_between(ends_[best], node);
  depth_[node] = least + 1;
  checked_[node] = time_;
}

// Steps from a node to the root of its tree, or `nowhere` below an orphan.
std::int32_t MinimumCut::depth_of(Node node) {
  std::int32_t depth = 0;
  Node root = node;
  for (; checked_[root] != time_; root = parent_[root]) {
    if (parent_[root] == orphan) return nowhere;
    if (parent_[root] == tied) {
      checked_[root] = time_;
      depth_[root] = 1;
      break;
    }
    ++depth;
  }
  depth += depth_[root];
  std::int32_t height = depth;
  for (Node below = node; checked_[below] != time_; below = parent_[below]) {
    checked_[below] = time_;
    depth_[below] = height--;
  }
  return depth;
}

void MinimumCut::let_go(Node node) {
  const bool outer = tree_[node] == outer_tree;
  for (Arc arc = offsets_[node]; arc < offsets_[node + 1]; ++arc) {
    const Node other = ends_[arc];
    if (tree_[other] != tree_[node]) continue;
    if ((outer ? back(arc) : ahead(arc)) > 0) activate(other);
    if (parent_[other] == node) make_orphan(other);
  }
  tree_[node] = free_node;
  parent_[node] = no_parent;
}

}  // namespace symrecon
