/// Runs build/foldproof as a person does and catches what it says.
#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <functional>
#include <nlohmann/json.hpp>
#include <ostream>
#include <string>
#include <thread>
#include <vector>

#include "report/sinking_triangle.h"

namespace foldproof::testing {

struct Outcome {
  int code = -1;   ///< Exit code; -1 when it did not exit.
  int signal = 0;  ///< What killed it, if anything did.
  std::string out, err;
};

struct RunOptions {
  std::string directory = ".";                    ///< Where it runs.
  std::string program = FOLDPROOF_PROGRAM;        ///< Or one that starts it.
  int output = -1;                                ///< Takes its standard output instead of `Outcome::out`.
  int error = -1;                                 ///< Takes its standard error instead of `Outcome::err`.
  std::function<void(pid_t)> while_it_runs = {};  ///< Called once, right after the start.
};

inline Outcome run_program(std::vector<std::string> arguments, const RunOptions& options = {}) {
  const TemporaryDirectory capture;
  const std::string out_path = capture / "out", err_path = capture / "err";
  arguments.insert(arguments.begin(), options.program);
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);

  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addchdir_np(&actions, options.directory.c_str());
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  if (options.error >= 0) {
    posix_spawn_file_actions_adddup2(&actions, options.error, STDERR_FILENO);
  } else {
    posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, err_path.c_str(), O_WRONLY | O_CREAT, 0600);
  }
  if (options.output >= 0) {
    posix_spawn_file_actions_adddup2(&actions, options.output, STDOUT_FILENO);
  } else {
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, out_path.c_str(), O_WRONLY | O_CREAT, 0600);
  }
  pid_t child = 0;
  const int failed = ::posix_spawn(&child, options.program.c_str(), &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  EXPECT_EQ(failed, 0) << "could not start " << options.program;
  if (failed != 0) return {};
  if (options.while_it_runs) options.while_it_runs(child);
  int status = 0;
  EXPECT_EQ(::waitpid(child, &status, 0), child);

  Outcome outcome;
  if (WIFEXITED(status)) outcome.code = WEXITSTATUS(status);
  if (WIFSIGNALED(status)) outcome.signal = WTERMSIG(status);
  if (options.output < 0) outcome.out = read_file(out_path);
  if (options.error < 0) outcome.err = read_file(err_path);
  return outcome;
}

/// A directory in which the program runs.
struct Workplace : TemporaryDirectory {
  Outcome run(std::vector<std::string> arguments) const {
    return run_program(std::move(arguments), {.directory = path()});
  }
  nlohmann::json report(const std::string& name) const {
    return nlohmann::json::parse(read_file(*this / name));
  }
};

/// A command line, and what the error says of it.
struct Mistake {
  std::vector<std::string> arguments;
  const char* said;
};
inline void PrintTo(const Mistake& mistake, std::ostream* out) {
  for (const auto& argument : mistake.arguments) *out << argument << ' ';
}

/// Sends a signal to a program that runs, once it handles it.
inline void interrupt(pid_t child, int signal = SIGINT) {
  const std::string status = "/proc/" + std::to_string(child) + "/status";
  const auto handles_it = [&] {
    const std::string text = read_file(status);
    const std::size_t at = text.find("SigCgt:");
    if (at == text.npos) return true;
    return (std::stoull(text.substr(at + 7), nullptr, 16) >> (signal - 1) & 1) != 0;
  };
  for (int k = 0; k < 60'000 && !handles_it(); ++k) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  ::kill(child, signal);
}

/// Expects an error: exit code 2, nothing on standard output, and one line that contains `said`.
inline void expect_one_line_error(const Outcome& outcome, const std::string& said) {
  EXPECT_EQ(outcome.code, 2) << said << '\n' << outcome.out << outcome.err;
  EXPECT_EQ(outcome.signal, 0) << said;
  EXPECT_EQ(outcome.out, "") << said;
  EXPECT_TRUE(outcome.err.starts_with("foldproof: ")) << outcome.err;
  EXPECT_NE(outcome.err.find(said), std::string::npos) << "'" << said << "' is not in: " << outcome.err;
  EXPECT_EQ(outcome.err.find('\n') + 1, outcome.err.size()) << outcome.err;
}

/// Runs `foldproof check` in `directory`.
inline Outcome check_in(const TemporaryDirectory& directory, std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "check");
  return run_program(std::move(arguments), {.directory = directory.path()});
}

inline void write_file(const std::string& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

/// Writes a directory of OBJ frames.
inline void write_frames(const std::string& directory, Motion& motion) {
  std::filesystem::create_directories(directory);
  std::vector<double> x(std::size_t{motion.topology().vertex_count()} * 3);
  for (Index frame = 0; frame < motion.frame_count(); ++frame) {
    ASSERT_TRUE(motion.read_frame(frame, x));
    std::ofstream file(directory + "/frame" + std::to_string(frame) + ".obj");
    for (std::size_t k = 0; k < x.size(); k += 3)
      file << "v " << x[k] << ' ' << x[k + 1] << ' ' << x[k + 2] << '\n';
    for (const Triangle& t : motion.topology().triangles()) {
      file << "f " << t[0] + 1 << ' ' << t[1] + 1 << ' ' << t[2] + 1 << '\n';
    }
  }
}

}  // namespace foldproof::testing
