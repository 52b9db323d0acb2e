#include "worker/radiosity/link_migration.h"

#include <cmath>
#include <cstring>

namespace isolux {

std::vector<MigrationParcel> TakeLeaving(const Placement& now, LinkSet* links) {
  LinkSet kept;
  std::vector<std::vector<Link>> leaving(now.assignment().worker_count);
  for (const Link& link : links->crown) {
    if (now.IsCrownLink(link.p, link.q)) {
      kept.crown.push_back(link);
    } else if (now.HomeOfLink(link.p, link.q) == now.self()) {
      kept.own.push_back(link);  // every worker had it; its home keeps it
    }
  }
  for (const Link& link : links->own) {
    if (now.IsCrownLink(link.p, link.q)) {
      // An end has come to lie above the cut: from now on everybody's.
      kept.crown.push_back(link);
      for (auto& to : leaving) to.push_back(link);
    } else if (const uint32_t home = now.HomeOfLink(link.p, link.q); home == now.self()) {
      kept.own.push_back(link);
    } else {
      leaving[home].push_back(link);
    }
  }
  *links = std::move(kept);
  std::vector<MigrationParcel> parcels;
  for (uint32_t to = 0; to < leaving.size(); ++to) {
    if (to == now.self() || leaving[to].empty()) continue;
    MigrationParcel parcel;
    parcel.to = to;
    parcel.links = leaving[to].size();
    parcel.bytes.assign(reinterpret_cast<const char*>(leaving[to].data()),
                        leaving[to].size() * sizeof(Link));
    parcels.push_back(std::move(parcel));
  }
  return parcels;
}

Status AbsorbParcel(const std::string& bytes, const Tree& tree, const Placement& placement,
                    LinkSet* links) {
  if (bytes.size() % sizeof(Link) != 0) {
    return {StatusCode::kDataLoss, "migration: a parcel does not hold whole links"};
  }
  const size_t images = tree.mirrors() == nullptr ? 0 : tree.mirrors()->images().size();
  for (size_t at = 0; at < bytes.size(); at += sizeof(Link)) {
    Link link;
    std::memcpy(&link, bytes.data() + at, sizeof link);
    if (link.p >= tree.size() || link.q >= tree.size() ||
        tree.node(link.q).id < tree.node(link.p).id || !(link.unoccluded_m2 >= 0) ||
        !std::isfinite(link.unoccluded_m2) || (link.through_mirrors() && link.image() >= images)) {
      return {StatusCode::kDataLoss, "migration: a link between nodes that do not exist"};
    }
    (placement.IsCrownLink(link.p, link.q) ? links->crown : links->own).push_back(link);
  }
  return {};
}

}  // namespace isolux
