#include "server/relay.h"

#include <algorithm>

namespace isolux {
namespace {

Status AddChecked(std::span<const int64_t> terms, std::span<int64_t> totals) {
  bool overflow = false;
  for (size_t i = 0; i < terms.size(); ++i) {
    overflow |= __builtin_add_overflow(totals[i], terms[i], &totals[i]);
  }
  if (overflow) return {StatusCode::kOutOfRange, "sums of irradiance do not fit 64 bits"};
  return {};
}

// Lanes a node, from numbers of `nodes` nodes; all lists must agree. 0: not known yet.
Status AgreeOnLanes(size_t numbers, size_t nodes, const char* what, size_t* lanes) {
  if (nodes == 0) {
    if (numbers == 0) return {};
  } else if (numbers != 0 && numbers % nodes == 0 && (*lanes == 0 || *lanes == numbers / nodes)) {
    *lanes = numbers / nodes;
    return {};
  }
  return MakeStatus(StatusCode::kInternal, "{}: {} numbers for {} nodes", what, numbers, nodes);
}

size_t CountWanted(const std::vector<std::vector<uint32_t>>& index) {
  size_t count = 0;
  for (const auto& list : index) count += list.size();
  return count;
}

}  // namespace

Result<Reduction> Combine(const PerWorker<Reduction>& parts) {
  std::optional<Reduction> total;
  for (const auto& part : parts) {
    if (!part) continue;
    if (!total) {
      total = *part;
      continue;
    }
    if (part->maxima.size() != total->maxima.size() || part->sums.size() != total->sums.size() ||
        part->counts.size() != total->counts.size()) {
      return Error(StatusCode::kInternal, "workers combine vectors of different lengths");
    }
    for (size_t i = 0; i < total->maxima.size(); ++i) {
      total->maxima[i] = std::max(total->maxima[i], part->maxima[i]);
    }
    for (size_t i = 0; i < total->sums.size(); ++i) total->sums[i].Add(part->sums[i]);
    for (size_t i = 0; i < total->counts.size(); ++i) {
      if (__builtin_add_overflow(total->counts[i], part->counts[i], &total->counts[i])) {
        return Error(StatusCode::kOutOfRange, "a count does not fit 64 bits");
      }
    }
  }
  return total.value_or(Reduction{});
}

Result<Subscriptions> Subscribe(const PerWorker<SubscribeRequest>& requests,
                                uint32_t worker_count) {
  Subscriptions result;
  result.exported.resize(worker_count);
  result.index.assign(worker_count, std::vector<std::vector<uint32_t>>(worker_count));
  for (uint32_t w = 0; w < worker_count; ++w) {
    if (!requests[w]) continue;
    const auto& wanted = requests[w]->wanted;
    if (wanted.size() != worker_count) {
      return Error(StatusCode::kInternal, "worker {} subscribes at {} workers of {}", w,
                   wanted.size(), worker_count);
    }
    for (uint32_t h = 0; h < worker_count; ++h) {
      if (wanted[h].empty()) continue;
      if (h == w || !requests[h]) {
        return Error(StatusCode::kInternal, "worker {} subscribes at worker {}", w, h);
      }
      result.exported[h].insert(result.exported[h].end(), wanted[h].begin(), wanted[h].end());
    }
  }
  for (auto& nodes : result.exported) {
    std::sort(nodes.begin(), nodes.end());
    nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  }
  for (uint32_t w = 0; w < worker_count; ++w) {
    if (!requests[w]) continue;
    for (uint32_t h = 0; h < worker_count; ++h) {
      // Both lists are sorted: one walk finds all places.
      const auto& wanted = requests[w]->wanted[h];
      const auto& exported = result.exported[h];
      auto& index = result.index[w][h];
      index.reserve(wanted.size());
      size_t at = 0;
      for (const NodeId& id : wanted) {
        while (exported[at] != id) ++at;
        index.push_back(static_cast<uint32_t>(at));
      }
    }
  }
  return result;
}

Result<std::vector<ValuesReply>> FanOut(const PerWorker<Values>& values,
                                        const Subscriptions& subscriptions,
                                        const Assignment& assignment) {
  const size_t workers = values.size();
  std::vector<size_t> own_cut(workers, 0);
  for (const uint32_t home : assignment.home) ++own_cut[home];
  size_t lanes = 0;
  for (size_t w = 0; w < workers; ++w) {
    const size_t cut_numbers = values[w] ? values[w]->own_cut.size() : 0;
    const size_t exported_numbers = values[w] ? values[w]->exported.size() : 0;
    RETURN_IF_ERROR(AgreeOnLanes(cut_numbers, own_cut[w], "values of the cut", &lanes));
    RETURN_IF_ERROR(AgreeOnLanes(exported_numbers, subscriptions.exported[w].size(),
                                 "values of exported nodes", &lanes));
  }
  std::vector<ValuesReply> replies(workers);
  for (size_t w = 0; w < workers; ++w) {
    if (!values[w]) continue;
    auto& cut = replies[w].other_cut;
    cut.reserve((assignment.cut.size() - own_cut[w]) * lanes);
    std::vector<size_t> next(workers, 0);  // of each home's own cut values
    for (const uint32_t home : assignment.home) {
      const double* from = values[home]->own_cut.data() + lanes * next[home]++;
      if (home != w) cut.insert(cut.end(), from, from + lanes);
    }
    auto& proxies = replies[w].proxies;
    proxies.reserve(lanes * CountWanted(subscriptions.index[w]));
    for (size_t h = 0; h < workers; ++h) {
      for (const uint32_t place : subscriptions.index[w][h]) {
        const double* from = values[h]->exported.data() + lanes * place;
        proxies.insert(proxies.end(), from, from + lanes);
      }
    }
  }
  return replies;
}

Result<std::vector<SumsReply>> AddUp(const PerWorker<Sums>& sums,
                                     const Subscriptions& subscriptions) {
  const size_t workers = sums.size();
  size_t lanes = 0;
  std::optional<std::vector<int64_t>> crown;
  for (size_t w = 0; w < workers; ++w) {
    if (!sums[w]) continue;
    RETURN_IF_ERROR(AgreeOnLanes(sums[w]->proxies.size(), CountWanted(subscriptions.index[w]),
                                 "sums for proxies", &lanes));
    if (!crown) {
      crown = sums[w]->crown;
      continue;
    }
    if (sums[w]->crown.size() != crown->size()) {
      return Error(StatusCode::kInternal, "workers have crowns of {} and {} numbers", crown->size(),
                   sums[w]->crown.size());
    }
    RETURN_IF_ERROR(AddChecked(sums[w]->crown, *crown));
  }
  std::vector<SumsReply> replies(workers);
  for (size_t w = 0; w < workers; ++w) {
    if (!sums[w]) continue;
    replies[w].crown = *crown;
    replies[w].exported.assign(subscriptions.exported[w].size() * lanes, 0);
  }
  for (size_t w = 0; w < workers; ++w) {
    if (!sums[w]) continue;
    std::span<const int64_t> from = sums[w]->proxies;
    for (size_t h = 0; h < workers; ++h) {
      for (const uint32_t place : subscriptions.index[w][h]) {
        RETURN_IF_ERROR(AddChecked(from.first(lanes),
                                   std::span(replies[h].exported).subspan(lanes * place, lanes)));
        from = from.subspan(lanes);
      }
    }
  }
  return replies;
}

}  // namespace isolux
