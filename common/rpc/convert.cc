#include "common/rpc/convert.h"

#include <algorithm>
#include <utility>

#include "common/rpc/convert_options.h"

namespace isolux {
namespace {

// Bytes of the UTF-8 character that begins at text[i]; 0 where none does.
size_t CharacterLength(const std::string& text, size_t i) {
  const auto byte = [&](size_t k) { return static_cast<unsigned char>(text[i + k]); };
  size_t length = 0;
  unsigned char low = 0x80, high = 0xbf;  // of the second byte
  if (byte(0) < 0x80) return 1;
  if (byte(0) >= 0xc2 && byte(0) < 0xe0) length = 2;
  if (byte(0) >= 0xe0 && byte(0) < 0xf0) length = 3;
  if (byte(0) >= 0xf0 && byte(0) < 0xf5) length = 4;
  if (byte(0) == 0xe0) low = 0xa0;   // longer than needed
  if (byte(0) == 0xed) high = 0x9f;  // surrogates
  if (byte(0) == 0xf0) low = 0x90;
  if (byte(0) == 0xf4) high = 0x8f;  // beyond the last
  if (length == 0 || i + length > text.size() || byte(1) < low || byte(1) > high) return 0;
  for (size_t k = 2; k < length; ++k) {
    if ((byte(k) & 0xc0) != 0x80) return 0;
  }
  return length;
}

void Put(const std::array<double, 3>& values, google::protobuf::RepeatedField<double>* field) {
  field->Assign(values.begin(), values.end());
}

Status Take(const google::protobuf::RepeatedField<double>& field, std::array<double, 3>* values) {
  if (field.size() != 3) {
    return MakeStatus(StatusCode::kDataLoss, "a power of {} channels; there are 3", field.size());
  }
  std::copy(field.begin(), field.end(), values->begin());
  return {};
}

void PutSummary(const SolveSummary& summary, v1::Job* message) {
  message->set_end_reason(static_cast<v1::EndReason>(static_cast<int>(summary.end_reason) + 1));
  message->set_seconds(summary.seconds);
  message->set_gather_s(summary.gather_s);
  message->set_workers(summary.workers);
  message->set_rays(summary.rays);
}

Status TakeSummary(const v1::Job& message, SolveSummary* summary) {
  if (message.end_reason() < v1::END_REASON_ACCURACY ||
      message.end_reason() > v1::END_REASON_FINISHED) {
    return MakeStatus(StatusCode::kDataLoss, "job {}: unknown reason {} to end", message.id(),
                      static_cast<int>(message.end_reason()));
  }
  summary->end_reason = static_cast<EndReason>(static_cast<int>(message.end_reason()) - 1);
  summary->seconds = message.seconds();
  summary->gather_s = message.gather_s();
  summary->workers = message.workers();
  summary->rays = message.rays();
  for (const v1::RoundSummary& round : message.rounds()) {
    ASSIGN_OR_RETURN(auto taken, FromProto(round));
    summary->rounds.push_back(std::move(taken));
  }
  return {};
}

}  // namespace

std::string Utf8(const std::string& text) {
  std::string clean;
  for (size_t i = 0; i < text.size() && clean.size() < kMaxTextBytes;) {
    const size_t length = CharacterLength(text, i);
    if (length == 0) {
      clean += '?';
    } else if (clean.size() + length <= kMaxTextBytes) {
      clean.append(text, i, length);
    } else {
      break;
    }
    i += std::max<size_t>(length, 1);
  }
  return clean;
}

const char* ToText(JobState state) {
  switch (state) {
    case JobState::kQueued:
      return "queued";
    case JobState::kRunning:
      return "running";
    case JobState::kDone:
      return "done";
    case JobState::kFailed:
      return "failed";
    case JobState::kCancelled:
      return "cancelled";
  }
  return "unknown";
}

v1::RoundSummary ToProto(const RoundSummary& round) {
  v1::RoundSummary message;
  message.set_round(round.round);
  message.set_epsilon(round.epsilon);
  message.set_error_estimate(round.error_estimate);
  message.set_error_spread(round.error_spread);
  message.set_error_visibility(round.error_visibility);
  message.set_error_coupling(round.error_coupling);
  message.set_error_solver(round.error_solver);
  message.set_elements(round.elements);
  message.set_links(round.links);
  message.set_evaluations(round.evaluations);
  message.set_proved_visible(round.proved_visible);
  message.set_proved_hidden(round.proved_hidden);
  message.set_rays(round.rays);
  message.set_iterations(round.iterations);
  message.set_residual(round.residual);
  message.set_energy_imbalance(round.energy_imbalance);
  Put(round.emitted_w, message.mutable_emitted_w());
  Put(round.absorbed_w, message.mutable_absorbed_w());
  Put(round.escaped_w, message.mutable_escaped_w());
  if (round.medium_w != decltype(round.medium_w){}) {
    Put(round.medium_w, message.mutable_medium_w());
  }
  if (round.glass_w != decltype(round.glass_w){}) Put(round.glass_w, message.mutable_glass_w());
  message.set_seconds(round.seconds);
  message.set_refine_s(round.refine_s);
  message.set_exchange_s(round.exchange_s);
  message.set_solve_s(round.solve_s);
  message.set_snapshot_s(round.snapshot_s);
  message.set_balance_s(round.balance_s);
  message.mutable_worker_cpu_s()->Assign(round.worker_cpu_s.begin(), round.worker_cpu_s.end());
  message.set_load_max_over_mean(round.load_max_over_mean);
  message.set_bytes_in(round.bytes_in);
  message.set_bytes_out(round.bytes_out);
  message.set_migrated_nodes(round.migrated_nodes);
  message.set_migrated_links(round.migrated_links);
  message.set_memory_bytes(round.memory_bytes);
  message.set_leaks(round.leaks);
  message.set_leak_area(round.leak_area);
  message.set_error_closure(round.error_closure);
  message.set_error_gather(round.error_gather);
  message.set_error_interpolation(round.error_interpolation);
  message.set_error_unseen(round.error_unseen);
  message.set_unseen_polygon(round.unseen_polygon);
  message.set_error_rms(round.error_rms);
  message.set_error_p95(round.error_p95);
  message.set_error_worst(round.error_worst);
  message.set_worst_polygon(round.worst_polygon);
  message.set_worst_surface(round.worst_surface);
  message.set_worst_path(round.worst_path);
  message.set_output_elements(round.output_elements);
  message.set_output_points(round.output_points);
  message.set_output_rays(round.output_rays);
  message.set_output_s(round.output_s);
  message.set_sample_s(round.sample_s);
  message.set_links_per_split(round.links_per_split);
  PutMeasured(round.measured, message.mutable_measured());
  PutCosts(round.costs, message.mutable_costs());
  return message;
}

Result<RoundSummary> FromProto(const v1::RoundSummary& message) {
  RoundSummary round;
  round.round = message.round();
  round.epsilon = message.epsilon();
  round.error_estimate = message.error_estimate();
  round.error_spread = message.error_spread();
  round.error_visibility = message.error_visibility();
  round.error_coupling = message.error_coupling();
  round.error_solver = message.error_solver();
  round.elements = message.elements();
  round.links = message.links();
  round.evaluations = message.evaluations();
  round.proved_visible = message.proved_visible();
  round.proved_hidden = message.proved_hidden();
  round.rays = message.rays();
  round.iterations = message.iterations();
  round.residual = message.residual();
  round.energy_imbalance = message.energy_imbalance();
  RETURN_IF_ERROR(Take(message.emitted_w(), &round.emitted_w));
  RETURN_IF_ERROR(Take(message.absorbed_w(), &round.absorbed_w));
  RETURN_IF_ERROR(Take(message.escaped_w(), &round.escaped_w));
  if (!message.medium_w().empty()) {
    RETURN_IF_ERROR(Take(message.medium_w(), &round.medium_w));
  }
  if (!message.glass_w().empty()) RETURN_IF_ERROR(Take(message.glass_w(), &round.glass_w));
  round.seconds = message.seconds();
  round.refine_s = message.refine_s();
  round.exchange_s = message.exchange_s();
  round.solve_s = message.solve_s();
  round.snapshot_s = message.snapshot_s();
  round.balance_s = message.balance_s();
  round.worker_cpu_s.assign(message.worker_cpu_s().begin(), message.worker_cpu_s().end());
  round.load_max_over_mean = message.load_max_over_mean();
  round.bytes_in = message.bytes_in();
  round.bytes_out = message.bytes_out();
  round.migrated_nodes = message.migrated_nodes();
  round.migrated_links = message.migrated_links();
  round.memory_bytes = message.memory_bytes();
  round.leaks = message.leaks();
  round.leak_area = message.leak_area();
  round.error_closure = message.error_closure();
  round.error_gather = message.error_gather();
  round.error_interpolation = message.error_interpolation();
  round.error_unseen = message.error_unseen();
  round.unseen_polygon = message.unseen_polygon();
  round.error_rms = message.error_rms();
  round.error_p95 = message.error_p95();
  round.error_worst = message.error_worst();
  round.worst_polygon = message.worst_polygon();
  round.worst_surface = message.worst_surface();
  round.worst_path = message.worst_path();
  round.output_elements = message.output_elements();
  round.output_points = message.output_points();
  round.output_rays = message.output_rays();
  round.output_s = message.output_s();
  round.sample_s = message.sample_s();
  round.links_per_split = message.links_per_split();
  ASSIGN_OR_RETURN(round.measured, TakeMeasured(message.measured()));
  ASSIGN_OR_RETURN(round.costs, TakeCosts(message.costs()));
  return round;
}

v1::JobProgress ToProto(const Activity& activity) {
  v1::JobProgress message;
  message.set_phase(activity.phase);
  message.set_round(activity.round);
  message.set_workers(activity.workers);
  message.set_seconds(activity.seconds);
  return message;
}

Activity FromProto(const v1::JobProgress& message) {
  return {message.phase(), message.round(), message.workers(), message.seconds()};
}

void PutRepairs(const RepairReport& report,
                google::protobuf::RepeatedPtrField<v1::Repair>* repairs) {
  for (const RepairReport::Entry& entry : report.entries) {
    if (repairs->size() == kMaxRepairs) break;
    v1::Repair* repair = repairs->Add();
    repair->set_kind(Utf8(entry.kind));
    repair->set_count(entry.count);
    repair->set_example(Utf8(entry.example));
  }
}

Result<RepairReport> TakeRepairs(const google::protobuf::RepeatedPtrField<v1::Repair>& repairs) {
  if (repairs.size() > kMaxRepairs) {
    return Error(StatusCode::kInvalidArgument, "{} kinds of repairs; {} is the limit",
                 repairs.size(), kMaxRepairs);
  }
  RepairReport report;
  for (const v1::Repair& repair : repairs) {
    if (repair.kind().size() > kMaxTextBytes || repair.example().size() > kMaxTextBytes) {
      return Error(StatusCode::kInvalidArgument, "the text of a repair is longer than {} bytes",
                   kMaxTextBytes);
    }
    report.entries.push_back({repair.kind(), repair.count(), repair.example()});
  }
  return report;
}

v1::Job ToProto(const JobInfo& job, bool whole) {
  v1::Job message;
  message.set_id(job.id);
  message.set_name(Utf8(job.name));
  message.set_request_id(Utf8(job.request_id));
  message.set_state(static_cast<v1::JobState>(job.state));
  message.set_code(static_cast<uint32_t>(job.error.code()));
  message.set_message(Utf8(job.error.ok() ? job.message : job.error.message()));
  *message.mutable_options() = ToProto(job.options);
  message.set_digest(job.digest);
  message.set_scene_bytes(job.scene_bytes);
  message.set_polygons(job.polygons);
  message.set_submitted_ms(job.submitted_ms);
  message.set_started_ms(job.started_ms);
  message.set_finished_ms(job.finished_ms);
  PutSummary(job.summary, &message);
  message.set_result_bytes(job.result_bytes);
  message.set_result_digest(job.result_digest);
  *message.mutable_progress() = ToProto(job.activity);
  message.set_finishing(job.finishing);
  if (whole) {
    PutRepairs(job.repairs, message.mutable_repairs());
    for (const RoundSummary& round : job.summary.rounds) *message.add_rounds() = ToProto(round);
  }
  return message;
}

Result<JobInfo> FromProto(const v1::Job& message) {
  JobInfo job;
  job.id = message.id();
  job.name = message.name();
  job.request_id = message.request_id();
  if (message.state() < v1::JOB_STATE_QUEUED || message.state() > v1::JOB_STATE_CANCELLED) {
    return Error(StatusCode::kDataLoss, "job {}: unknown state {}", job.id,
                 static_cast<int>(message.state()));
  }
  job.state = static_cast<JobState>(message.state());
  job.message = message.message();
  if (message.code() != 0) {
    job.error = Status(static_cast<StatusCode>(message.code()), message.message());
  }
  ASSIGN_OR_RETURN(job.options, FromProto(message.options()));
  job.digest = message.digest();
  job.scene_bytes = message.scene_bytes();
  job.polygons = message.polygons();
  ASSIGN_OR_RETURN(job.repairs, TakeRepairs(message.repairs()));
  job.submitted_ms = message.submitted_ms();
  job.started_ms = message.started_ms();
  job.finished_ms = message.finished_ms();
  RETURN_IF_ERROR(TakeSummary(message, &job.summary));
  job.result_bytes = message.result_bytes();
  job.result_digest = message.result_digest();
  job.activity = FromProto(message.progress());
  job.finishing = message.finishing();
  return job;
}

v1::Frame ToProto(FrameData frame) {
  v1::Frame message;
  message.set_epoch(frame.epoch);
  message.set_sequence(frame.sequence);
  message.set_kind(frame.kind);
  message.set_last(frame.last);
  message.set_data(std::move(frame.data));
  message.set_message_bytes(frame.message_bytes);
  return message;
}

FrameData FromProto(v1::Frame message) {
  FrameData frame;
  frame.epoch = message.epoch();
  frame.sequence = message.sequence();
  frame.kind = message.kind();
  frame.last = message.last();
  frame.data = std::move(*message.mutable_data());
  frame.message_bytes = message.message_bytes();
  return frame;
}

}  // namespace isolux
