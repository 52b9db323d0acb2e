// Jobs and rounds to their protocol messages and back: the only file that knows both sides (for
// SolveOptions convert_options.h).
#pragma once

#include "common/rpc/frame.h"
#include "common/rpc/job_info.h"
#include "common/util/status.h"
#include "isolux/v1/job_service.pb.h"
#include "isolux/v1/worker_service.pb.h"

namespace isolux {

v1::RoundSummary ToProto(const RoundSummary& round);
v1::JobProgress ToProto(const Activity& activity);
// Without rounds and repairs where not `whole`.
v1::Job ToProto(const JobInfo& job, bool whole);
void PutRepairs(const RepairReport& report,
                google::protobuf::RepeatedPtrField<v1::Repair>* repairs);
v1::Frame ToProto(FrameData frame);

// Each fails where the message holds what the struct cannot: an unknown state, a list of a wrong
// length, more entries than the limits below.
Result<RoundSummary> FromProto(const v1::RoundSummary& message);
Activity FromProto(const v1::JobProgress& message);
Result<JobInfo> FromProto(const v1::Job& message);
Result<RepairReport> TakeRepairs(const google::protobuf::RepeatedPtrField<v1::Repair>& repairs);
FrameData FromProto(v1::Frame message);

// Text for a protocol message, which holds nothing but UTF-8: other bytes become '?', and what is
// longer than kMaxTextBytes is cut.
std::string Utf8(const std::string& text);

inline constexpr int kMaxRepairs = 1000;
inline constexpr int kMaxTextBytes = 4096;  // of a name, a message, an example

}  // namespace isolux
