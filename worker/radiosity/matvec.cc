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

}  // namespace

Result<ActiveNodes> Subscribe(Tree& tree, Placement& placement, const LinkSet& links,
                              Exchange& exchange) {
  const Assignment& assignment = placement.assignment();
  // Ends of any link here are there; only the values of those we multiply by are needed.
  constexpr uint8_t kThere = 1, kNeeded = 2;
  std::vector<uint8_t> ends(tree.size(), 0);
  for (const Link& link : links.own) ends[link.p] = ends[link.q] = kNeeded;
  for (const Link& link : links.crown) {
    const bool mine = placement.HomeOfLink(link.p, link.q) == placement.self();
    for (const uint32_t end : {link.p, link.q})
      ends[end] = std::max(ends[end], mine ? kNeeded : kThere);
  }
  std::vector<std::vector<NodeId>> wanted(assignment.worker_count);
  for (uint32_t node = 0; node < ends.size(); ++node) {
    if (ends[node] != kNeeded || placement.InCrown(node)) continue;
    const uint32_t home = placement.HomeOf(node);
    if (home != placement.self()) wanted[home].push_back(tree.node(node).id);
  }
  for (auto& ids : wanted) std::sort(ids.begin(), ids.end());
  ASSIGN_OR_RETURN(const std::vector<NodeId> exported, exchange.Subscribe(wanted));

  ActiveNodes nodes;
  for (const NodeId& id : exported) {
    const bool known = id.is_cluster() ? tree.Find(id) != kNoNode
                                       : id.surface < tree.hierarchy().surfaces().size() &&
                                             id.level() <= kMaxLevel;
    if (!known)
      return Error(StatusCode::kInternal, "another worker wants node {}:{}", id.surface, id.path);
    nodes.exported.push_back(id.is_cluster() ? tree.Find(id) : tree.FindOrMake(id));
    placement.Extend(tree);
    if (!placement.IsMine(nodes.exported.back())) {
      return Error(StatusCode::kInternal, "node {}:{} is wanted from the wrong worker", id.surface,
                   id.path);
    }
  }
  ends.resize(tree.size(), 0);
  for (const uint32_t node : nodes.exported) ends[node] = kThere;
  for (const auto& ids : wanted) {
    for (const NodeId& id : ids) nodes.proxies.push_back(tree.Find(id));
  }
  std::vector<uint8_t> active(tree.size(), 0);
  for (uint32_t node = 0; node < ends.size(); ++node) {
    if (ends[node] != 0) Activate(tree, node, active);
  }
  // The cut's own nodes exist whatever the links say.
  for (uint32_t c = 0; c < placement.cut_size(); ++c) Activate(tree, placement.cut_node(c), active);
  for (uint32_t c = 0; c < placement.cut_size(); ++c) {
    if (assignment.home[c] == placement.self())
      ListActive(tree, active, placement.cut_node(c), nodes);
  }
  return nodes;
}

Product::Product(const Tree& tree, const Placement& placement, LinkSet& links,
                 const ActiveNodes& active, ThreadPool& pool, Exchange& exchange)
    : tree_(tree), placement_(placement), active_(active), pool_(pool), exchange_(exchange) {
  const auto first_remote = std::partition(
      links.own.begin(), links.own.end(),
      [&](const Link& link) { return placement.IsMine(link.p) && placement.IsMine(link.q); });
  const auto local_count = static_cast<size_t>(first_remote - links.own.begin());
  local_ = std::span(links.own).first(local_count);
  remote_ = std::span(links.own).subspan(local_count);
  for (const Link& link : links.crown) {
    if (placement.HomeOfLink(link.p, link.q) == placement.self()) crown_.push_back(link);
  }
  inverse_area_.resize(tree.size());
  for (uint32_t i = 0; i < tree.size(); ++i) {
    const double area = tree.area_m2(i);
    inverse_area_[i] = area > 0 ? 1 / area : 0;
  }
  value_.assign(tree.size(), Lanes{});
  sum_.assign(pool.thread_count(), std::vector<IntLanes>(tree.size(), IntLanes{}));
}

