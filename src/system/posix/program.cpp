#include "system/program.h"

#include <fcntl.h>
#include <pthread.h>
#include <spawn.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <string_view>

extern "C" char** environ;  // macOS declares it nowhere

namespace foldproof::system {
namespace {

#ifdef __APPLE__
constexpr const char* kOpener = "open";
bool has_display() { return true; }
#else
constexpr const char* kOpener = "xdg-open";
bool has_display() { return std::getenv("DISPLAY") != nullptr || std::getenv("WAYLAND_DISPLAY") != nullptr; }
#endif

/// Files that are opened later must not take the place of a standard stream that was closed at the start.
void open_standard_streams() {
  for (int descriptor = STDIN_FILENO; descriptor <= STDERR_FILENO; ++descriptor) {
    if (::fcntl(descriptor, F_GETFD) == -1 && ::open("/dev/null", O_RDWR) < 0) return;
  }
}

/// Signals are for the thread that watches for them.
class SignalsBlocked {
 public:
  SignalsBlocked() {
    ::sigset_t all;
    ::sigfillset(&all);
    ::pthread_sigmask(SIG_SETMASK, &all, &before_);
  }
  SignalsBlocked(const SignalsBlocked&) = delete;
  SignalsBlocked& operator=(const SignalsBlocked&) = delete;
  ~SignalsBlocked() { ::pthread_sigmask(SIG_SETMASK, &before_, nullptr); }

 private:
  ::sigset_t before_;
};

}  // namespace

std::span<char* const> start_program(int argc, char** argv) {
  open_standard_streams();
  // A closed pipe, as in `foldproof check ... | head`, must not end the check.
  std::signal(SIGPIPE, SIG_IGN);
  // Exceeding a file size limit must not end it either, which would leave an incomplete file: writing fails.
  std::signal(SIGXFSZ, SIG_IGN);
  return {argv, static_cast<std::size_t>(argc)};
}

void on_interrupt(void (*handler)(int)) {
  std::signal(SIGINT, handler);
  std::signal(SIGTERM, handler);
  // A closed terminal, unless nohup has disabled the signal.
  if (std::signal(SIGHUP, handler) == SIG_IGN) std::signal(SIGHUP, SIG_IGN);
}

std::thread thread_without_signals(std::function<void()> work) {
  const SignalsBlocked blocked;  // inherited by the thread
  return std::thread(std::move(work));
}

bool is_terminal(std::FILE* stream) { return ::isatty(::fileno(stream)) == 1; }

bool has_colors(std::FILE* stream) {
  const char* terminal = std::getenv("TERM");
  const std::string_view name(terminal != nullptr ? terminal : "");
  return !name.empty() && name != "dumb" && is_terminal(stream);
}

bool is_closed_pipe(int number) { return number == EPIPE; }

void open_browser(const std::string& address) {
  if (!has_display()) return;
  posix_spawn_file_actions_t quiet;
  posix_spawn_file_actions_init(&quiet);
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    posix_spawn_file_actions_addopen(&quiet, stream, "/dev/null", O_RDWR, 0);
  std::string program = kOpener, argument = address;
  char* const argv[] = {program.data(), argument.data(), nullptr};
  pid_t child = 0;
  ::posix_spawnp(&child, program.c_str(), &quiet, nullptr, argv, environ);
  posix_spawn_file_actions_destroy(&quiet);
}

}  // namespace foldproof::system
