#include "server/grpc_server.h"

#include <arpa/inet.h>
#include <grpcpp/ext/proto_server_reflection_plugin.h>
#include <grpcpp/grpcpp.h>
#include <grpcpp/health_check_service_interface.h>

#include <charconv>
#include <chrono>

#include "common/rpc/channel.h"
#include "common/util/log.h"

namespace isolux {
namespace {

constexpr int kMaxMessageBytes = 4 << 20;
constexpr int kMaxMetadataBytes = 8 << 10;
constexpr int kMaxStreams = 64;  // on one connection
constexpr int kHandshakeMs = 10'000;

struct Address {
  std::string host;
  int port = 0;
};

Result<Address> ParseAddress(const std::string& text) {
  const size_t colon = text.rfind(':');
  Address address;
  bool good = colon != std::string::npos && colon > 0;
  if (good) {
    address.host = text.substr(0, colon);
    const char* end = text.data() + text.size();
    const auto [rest, error] = std::from_chars(text.data() + colon + 1, end, address.port);
    good = error == std::errc() && rest == end && address.port >= 0 && address.port <= 65535;
  }
  if (!good) {
    return Error(StatusCode::kInvalidArgument,
                 "'{}' is not an address to listen on: write HOST:PORT, for instance "
                 "127.0.0.1:7400 (port 0: a free one)",
                 text);
  }
  return address;
}

bool IsLoopback(const std::string& host) {
  in_addr v4{};
  if (::inet_pton(AF_INET, host.c_str(), &v4) == 1) return ntohl(v4.s_addr) >> 24 == 127;
  return host == "localhost" || host == "[::1]";
}

void SetArguments(const GrpcServerOptions& options, grpc::ServerBuilder* builder) {
  const int keepalive_ms = static_cast<int>(options.keepalive_s * 1000);
  // Without this a second server on the same port would start, and take half of the calls.
  builder->AddChannelArgument(GRPC_ARG_ALLOW_REUSEPORT, 0);
  builder->AddChannelArgument(GRPC_ARG_KEEPALIVE_TIME_MS, keepalive_ms);
  builder->AddChannelArgument(GRPC_ARG_KEEPALIVE_TIMEOUT_MS,
                              static_cast<int>(options.keepalive_timeout_s * 1000));
  builder->AddChannelArgument(GRPC_ARG_KEEPALIVE_PERMIT_WITHOUT_CALLS, 1);
  builder->AddChannelArgument(GRPC_ARG_HTTP2_MAX_PINGS_WITHOUT_DATA, 0);
  // Clients ping as often as this side does; anything much faster is an attack.
  builder->AddChannelArgument(GRPC_ARG_HTTP2_MIN_RECV_PING_INTERVAL_WITHOUT_DATA_MS,
                              keepalive_ms / 2);
  builder->AddChannelArgument(GRPC_ARG_HTTP2_MAX_PING_STRIKES, 2);
  builder->AddChannelArgument(GRPC_ARG_MAX_CONCURRENT_STREAMS, kMaxStreams);
  builder->AddChannelArgument(GRPC_ARG_MAX_METADATA_SIZE, kMaxMetadataBytes);
  builder->AddChannelArgument(GRPC_ARG_SERVER_HANDSHAKE_TIMEOUT_MS, kHandshakeMs);
  builder->SetMaxReceiveMessageSize(kMaxMessageBytes);
  // A compressed message is unpacked before its size is checked: none is accepted.
  builder->SetCompressionAlgorithmSupportStatus(GRPC_COMPRESS_GZIP, false);
  builder->SetCompressionAlgorithmSupportStatus(GRPC_COMPRESS_DEFLATE, false);
}

}  // namespace

GrpcServer::GrpcServer() = default;
GrpcServer::~GrpcServer() { Shutdown(0); }

Result<std::unique_ptr<GrpcServer>> GrpcServer::Start(const GrpcServerOptions& options,
                                                      const std::vector<grpc::Service*>& services) {
  ASSIGN_OR_RETURN(const auto address, ParseAddress(options.listen));
  if (!IsLoopback(address.host)) {
    if (!options.insecure) {
      return Error(StatusCode::kInvalidArgument,
                   "{} can be reached by others, and there are no credentials yet: listen on "
                   "127.0.0.1, or allow everybody who reaches it with --insecure",
                   options.listen);
    }
    LogWarn("listening on {} without credentials: whoever reaches it can run jobs", options.listen);
  }
  RouteGrpcLog();
  grpc::EnableDefaultHealthCheckService(true);
  grpc::reflection::InitProtoReflectionServerBuilderPlugin();
  grpc::ServerBuilder builder;
  SetArguments(options, &builder);
  std::unique_ptr<GrpcServer> server(new GrpcServer());
  builder.AddListeningPort(options.listen, grpc::InsecureServerCredentials(), &server->port_);
  for (grpc::Service* service : services) builder.RegisterService(service);
  server->server_ = builder.BuildAndStart();
  if (server->server_ == nullptr || server->port_ == 0) {
    return Error(StatusCode::kFailedPrecondition,
                 "{} cannot be listened on: another program has that port, or the address is not "
                 "of this machine; choose another with --listen",
                 options.listen);
  }
  server->address_ = address.host + ":" + std::to_string(server->port_);
  return server;
}

void GrpcServer::SetServing(bool serving) {
  grpc::HealthCheckServiceInterface* health = server_->GetHealthCheckService();
  if (health == nullptr) return;
  health->SetServingStatus(serving);
  health->SetServingStatus("isolux.v1.JobService", serving);
  health->SetServingStatus("isolux.v1.WorkerService", serving);
}

void GrpcServer::Shutdown(double grace_s) {
  if (server_ == nullptr) return;
  // Without a deadline this would wait for every stream to end by itself.
  server_->Shutdown(std::chrono::system_clock::now() +
                    std::chrono::milliseconds(static_cast<int>(grace_s * 1000)));
  server_.reset();
}

}  // namespace isolux
