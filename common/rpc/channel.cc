#include "common/rpc/channel.h"

#include <grpc/support/log.h>
#include <grpcpp/create_channel.h>
#include <grpcpp/security/credentials.h>

#include <algorithm>
#include <charconv>
#include <chrono>

#include "common/util/log.h"

namespace isolux {
namespace {

// Submitting is not among them: a stream is not repeated by the channel but by the client, which
// has the scene and the request id.
constexpr const char* kServiceConfig = R"({
  "methodConfig": [{
    "name": [
      {"service": "isolux.v1.JobService", "method": "GetJob"},
      {"service": "isolux.v1.JobService", "method": "ListJobs"},
      {"service": "isolux.v1.JobService", "method": "ListWorkers"},
      {"service": "isolux.v1.JobService", "method": "CancelJob"}
    ],
    "retryPolicy": {
      "maxAttempts": 4,
      "initialBackoff": "0.1s",
      "maxBackoff": "2s",
      "backoffMultiplier": 2,
      "retryableStatusCodes": ["UNAVAILABLE"]
    }
  }]
})";

int Milliseconds(double seconds) { return static_cast<int>(seconds * 1000); }

}  // namespace

void RouteGrpcLog() {
  gpr_set_log_function([](gpr_log_func_args* args) { LogDebug("gRPC: {}", args->message); });
}

Status ChannelOptions::Validate() const {
  const size_t colon = server.rfind(':');
  int port = -1;
  if (colon != std::string::npos && colon > 0) {
    const char* end = server.data() + server.size();
    const auto [rest, error] = std::from_chars(server.data() + colon + 1, end, port);
    if (error != std::errc() || rest != end) port = -1;
  }
  if (port < 1 || port > 65535) {
    return MakeStatus(StatusCode::kInvalidArgument,
                      "'{}' is not the address of a server: write HOST:PORT, for instance {}",
                      server, kDefaultServer);
  }
  return {};
}

std::shared_ptr<grpc::Channel> MakeChannel(const ChannelOptions& options) {
  RouteGrpcLog();
  grpc::ChannelArguments args;
  args.SetInt(GRPC_ARG_KEEPALIVE_TIME_MS, Milliseconds(options.keepalive_s));
  args.SetInt(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, Milliseconds(options.keepalive_timeout_s));
  args.SetInt(GRPC_ARG_KEEPALIVE_PERMIT_WITHOUT_CALLS, 1);
  args.SetInt(GRPC_ARG_HTTP2_MAX_PINGS_WITHOUT_DATA, 0);
  args.SetInt(GRPC_ARG_INITIAL_RECONNECT_BACKOFF_MS, 100);
  args.SetInt(GRPC_ARG_MIN_RECONNECT_BACKOFF_MS, 100);
  args.SetInt(GRPC_ARG_MAX_RECONNECT_BACKOFF_MS, 2000);
  // gRPC would take http_proxy from the environment, even for loopback.
  args.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);
  args.SetMaxReceiveMessageSize(options.max_message_bytes);
  args.SetServiceConfigJSON(kServiceConfig);
  return grpc::CreateCustomChannel(options.server, grpc::InsecureChannelCredentials(), args);
}

void SetDeadline(grpc::ClientContext& context, double seconds) {
  context.set_deadline(std::chrono::system_clock::now() +
                       std::chrono::milliseconds(Milliseconds(seconds)));
}

Status FromGrpc(const grpc::Status& status, const std::string& server) {
  if (status.ok()) return {};
  const auto code = static_cast<StatusCode>(status.error_code());
  // What the server says itself is clear already; the rest is gRPC's own wording.
  const std::string& text = status.error_message();
  const bool no_connection =
      code == StatusCode::kUnavailable && (text.find("failed to connect") != std::string::npos ||
                                           text.find("DNS resolution") != std::string::npos);
  if (no_connection) {
    return MakeStatus(code,
                      "no server answers at {}: start isolux-server, or name another address with "
                      "--server or ISOLUX_SERVER ({})",
                      server, text);
  }
  if (code == StatusCode::kDeadlineExceeded && text == "Deadline Exceeded") {
    return MakeStatus(code, "the server at {} did not answer in time", server);
  }
  return Status(code, text.empty() ? "the call to " + server + " failed" : text);
}

grpc::Status ToGrpc(const Status& status) {
  if (status.ok()) return grpc::Status::OK;
  // Longer messages may not fit into the trailing metadata.
  constexpr size_t kMaxMessage = 2000;
  return grpc::Status(static_cast<grpc::StatusCode>(status.code()),
                      status.message().substr(0, std::min(status.message().size(), kMaxMessage)));
}

}  // namespace isolux
