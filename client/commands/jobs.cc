// isolux jobs [--limit N] [--json] [--server HOST:PORT]
//
// The coordinator's jobs, newest first.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "client/commands/commands.h"
#include "client/commands/job_flags.h"
#include "client/job_text.h"

namespace isolux {
namespace {

struct JobsFlags {
  std::string server;
  uint32_t limit = 100;
  bool json = false;
};

int RunJobs(const JobsFlags& options) {
  auto client = Client::Make(options.server);
  if (!client) return Fail("jobs", client.error());
  const auto jobs = (*client)->List(options.limit);
  if (!jobs) return Fail("jobs", jobs.error());
  if (options.json) {
    nlohmann::json list = nlohmann::json::array();
    for (const JobInfo& job : *jobs) {
      list.push_back({{"job", job.id},
                      {"name", job.name},
                      {"state", ToText(job.state)},
                      {"accuracy", job.options.accuracy},
                      {"polygons", job.polygons},
                      {"seconds", job.summary.seconds},
                      {"message", job.error.ok() ? job.message : job.error.message()}});
    }
    std::printf("%s\n", nlohmann::json{{"jobs", list}}.dump().c_str());
    return 0;
  }
  std::printf("%6s  %-9s  %8s  %-19s  %s\n", "job", "state", "accuracy", "submitted", "name");
  for (const JobInfo& job : *jobs) {
    std::printf("%6lu  %-9s  %7g%%  %-19s  %s\n", job.id, ToText(job.state),
                100 * job.options.accuracy, TimeText(job.submitted_ms).c_str(), job.name.c_str());
  }
  return 0;
}

}  // namespace

void AddJobsCommand(CLI::App& app, Run& run) {
  auto options = std::make_shared<JobsFlags>();
  CLI::App* command = app.add_subcommand("jobs", "list the coordinator's jobs");
  command->add_option("--limit", options->limit, "at most so many, newest first")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  command->add_flag("--json", options->json, "print one JSON object");
  AddServerFlag(*command, &options->server);
  command->callback([options, &run] { run = [options] { return RunJobs(*options); }; });
}

}  // namespace isolux
