// The progress bar of a file that takes long to read, on a terminal.
#include <gmock/gmock.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <thread>

#include "apps/program.h"

namespace foldproof {
namespace {

using namespace foldproof::testing;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr std::uint64_t kSize = 128'000'000;

/// A terminal that nobody looks at.
class Terminal {
 public:
  Terminal() : master_(::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK)) {
    EXPECT_EQ(::grantpt(master_), 0);
    EXPECT_EQ(::unlockpt(master_), 0);
    program_ = ::open(::ptsname(master_), O_RDWR | O_NOCTTY | O_CLOEXEC);
  }
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;
  ~Terminal() {
    ::close(program_);
    ::close(master_);
  }
  /// The program's side.
  int program() const { return program_; }
  std::string shown() const {
    std::string text(std::size_t{1} << 16, '\0');
    text.resize(static_cast<std::size_t>(std::max<ssize_t>(0, ::read(master_, text.data(), text.size()))));
    return text;
  }

 private:
  int master_ = -1, program_ = -1;
};

/// What a process has read so far.
std::uint64_t bytes_read(pid_t process) {
  std::ifstream file("/proc/" + std::to_string(process) + "/io");
  std::string name;
  std::uint64_t bytes = kSize;  // once it has ended
  file >> name >> bytes;
  return bytes;
}

/// Stops a process for longer than it takes until the bar appears, while it reads the file. False: it was too
/// fast.
bool stop_while_it_reads(pid_t process) {
  while (bytes_read(process) < kSize / 16) std::this_thread::sleep_for(std::chrono::microseconds(100));
  ::kill(process, SIGSTOP);
  const bool reads = bytes_read(process) < kSize / 4 * 3;
  if (reads) std::this_thread::sleep_for(std::chrono::milliseconds(600));
  ::kill(process, SIGCONT);
  return reads;
}

/// What `foldproof check` prints on a terminal for a file of zeros that takes long to read.
std::string shown_for_slow_file(std::vector<std::string> arguments) {
  const TemporaryDirectory directory;
  write_file(directory / "slow.gltf", "");
  std::filesystem::resize_file(directory / "slow.gltf", kSize);
  arguments.insert(arguments.begin(), {"check", "slow.gltf"});
  for (int attempt = 0; attempt < 20; ++attempt) {
    const Terminal terminal;
    bool slow = false;
    const auto stop = [&](pid_t process) { slow = stop_while_it_reads(process); };
    run_program(arguments,
                {.directory = directory.path(), .error = terminal.program(), .while_it_runs = stop});
    if (slow) return terminal.shown();
  }
  return "it was never slow";
}

TEST(ReadingProgress, IsShownOnATerminal) {
  const std::string text = shown_for_slow_file({});
  EXPECT_THAT(text, HasSubstr("] reading slow.gltf: "));
  EXPECT_THAT(text, HasSubstr(" of 128 MB, 0:0"));
  EXPECT_THAT(text, HasSubstr("[##############################] reading slow.gltf: now building its mesh"));
  const std::string last = text.substr(text.rfind("\r\x1b[K") + 4);  // the bar is erased before the error
  EXPECT_THAT(last, HasSubstr("is not valid JSON here"));
}

/// What `foldproof` prints on a terminal if it is stopped for a second, some milliseconds after it has begun.
std::string shown_when_slow(const std::string& directory, std::vector<std::string> arguments, int after) {
  const Terminal terminal;
  const auto stop = [after](pid_t process) {
    std::this_thread::sleep_for(std::chrono::milliseconds(after));
    ::kill(process, SIGSTOP);
    std::this_thread::sleep_for(std::chrono::milliseconds(1200));
    ::kill(process, SIGCONT);
  };
  run_program(std::move(arguments),
              {.directory = directory, .error = terminal.program(), .while_it_runs = stop});
  return terminal.shown();
}

/// A sheet of so many triangles that all takes a while; what it is stopped in differs from attempt to
/// attempt.
TEST(StageProgress, SaysWhatIsDoneThoughItGivesNoSign) {
  const TemporaryDirectory directory;
  std::string mesh = "OFF\n250000 498002 0\n";
  for (int i = 0; i < 500; ++i) {
    for (int k = 0; k < 500; ++k) mesh += std::to_string(i) + " " + std::to_string(k) + " 0\n";
  }
  for (int i = 0; i + 1 < 500; ++i) {
    for (int k = 0; k + 1 < 500; ++k) {
      const int a = 500 * i + k;
      mesh += "3 " + std::to_string(a) + " " + std::to_string(a + 1) + " " + std::to_string(a + 501) + "\n";
      mesh += "3 " + std::to_string(a) + " " + std::to_string(a + 501) + " " + std::to_string(a + 500) + "\n";
    }
  }
  write_file(directory / "sheet.off", mesh);
  std::string shown;
  for (int attempt = 0; attempt < 20 && shown.find("the hierarchy, 0:0") == std::string::npos &&
                        shown.find("in the first frame, 0:0") == std::string::npos;
       ++attempt)
    shown = shown_when_slow(directory.path(), {"check", "sheet.off"}, 100 + 50 * attempt);
  EXPECT_THAT(shown, ::testing::AnyOf(HasSubstr("building the hierarchy, 0:0"),
                                      HasSubstr("finding what crosses in the first frame, 0:0")));
  EXPECT_EQ(shown_when_slow(directory.path(), {"check", "sheet.off", "-q"}, 400), "");
}

TEST(ReadingProgress, IsLinesForOtherPrograms) {
  const TemporaryDirectory directory;
  write_file(directory / "slow.gltf", "");
  std::filesystem::resize_file(directory / "slow.gltf", kSize);
  write_file(directory / "traced",
             std::string("#!/bin/sh\nFOLDPROOF_PROGRESS=lines exec ") + FOLDPROOF_PROGRAM + " \"$@\"\n");
  std::filesystem::permissions(directory / "traced", std::filesystem::perms::owner_all);
  std::string shown;
  for (int attempt = 0; attempt < 20 && shown.find('%') == std::string::npos; ++attempt)
    shown = run_program({"check", "slow.gltf"}, {.directory = directory.path(),
                                                 .program = directory / "traced",
                                                 .while_it_runs = stop_while_it_reads})
                .err;
  EXPECT_THAT(shown, ContainsRegex("^[0-9]+% reading slow.gltf: [0-9]+ of 128 MB, [0-9]:[0-9][0-9] left\n"));
  EXPECT_THAT(shown, Not(HasSubstr("\x1b")));
}

TEST(ReadingProgress, IsNotShownIfQuiet) {
  EXPECT_THAT(shown_for_slow_file({"-q"}),
              ::testing::AllOf(HasSubstr("is not valid JSON"), Not(HasSubstr("reading"))));
}

}  // namespace
}  // namespace foldproof
