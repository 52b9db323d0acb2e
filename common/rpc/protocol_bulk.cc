// The messages of the collectives and of the gather.
#include <utility>

#include "common/rpc/convert_nodes.h"
#include "common/rpc/convert_options.h"
#include "common/rpc/protocol.h"
#include "isolux/v1/worker_messages.pb.h"

namespace isolux {
namespace {

constexpr int kMinExponent = -2000, kMaxExponent = 2000;  // more than any double needs

template <typename Proto>
Status Parse(const std::string& payload, const char* what, Proto* message) {
  if (message->ParseFromString(payload)) return {};
  return MakeStatus(StatusCode::kDataLoss, "{}: {} bytes that are no such message", what,
                    payload.size());
}

}  // namespace

std::string Encode(const Reduction& message) {
  v1::Reduction proto;
  proto.set_maxima(ToBytes(message.maxima));
  for (const ExactSum& sum : message.sums) proto.add_sums()->set_words(ToBytes(sum.ToWords()));
  proto.set_counts(ToBytes(message.counts));
  return proto.SerializeAsString();
}

template <>
Result<Reduction> DecodeMessage(const std::string& payload) {
  v1::Reduction proto;
  RETURN_IF_ERROR(Parse(payload, "Reduce", &proto));
  Reduction message;
  RETURN_IF_ERROR(FromBytes(proto.maxima(), "Reduce", &message.maxima));
  RETURN_IF_ERROR(FromBytes(proto.counts(), "Reduce", &message.counts));
  message.sums.resize(static_cast<size_t>(proto.sums_size()));
  std::vector<int64_t> words;
  for (size_t i = 0; i < message.sums.size(); ++i) {
    RETURN_IF_ERROR(FromBytes(proto.sums(static_cast<int>(i)).words(), "Reduce", &words));
    if (!ExactSum::FromWords(words, &message.sums[i])) {
      return Error(StatusCode::kDataLoss, "Reduce: {} words that are no sum", words.size());
    }
  }
  return message;
}

std::string Encode(const SubscribeRequest& message) {
  v1::SubscribeRequest proto;
  for (const std::vector<NodeId>& ids : message.wanted) ToProto(ids, proto.add_wanted());
  return proto.SerializeAsString();
}

template <>
Result<SubscribeRequest> DecodeMessage(const std::string& payload) {
  v1::SubscribeRequest proto;
  RETURN_IF_ERROR(Parse(payload, "Subscribe", &proto));
  if (proto.wanted_size() > static_cast<int>(kMaxWorkers)) {
    return Error(StatusCode::kDataLoss, "Subscribe: lists for {} workers", proto.wanted_size());
  }
  SubscribeRequest message;
  message.wanted.resize(static_cast<size_t>(proto.wanted_size()));
  for (size_t i = 0; i < message.wanted.size(); ++i) {
    RETURN_IF_ERROR(FromProto(proto.wanted(static_cast<int>(i)), "Subscribe", &message.wanted[i]));
  }
  return message;
}

std::string Encode(const SubscribeReply& message) {
  v1::SubscribeReply proto;
  ToProto(message.exported, proto.mutable_exported());
  return proto.SerializeAsString();
}

template <>
Result<SubscribeReply> DecodeMessage(const std::string& payload) {
  v1::SubscribeReply proto;
  RETURN_IF_ERROR(Parse(payload, "SubscribeReply", &proto));
  SubscribeReply message;
  RETURN_IF_ERROR(FromProto(proto.exported(), "SubscribeReply", &message.exported));
  return message;
}

std::string EncodeValues(std::span<const double> own_cut, std::span<const double> exported) {
  v1::Values proto;
  proto.set_own_cut(ToBytes(own_cut));
  proto.set_exported(ToBytes(exported));
  return proto.SerializeAsString();
}

std::string Encode(const Values& message) {
  return EncodeValues(message.own_cut, message.exported);
}

template <>
Result<Values> DecodeMessage(const std::string& payload) {
  v1::Values proto;
  RETURN_IF_ERROR(Parse(payload, "Values", &proto));
  Values message;
  RETURN_IF_ERROR(FromBytes(proto.own_cut(), "Values", &message.own_cut));
  RETURN_IF_ERROR(FromBytes(proto.exported(), "Values", &message.exported));
  return message;
}

std::string Encode(const ValuesReply& message) {
  v1::ValuesReply proto;
  proto.set_other_cut(ToBytes(message.other_cut));
  proto.set_proxies(ToBytes(message.proxies));
  return proto.SerializeAsString();
}

template <>
Result<ValuesReply> DecodeMessage(const std::string& payload) {
  v1::ValuesReply proto;
  RETURN_IF_ERROR(Parse(payload, "ValuesReply", &proto));
  ValuesReply message;
  RETURN_IF_ERROR(FromBytes(proto.other_cut(), "ValuesReply", &message.other_cut));
  RETURN_IF_ERROR(FromBytes(proto.proxies(), "ValuesReply", &message.proxies));
  return message;
}

std::string EncodeSums(std::span<const int64_t> crown, std::span<const int64_t> proxies) {
  v1::Sums proto;
  proto.set_crown(ToBytes(crown));
  proto.set_proxies(ToBytes(proxies));
  return proto.SerializeAsString();
}

std::string Encode(const Sums& message) { return EncodeSums(message.crown, message.proxies); }

template <>
Result<Sums> DecodeMessage(const std::string& payload) {
  v1::Sums proto;
  RETURN_IF_ERROR(Parse(payload, "Sums", &proto));
  Sums message;
  RETURN_IF_ERROR(FromBytes(proto.crown(), "Sums", &message.crown));
  RETURN_IF_ERROR(FromBytes(proto.proxies(), "Sums", &message.proxies));
  return message;
}

std::string Encode(const SumsReply& message) {
  v1::SumsReply proto;
  proto.set_crown(ToBytes(message.crown));
  proto.set_exported(ToBytes(message.exported));
  return proto.SerializeAsString();
}

template <>
Result<SumsReply> DecodeMessage(const std::string& payload) {
  v1::SumsReply proto;
  RETURN_IF_ERROR(Parse(payload, "SumsReply", &proto));
  SumsReply message;
  RETURN_IF_ERROR(FromBytes(proto.crown(), "SumsReply", &message.crown));
  RETURN_IF_ERROR(FromBytes(proto.exported(), "SumsReply", &message.exported));
  return message;
}

std::string Encode(const GatherRequest& message) {
  v1::GatherRequest proto;
  ToProto(message.elements, proto.mutable_elements());
  proto.set_accuracy(message.accuracy);
  proto.set_corners(message.corners.data(), message.corners.size());
  return proto.SerializeAsString();
}

template <>
Result<GatherRequest> DecodeMessage(const std::string& payload) {
  v1::GatherRequest proto;
  RETURN_IF_ERROR(Parse(payload, "Gather", &proto));
  GatherRequest message;
  message.accuracy = proto.accuracy();
  if (!(message.accuracy > 0 && message.accuracy <= 1)) {
    return Error(StatusCode::kDataLoss, "Gather: accuracy {}", message.accuracy);
  }
  RETURN_IF_ERROR(FromProto(proto.elements(), "Gather", &message.elements));
  for (const NodeId& id : message.elements) {
    if (id.is_cluster()) return Error(StatusCode::kDataLoss, "Gather: a cluster has no corners");
  }
  message.corners.assign(proto.corners().begin(), proto.corners().end());
  if (!message.corners.empty() && message.corners.size() != message.elements.size()) {
    return Error(StatusCode::kDataLoss, "Gather: corners of {} elements for {}",
                 message.corners.size(), message.elements.size());
  }
  return message;
}

std::string Encode(const GatherPart& message) {
  v1::GatherPart proto;
  proto.set_exponent(message.exponent);
  proto.set_sums(ToBytes(message.sums));
  proto.set_rays(message.rays);
  proto.set_cpu_s(message.cpu_s);
  proto.set_wall_s(message.wall_s);
  PutCosts(message.costs, proto.mutable_costs());
  return proto.SerializeAsString();
}

template <>
Result<GatherPart> DecodeMessage(const std::string& payload) {
  v1::GatherPart proto;
  RETURN_IF_ERROR(Parse(payload, "GatherPart", &proto));
  GatherPart message;
  message.exponent = proto.exponent();
  if (message.exponent < kMinExponent || message.exponent > kMaxExponent) {
    return Error(StatusCode::kDataLoss, "GatherPart: exponent {}", message.exponent);
  }
  RETURN_IF_ERROR(FromBytes(proto.sums(), "GatherPart", &message.sums));
  message.rays = proto.rays();
  message.cpu_s = proto.cpu_s();
  message.wall_s = proto.wall_s();
  ASSIGN_OR_RETURN(message.costs, TakeCosts(proto.costs()));
  return message;
}

}  // namespace isolux
