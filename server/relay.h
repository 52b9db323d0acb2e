// What the coordinator makes of one collective: one message of every worker in, one reply for every
// worker out. Pure functions on decoded messages, so that they can be tested without workers.
//
// Vectors of messages are indexed by the worker's number in the assignment; a worker that has been
// released sends nothing (nullopt) and gets an empty reply.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "common/hierarchy/assignment.h"
#include "common/hierarchy/collectives.h"
#include "common/rpc/protocol.h"
#include "common/util/status.h"

namespace isolux {

template <typename T>
using PerWorker = std::vector<std::optional<T>>;

// Maxima by maximum, sums exactly, counts by addition.
Result<Reduction> Combine(const PerWorker<Reduction>& parts);

// Who needs which nodes of whom, for the products of one round.
struct Subscriptions {
  std::vector<std::vector<NodeId>> exported;  // by home: what others want, each once, sorted
  // index[w][h]: for each node of h that w wants, its place in exported[h].
  std::vector<std::vector<std::vector<uint32_t>>> index;
};

// Fails where somebody asks itself, or a worker that is gone. The homes check that they have what
// is wanted.
Result<Subscriptions> Subscribe(const PerWorker<SubscribeRequest>& requests, uint32_t worker_count);

// Own cut values and exported values of each worker, fanned out: to each the other cut values and
// what it wants, home by home. Every value travels up once, and once to each worker that wants it.
Result<std::vector<ValuesReply>> FanOut(const PerWorker<Values>& values,
                                        const Subscriptions& subscriptions,
                                        const Assignment& assignment);

// The way back: sums for the crown added over all workers, sums for proxies added up at their
// homes. A sum that does not fit is an error (kOutOfRange), never a wrap.
Result<std::vector<SumsReply>> AddUp(const PerWorker<Sums>& sums,
                                     const Subscriptions& subscriptions);

}  // namespace isolux
