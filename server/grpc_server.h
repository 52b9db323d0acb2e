// The coordinator's gRPC server: its services, limits, keepalive, health and reflection.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/util/status.h"

namespace grpc {
class Server;
class Service;
}  // namespace grpc

namespace isolux {

struct GrpcServerOptions {
  std::string listen = "127.0.0.1:7400";  // port 0: a free one
  bool insecure = false;                  // allows an address that others can reach
  double keepalive_s = 10;
  double keepalive_timeout_s = 5;
};

class GrpcServer {
 public:
  // kFailedPrecondition when the address is taken, kInvalidArgument when it is none, or one that
  // others can reach without `insecure`.
  static Result<std::unique_ptr<GrpcServer>> Start(const GrpcServerOptions& options,
                                                   const std::vector<grpc::Service*>& services);
  ~GrpcServer();

  const std::string& address() const { return address_; }  // with the port that it got
  int port() const { return port_; }

  // What grpc.health.v1 answers, for the whole and for each service.
  void SetServing(bool serving);
  // Ends every call that is still open after `grace_s`.
  void Shutdown(double grace_s);

 private:
  GrpcServer();
  std::unique_ptr<grpc::Server> server_;
  std::string address_;
  int port_ = 0;
};

}  // namespace isolux
