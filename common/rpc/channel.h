// How a client or worker reaches the coordinator: one struct of settings, one way to make the
// channel from it. Includes gRPC: for the adapters only.
#pragma once

#include <grpcpp/channel.h>
#include <grpcpp/client_context.h>
#include <grpcpp/support/status.h>

#include <memory>
#include <string>

#include "common/rpc/server_address.h"
#include "common/util/status.h"

namespace isolux {

struct ChannelOptions {
  std::string server = kDefaultServer;  // host:port, [v6]:port
  double keepalive_s = 10;              // between pings on a connection that is silent
  double keepalive_timeout_s = 5;       // without an answer, after which it is given up
  double call_deadline_s = 10;          // of a call that moves little
  int max_message_bytes = 4 << 20;      // received at once; bulk is streamed

  Status Validate() const;
};

// gRPC's own messages go to our log, as debug lines: what matters reaches the caller as a status.
void RouteGrpcLog();

// Does not wait for the connection. Calls that change nothing when repeated are repeated up to four
// times while the server is unavailable, by the channel's service configuration.
std::shared_ptr<grpc::Channel> MakeChannel(const ChannelOptions& options);

void SetDeadline(grpc::ClientContext& context, double seconds);

// `server` stands in messages about a server that cannot be reached.
Status FromGrpc(const grpc::Status& status, const std::string& server);
grpc::Status ToGrpc(const Status& status);

}  // namespace isolux
