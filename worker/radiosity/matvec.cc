#include "worker/radiosity/matvec.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "common/util/check.h"

namespace isolux {
namespace {

double Now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// Walks the active nodes below one cut node, parents first.
void ListActive(const Tree& tree, const std::vector<uint8_t>& active, uint32_t top,
                ActiveNodes& nodes) {
  std::vector<uint32_t> stack{top};
  while (!stack.empty()) {
    const uint32_t node = stack.back();
    stack.pop_back();
    std::vector<uint32_t> children;
    tree.ForEachChild(node, [&](uint32_t child) {
      if (tree.is_cluster(node) || active[child] != 0) children.push_back(child);
    });
    nodes.own.push_back(node);
    nodes.is_leaf.push_back(children.empty() ? 1 : 0);
    if (children.empty()) nodes.leaves.push_back(node);
    stack.insert(stack.end(), children.rbegin(), children.rend());
  }
}

// An element that is an end of a link is there, with its sibling and all above.
void Activate(const Tree& tree, uint32_t node, std::vector<uint8_t>& active) {
  while (!tree.is_cluster(node) && active[node] == 0) {
    active[node] = 1;
    const Node& n = tree.node(node);
    if (n.id.is_surface()) return;
    active[tree.node(n.parent).first_child + ((n.id.path & 1) ^ 1)] = 1;
    node = n.parent;
  }
}

// Directions in which the values of clusters are needed: those asked for, and the same of all
// clusters below.
void NeedBelow(const Tree& tree, std::vector<uint16_t>& directions) {
  for (uint32_t c = 0; c < directions.size(); ++c) {  // parents come first
    const Cluster& cluster = tree.cluster(c);
    for (uint32_t i = 0; i < cluster.child_count; ++i) {
      directions[cluster.first_child + i] |= directions[c];
    }
  }
}

// What the links here need of others, by home: ids of slots, sorted. `ends` gets, for each node,
// whether it is the end of a link.
std::vector<std::vector<NodeId>> ListWanted(const Tree& tree, const Placement& placement,
                                            const LinkSet& links, std::vector<uint8_t>& ends,
                                            std::vector<uint16_t>& directions) {
  const Slots slots(tree);
  const Assignment& assignment = placement.assignment();
  ends.assign(tree.size(), 0);
  std::vector<uint8_t> needed(slots.count(tree), 0);  // of slots
  const auto need = [&](const Link& link) {
    const Slots::Ends e = slots.Of(tree, link.p, link.q);
    needed[e.p] = needed[e.q] = 1;
  };
  for (const Link& link : links.own) {
    ends[link.p] = ends[link.q] = 1;
    need(link);
  }
  for (const Link& link : links.crown) {
    ends[link.p] = ends[link.q] = 1;
    if (placement.HomeOfLink(link.p, link.q) == placement.self()) need(link);
  }
  directions.assign(tree.hierarchy().clusters().size(), 0);
  for (uint32_t slot = 0; slots.is_cluster(slot); ++slot) {
    if (needed[slot] != 0) {
      directions[slots.NodeOf(slot)] |= static_cast<uint16_t>(1U << slots.DirectionOf(slot));
    }
  }
  // A crown cluster's value is pulled from the cut here, so those of the cut below are needed too.
  std::vector<uint16_t> crown(directions.size(), 0);
  for (uint32_t c = 0; c < crown.size(); ++c) {
    if (placement.InCrown(c)) crown[c] = directions[c];
  }
  for (uint32_t c = 0; c < crown.size(); ++c) {
    const Cluster& cluster = tree.cluster(c);
    if (!placement.InCrown(c)) continue;
    for (uint32_t i = 0; i < cluster.child_count; ++i) {
      crown[cluster.first_child + i] |= crown[c];
    }
  }
  std::vector<std::vector<NodeId>> wanted(assignment.worker_count);
  for (uint32_t slot = 0; slot < needed.size(); ++slot) {
    const uint32_t node = slots.NodeOf(slot);
    if (placement.InCrown(node)) continue;
    const bool above = slots.is_cluster(slot) &&
                       placement.cut_node(placement.CutOf(node)) == node &&
                       (crown[node] >> slots.DirectionOf(slot) & 1) != 0;
    const uint32_t home = placement.HomeOf(node);
    if ((needed[slot] != 0 || above) && home != placement.self()) {
      wanted[home].push_back(slots.IdOf(tree, slot));
    }
  }
  for (auto& ids : wanted) std::sort(ids.begin(), ids.end());
  return wanted;
}

}  // namespace

Result<ActiveNodes> Subscribe(Tree& tree, Placement& placement, const LinkSet& links,
                              Exchange& exchange) {
  const Slots slots(tree);
  ActiveNodes nodes;
  std::vector<uint8_t> ends;
  const std::vector<std::vector<NodeId>> wanted =
      ListWanted(tree, placement, links, ends, nodes.directions);
  ASSIGN_OR_RETURN(const std::vector<NodeId> exported, exchange.Subscribe(wanted));
  for (const NodeId& id : exported) {
    if (!id.is_cluster() && id.surface < tree.hierarchy().surfaces().size() &&
        id.level() <= kMaxLevel) {
      tree.FindOrMake(id);
      placement.Extend(tree);
    }
    const uint32_t slot = slots.Find(tree, id);
    if (slot == kNoNode) {
      return Error(StatusCode::kInternal, "another worker wants node {}:{}", id.surface, id.path);
    }
    const uint32_t node = slots.NodeOf(slot);
    if (!placement.IsMine(node)) {
      return Error(StatusCode::kInternal, "node {}:{} is wanted from the wrong worker", id.surface,
                   id.path);
    }
    nodes.exported.push_back(slot);
    ends.resize(tree.size(), 0);
    ends[node] = 1;
    if (slots.is_cluster(slot)) {
      nodes.directions[node] |= static_cast<uint16_t>(1U << slots.DirectionOf(slot));
    }
  }
  NeedBelow(tree, nodes.directions);
  for (const auto& ids : wanted) {
    for (const NodeId& id : ids) nodes.proxies.push_back(slots.Find(tree, id));
  }
  std::vector<uint8_t> active(tree.size(), 0);
  for (uint32_t node = 0; node < ends.size(); ++node) {
    if (ends[node] != 0) Activate(tree, node, active);
  }
  // The cut's own nodes exist whatever the links say.
  for (uint32_t c = 0; c < placement.cut_size(); ++c) Activate(tree, placement.cut_node(c), active);
  for (uint32_t c = 0; c < placement.cut_size(); ++c) {
    if (placement.assignment().home[c] == placement.self())
      ListActive(tree, active, placement.cut_node(c), nodes);
  }
  return nodes;
}

Product::Product(const Tree& tree, const Placement& placement, LinkSet& links,
                 const ActiveNodes& active, ThreadPool& pool, Exchange& exchange)
    : tree_(tree),
      placement_(placement),
      active_(active),
      pool_(pool),
      exchange_(exchange),
      slots_(tree) {
  const auto first_remote = std::partition(
      links.own.begin(), links.own.end(),
      [&](const Link& link) { return placement.IsMine(link.p) && placement.IsMine(link.q); });
  const auto local_count = static_cast<size_t>(first_remote - links.own.begin());
  local_ = std::span(links.own).first(local_count);
  remote_ = std::span(links.own).subspan(local_count);
  for (const Link& link : links.crown) {
    if (placement.HomeOfLink(link.p, link.q) == placement.self()) crown_.push_back(link);
  }
  const size_t count = slots_.count(tree);
  inverse_area_.resize(count);
  for (uint32_t slot = 0; slot < count; ++slot) {
    const uint32_t node = slots_.NodeOf(slot);
    const double area = slots_.is_cluster(slot)
                            ? tree.facing().area_m2(node, slots_.DirectionOf(slot))
                            : tree.area_m2(node);
    inverse_area_[slot] = area > 0 ? 1 / area : 0;
  }
  ends_.resize(links.own.size());
  pool.For(ends_.size(), 8192, [&](size_t begin, size_t end, int) {
    for (size_t i = begin; i < end; ++i) {
      ends_[i] = slots_.Of(tree, links.own[i].p, links.own[i].q);
    }
  });
  for (const Link& link : crown_) crown_ends_.push_back(slots_.Of(tree, link.p, link.q));
  leaf_of_.assign(count, kNoNode);
  for (uint32_t i = 0; i < active.leaves.size(); ++i) {
    leaf_of_[slots_.OfElement(active.leaves[i])] = i;
  }
  inheritance_.assign(active.leaves.size(), 1.0);
  from_above_.resize(active.leaves.size());
  cut_upward_.resize(placement.cut_size());
  value_.assign(count, Lanes{});
  sum_.assign(pool.thread_count(), std::vector<IntLanes>(count, IntLanes{}));
}

Status Product::Irradiance(std::span<const Lanes> radiosity, double bound, int lanes,
                           std::span<Lanes> irradiance, LinkScope scope,
                           std::span<Lanes> inherited) {
  bound *= gain_;
  if (!(bound > 0)) {
    // Nothing radiates, here or anywhere.
    std::fill(irradiance.begin(), irradiance.end(), Lanes{});
    return {};
  }
  // |F x| ≤ |x| < 2^50 units: the sum of a row that adds up to 1 has room to spare.
  const int exponent = 49 - std::ilogb(bound);
  const double scale = std::ldexp(1.0, exponent);
  std::vector<IntLanes> sums(leaf_count());
  RETURN_IF_ERROR(Sums(
      radiosity, lanes, {},
      [&](const Link& link, const Slots::Ends& ends, const Lanes& xp, const Lanes& xq, Lanes& to_p,
          Lanes& to_q) {
        const double c = link.coupling_m2() * scale;
        to_p = xq * (c * inverse_area_[ends.p]);
        to_q = xp * (c * inverse_area_[ends.q]);
      },
      sums, scope));
  const double unit = std::ldexp(1.0, -exponent);
  for (size_t i = 0; i < sums.size(); ++i) {
    for (int lane = 0; lane < 4; ++lane) {
      irradiance[i][lane] = static_cast<double>(sums[i][lane]) * unit;
    }
  }
  for (size_t i = 0; i < inherited.size(); ++i) {
    for (int lane = 0; lane < 4; ++lane) {
      inherited[i][lane] = static_cast<double>(from_above_[i][lane]) * unit;
    }
  }
  return {};
}

Status Product::SetInheritance(std::span<const double> of_leaves) {
  CHECK_EQ(of_leaves.size(), inheritance_.size());
  std::copy(of_leaves.begin(), of_leaves.end(), inheritance_.begin());
  PullOwn(std::vector<Lanes>(leaf_count(), Splat(1.0)));
  Reduction reduction;
  reduction.maxima = {1};
  const auto take = [&](uint32_t slot) {
    reduction.maxima[0] = std::max(reduction.maxima[0], value_[slot][0]);
  };
  for (const uint32_t node : active_.own) {
    if (!tree_.is_cluster(node)) {
      take(slots_.OfElement(node));
      continue;
    }
    for (int d = 0; d < kDirections; ++d) {
      if ((active_.directions[node] >> d & 1) != 0) take(slots_.OfCluster(node, d));
    }
  }
  // Those of the crown are means of what the cut's nodes give.
  for (uint32_t k = 0; k < placement_.cut_size(); ++k) {
    const uint32_t node = placement_.cut_node(k);
    if (tree_.is_cluster(node) || placement_.assignment().home[k] != placement_.self()) continue;
    const uint32_t leaf = leaf_of_[slots_.OfElement(node)];
    if (leaf != kNoNode) reduction.maxima[0] = std::max(reduction.maxima[0], inheritance_[leaf]);
  }
  ASSIGN_OR_RETURN(const Reduction total, exchange_.Reduce(std::move(reduction)));
  gain_ = total.maxima[0];
  return {};
}

// What an element gives to the radiosity of its parent.
Lanes Product::Upward(uint32_t child) const {
  if (placement_.InCrown(tree_.node(child).parent) && !placement_.InCrown(child)) {
    return cut_upward_[placement_.CutOf(child)];
  }
  const uint32_t slot = slots_.OfElement(child);
  const uint32_t leaf = leaf_of_[slot];
  return leaf == kNoNode ? value_[slot] : value_[slot] * inheritance_[leaf];
}

// Radiosity of a cluster as seen from one direction: the mean over the area that faces it.
Lanes Product::PullCluster(uint32_t cluster, int direction) const {
  Lanes sum{};
  tree_.ForEachChild(cluster, [&](uint32_t child) {
    if (tree_.is_cluster(child)) {
      sum += tree_.facing().area_m2(child, direction) * value_[slots_.OfCluster(child, direction)];
    } else {
      const double cosine = tree_.facing().cosine(tree_.node(child).id.surface, direction);
      sum += (tree_.area_m2(child) * cosine) * Upward(child);
    }
  });
  return sum * inverse_area_[slots_.OfCluster(cluster, direction)];
}

void Product::PullOwn(std::span<const Lanes> leaf_values) {
  CHECK_EQ(leaf_values.size(), active_.leaves.size());
  size_t leaf = leaf_values.size();
  for (size_t k = active_.own.size(); k-- > 0;) {
    const uint32_t node = active_.own[k];
    if (active_.is_leaf[k] != 0) {
      value_[slots_.OfElement(node)] = leaf_values[--leaf];
    } else {
      Pull(node);
    }
  }
}

// From the children that have their values.
void Product::Pull(uint32_t node) {
  if (tree_.is_cluster(node)) {
    for (int d = 0; d < kDirections; ++d) {
      if ((active_.directions[node] >> d & 1) == 0) continue;
      value_[slots_.OfCluster(node, d)] = PullCluster(node, d);
    }
    return;
  }
  Lanes sum{};
  tree_.ForEachChild(node, [&](uint32_t child) { sum += Upward(child) * tree_.area_m2(child); });
  const uint32_t slot = slots_.OfElement(node);
  value_[slot] = sum * inverse_area_[slot];
}

Status Product::SendOwnValues(int lanes) {
  const auto pack = [&](std::vector<double>& out, uint32_t slot) {
    for (int lane = 0; lane < lanes; ++lane) out.push_back(value_[slot][lane]);
  };
  std::vector<double> cut, exported;
  for (uint32_t c = 0; c < placement_.cut_size(); ++c) {
    if (placement_.assignment().home[c] != placement_.self()) continue;
    const uint32_t node = placement_.cut_node(c);
    // The values of clusters are wanted by direction: they travel as proxies.
    Lanes upward{};
    if (!tree_.is_cluster(node)) {
      const uint32_t slot = slots_.OfElement(node);
      upward = value_[slot] * (leaf_of_[slot] == kNoNode ? 1.0 : inheritance_[leaf_of_[slot]]);
    }
    for (int lane = 0; lane < lanes; ++lane) cut.push_back(upward[lane]);
  }
  exported.reserve(active_.exported.size() * lanes);
  for (const uint32_t slot : active_.exported) pack(exported, slot);
  return exchange_.SendValues(cut, exported);
}

Status Product::ReceiveOtherValues(int lanes) {
  const double start = Now();
  ASSIGN_OR_RETURN(const ReceivedValues received, exchange_.ReceiveValues());
  wait_s_ += Now() - start;
  if (received.cut.size() != size_t{placement_.cut_size()} * lanes ||
      received.proxies.size() != active_.proxies.size() * lanes) {
    return {StatusCode::kInternal, "values of a product have the wrong length"};
  }
  for (size_t i = 0; i < active_.proxies.size(); ++i) {
    for (int lane = 0; lane < lanes; ++lane) {
      value_[active_.proxies[i]][lane] = received.proxies[i * lanes + lane];
    }
  }
  PullCrown(received.cut, lanes);
  return {};
}

void Product::PullCrown(std::span<const double> cut_values, int lanes) {
  for (uint32_t c = 0; c < placement_.cut_size(); ++c) {
    for (int lane = 0; lane < lanes; ++lane) {
      cut_upward_[c][lane] = cut_values[size_t{c} * lanes + lane];
    }
  }
  const auto& crown = placement_.crown();
  for (size_t k = crown.size(); k-- > 0;) Pull(crown[k]);
}

void Product::CollectThreads() {
  if (sum_.size() == 1) return;
  pool_.For(sum_[0].size(), 8192, [&](size_t begin, size_t end, int) {
    for (size_t t = 1; t < sum_.size(); ++t) {
      for (size_t i = begin; i < end; ++i) sum_[0][i] += sum_[t][i];
    }
  });
}

Status Product::ExchangeSums(int lanes) {
  std::vector<IntLanes>& sum = sum_[0];
  std::vector<uint32_t> crown;  // slots
  for (const uint32_t node : placement_.crown()) {
    if (!tree_.is_cluster(node)) {
      crown.push_back(slots_.OfElement(node));
      continue;
    }
    for (int d = 0; d < kDirections; ++d) crown.push_back(slots_.OfCluster(node, d));
  }
  const auto pack = [&](const std::vector<uint32_t>& slots) {
    std::vector<int64_t> out;
    out.reserve(slots.size() * lanes);
    for (const uint32_t slot : slots) {
      for (int lane = 0; lane < lanes; ++lane) out.push_back(sum[slot][lane]);
    }
    return out;
  };
  RETURN_IF_ERROR(exchange_.SendSums(pack(crown), pack(active_.proxies)));
  const double start = Now();
  ASSIGN_OR_RETURN(const ReceivedSums received, exchange_.ReceiveSums());
  wait_s_ += Now() - start;
  const bool alone = received.exported.empty() && active_.exported.empty();
  if (received.crown.size() != crown.size() * lanes ||
      (!alone && received.exported.size() != active_.exported.size() * lanes)) {
    return {StatusCode::kInternal, "sums of a product have the wrong length"};
  }
  for (size_t i = 0; i < crown.size(); ++i) {
    for (int lane = 0; lane < lanes; ++lane) sum[crown[i]][lane] = received.crown[i * lanes + lane];
  }
  for (size_t i = 0; i < active_.exported.size(); ++i) {
    for (int lane = 0; lane < lanes; ++lane) {
      sum[active_.exported[i]][lane] += received.exported[i * lanes + lane];
    }
  }
  return {};
}

// A cluster's clusters take over what it received; its surfaces take it in proportion to the cosine
// of the direction. Rounded here, once for each surface, from the sum over all links.
void Product::PushCluster(uint32_t cluster) {
  std::vector<IntLanes>& sum = sum_[0];
  for (int d = 0; d < kDirections; ++d) {
    const IntLanes whole = sum[slots_.OfCluster(cluster, d)];
    if ((whole[0] | whole[1] | whole[2] | whole[3]) == 0) continue;
    tree_.ForEachChild(cluster, [&](uint32_t child) {
      if (tree_.is_cluster(child)) {
        sum[slots_.OfCluster(child, d)] += whole;
        return;
      }
      const double cosine = tree_.facing().cosine(tree_.node(child).id.surface, d);
      IntLanes& target = Inbox(child);
      for (int lane = 0; lane < 4; ++lane) {
        target[lane] += static_cast<int64_t>(cosine * static_cast<double>(whole[lane]));
      }
    });
  }
}

// Where a node puts what it hands down to an element: a leaf keeps it apart.
IntLanes& Product::Inbox(uint32_t child) {
  const uint32_t slot = slots_.OfElement(child);
  const uint32_t leaf = leaf_of_[slot];
  return leaf == kNoNode ? sum_[0][slot] : from_above_[leaf];
}

void Product::PushDown(std::array<Inherit, 4> inherit, std::span<IntLanes> sums) {
  std::vector<IntLanes>& sum = sum_[0];
  IntLanes half{};  // lanes of which elements hand down half
  for (int lane = 0; lane < 4; ++lane) half[lane] = inherit[lane] == Inherit::kHalf ? -1 : 0;
  const auto push = [&](uint32_t node) {
    if (tree_.is_cluster(node)) return PushCluster(node);
    const IntLanes whole = sum[slots_.OfElement(node)];
    const IntLanes down = (half & (whole >> 1)) | (~half & whole);
    tree_.ForEachChild(node, [&](uint32_t child) { Inbox(child) += down; });
  };
  std::fill(from_above_.begin(), from_above_.end(), IntLanes{});
  for (const uint32_t node : placement_.crown()) push(node);
  size_t leaf = 0;
  for (size_t k = 0; k < active_.own.size(); ++k) {
    if (active_.is_leaf[k] != 0) {
      IntLanes total = sum[slots_.OfElement(active_.own[k])];
      for (int lane = 0; lane < 4; ++lane) {
        total[lane] +=
            static_cast<int64_t>(inheritance_[leaf] * static_cast<double>(from_above_[leaf][lane]));
      }
      sums[leaf++] = total;
    } else {
      push(active_.own[k]);
    }
  }
}

uint64_t Product::memory_bytes() const {
  return crown_.size() * sizeof(Link) + (ends_.size() + crown_ends_.size()) * sizeof(Slots::Ends) +
         inverse_area_.size() * sizeof(double) + value_.size() * sizeof(Lanes) +
         sum_.size() * value_.size() * sizeof(IntLanes);
}

}  // namespace isolux
