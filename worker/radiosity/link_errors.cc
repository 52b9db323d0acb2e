#include "worker/radiosity/link_errors.h"

namespace isolux {

ErrorHistogram CountErrors(const Tree& tree, const Placement& placement, const LinkSet& links,
                           ThreadPool& pool) {
  std::vector<ErrorHistogram> by_thread(static_cast<size_t>(pool.thread_count()));
  const auto count = [&](const std::vector<Link>& some, bool shared) {
    pool.For(some.size(), 4096, [&](size_t begin, size_t end, int thread) {
      for (size_t i = begin; i < end; ++i) {
        const Link& link = some[i];
        if (shared && placement.HomeOfLink(link.p, link.q) != placement.self()) continue;
        by_thread[static_cast<size_t>(thread)].Add(
            ErrorOf(tree, link, tree.values(link.p), tree.values(link.q)).total_w);
      }
    });
  };
  count(links.own, false);
  count(links.crown, true);
  for (size_t t = 1; t < by_thread.size(); ++t) by_thread[0].Add(by_thread[t]);
  return by_thread[0];
}

}  // namespace isolux
