// Child processes that do not outlive their parent.
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

#include "common/util/status.h"

namespace isolux {

class ChildProcess {
 public:
  struct Options {
    // Sent to the child when the thread that starts it ends, however it ends. 0: none.
    int death_signal = 9;
    // Where its standard output and error go; empty: where ours go, standard output to our
    // standard error.
    std::string output_file, error_file;
    // Its standard output is read with ReadLine instead.
    bool pipe_output = false;
  };

  // arguments[0] is the program, looked up in PATH where it has no slash. The child has a process
  // group of its own: a Ctrl-C on the terminal reaches the parent alone.
  static Result<ChildProcess> Start(const std::vector<std::string>& arguments,
                                    const Options& options);
  // Kills it, with what it has started, if it still runs.
  ~ChildProcess();
  ChildProcess(ChildProcess&& other) noexcept;
  ChildProcess& operator=(ChildProcess&& other) noexcept;

  pid_t id() const { return id_; }
  bool Running();
  void Signal(int signal);
  // Waits until it has ended, at most so long; whether it has.
  bool Wait(double timeout_s);
  // Its exit code, or 128 + the signal that ended it; -1 while it runs.
  int exit_code() const { return exit_code_; }

  // The next line of its output, without the line end. kUnavailable where there is none any more.
  Result<std::string> ReadLine(double timeout_s);

 private:
  ChildProcess() = default;

  pid_t id_ = -1;  // -1: none, or ended
  int exit_code_ = -1;
  int output_ = -1;
};

// PROGRAM beside this program's own file; else PROGRAM itself, to be looked up in PATH.
std::string ProgramBeside(const std::string& program);

}  // namespace isolux