Status Product::Irradiance(std::span<const Lanes> radiosity, double bound, int lanes,
                           std::span<Lanes> irradiance, LinkScope scope) {
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
      [&](const Link& link, const Lanes& xp, const Lanes& xq, Lanes& to_p, Lanes& to_q) {
        const double c = link.coupling_m2() * scale;
        to_p = xq * (c * inverse_area_[link.p]);
        to_q = xp * (c * inverse_area_[link.q]);
      },
      sums, scope));
  const double unit = std::ldexp(1.0, -exponent);
  for (size_t i = 0; i < sums.size(); ++i) {
    for (int lane = 0; lane < 4; ++lane) {
      irradiance[i][lane] = static_cast<double>(sums[i][lane]) * unit;
    }
  }
  return {};
}

void Product::PullOwn(std::span<const Lanes> leaf_values) {
  CHECK_EQ(leaf_values.size(), active_.leaves.size());
  size_t leaf = leaf_values.size();
  for (size_t k = active_.own.size(); k-- > 0;) {
    const uint32_t node = active_.own[k];
    if (active_.is_leaf[k] != 0) {
      value_[node] = leaf_values[--leaf];
      continue;
    }
    Lanes sum{};
    tree_.ForEachChild(node, [&](uint32_t child) { sum += value_[child] * tree_.area_m2(child); });
    value_[node] = sum * inverse_area_[node];
  }
}

Status Product::SendOwnValues(int lanes) {
  const auto pack = [&](std::vector<double>& out, uint32_t node) {
    for (int lane = 0; lane < lanes; ++lane) out.push_back(value_[node][lane]);
  };
  std::vector<double> cut, exported;
  for (uint32_t c = 0; c < placement_.cut_size(); ++c) {
    if (placement_.assignment().home[c] == placement_.self()) pack(cut, placement_.cut_node(c));
  }
  exported.reserve(active_.exported.size() * lanes);
  for (const uint32_t node : active_.exported) pack(exported, node);
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
      value_[placement_.cut_node(c)][lane] = cut_values[size_t{c} * lanes + lane];
    }
  }
  const auto& crown = placement_.crown();
  for (size_t k = crown.size(); k-- > 0;) {
    Lanes sum{};
    tree_.ForEachChild(crown[k],
                       [&](uint32_t child) { sum += value_[child] * tree_.area_m2(child); });
    value_[crown[k]] = sum * inverse_area_[crown[k]];
  }
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
  const auto pack = [&](const std::vector<uint32_t>& nodes) {
    std::vector<int64_t> out;
    out.reserve(nodes.size() * lanes);
    for (const uint32_t node : nodes) {
      for (int lane = 0; lane < lanes; ++lane) out.push_back(sum[node][lane]);
    }
    return out;
  };
  RETURN_IF_ERROR(exchange_.SendSums(pack(placement_.crown()), pack(active_.proxies)));
  const double start = Now();
  ASSIGN_OR_RETURN(const ReceivedSums received, exchange_.ReceiveSums());
  wait_s_ += Now() - start;
  const auto& crown = placement_.crown();
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

void Product::PushDown(std::array<Inherit, 4> inherit, std::span<IntLanes> sums) {
  std::vector<IntLanes>& sum = sum_[0];
  IntLanes half{};  // lanes of which elements hand down half
  for (int lane = 0; lane < 4; ++lane) half[lane] = inherit[lane] == Inherit::kHalf ? -1 : 0;
  const auto push = [&](uint32_t node) {
    const IntLanes whole = sum[node];
    const IntLanes down = tree_.is_cluster(node) ? whole : (half & (whole >> 1)) | (~half & whole);
    tree_.ForEachChild(node, [&](uint32_t child) { sum[child] += down; });
  };
  for (const uint32_t node : placement_.crown()) push(node);
  size_t leaf = 0;
  for (size_t k = 0; k < active_.own.size(); ++k) {
    if (active_.is_leaf[k] != 0) {
      sums[leaf++] = sum[active_.own[k]];
    } else {
      push(active_.own[k]);
    }
  }
}

uint64_t Product::memory_bytes() const {
  return crown_.size() * sizeof(Link) + inverse_area_.size() * sizeof(double) +
         value_.size() * sizeof(Lanes) + sum_.size() * value_.size() * sizeof(IntLanes);
}

}  // namespace isolux
