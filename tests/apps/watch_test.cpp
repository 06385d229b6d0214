// check --watch: again, each time that a file changes.
#include <gmock/gmock.h>

#include <csignal>
#include <thread>

#include "apps/program.h"

namespace foldproof {
namespace {

using namespace foldproof::testing;
using ::testing::HasSubstr;
using ::testing::Not;

/// Waits until a file holds a text, at most 20 seconds.
void wait_for(const std::string& path, const std::string& text) {
  for (int k = 0; k < 1000; ++k) {
    if (std::filesystem::exists(path) && read_file(path).find(text) != std::string::npos) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  FAIL() << path << " never held " << text;
}

TEST(Watch, ChecksAgainWhenAFileHasChangedAndIsWholeAgain) {
  const TemporaryDirectory directory;
  ASSERT_TRUE(write_npz(directory / "a.npz", *sinking_triangle({3, 2, 1})));
  ASSERT_TRUE(write_npz(directory / "sink.npz", *sinking_triangle(kSinking)));
  const std::string sinking = read_file(directory / "sink.npz");
  const auto half = static_cast<std::ptrdiff_t>(sinking.size() / 2);
  const Outcome watched = run_program(
      {"check", "a.npz", "--watch", "--json", "a.json"},
      {.directory = directory.path(), .while_it_runs = [&](pid_t child) {
         wait_for(directory / "a.json", "\"clean\":true");
         std::ofstream slow(directory / "a.npz", std::ios::binary);
         slow.write(sinking.data(), half).flush();
         std::this_thread::sleep_for(std::chrono::milliseconds(700));  // longer than it takes to settle
         slow.write(sinking.data() + half, static_cast<std::ptrdiff_t>(sinking.size()) - half);
         slow.close();
         wait_for(directory / "a.json", "\"clean\":false");
         ::kill(child, SIGINT);
       }});
  EXPECT_EQ(watched.code, 130) << watched.err;
  EXPECT_THAT(watched.out, HasSubstr("No collisions: "));
  EXPECT_THAT(watched.out, HasSubstr("Collisions in 2 of 4 steps"));
  EXPECT_THAT(watched.err, HasSubstr("a.npz has changed."));
  EXPECT_THAT(watched.err, Not(HasSubstr("foldproof: a.npz")));
}

TEST(Watch, WaitsForAFileThatCannotBeReadToBeMended) {
  const TemporaryDirectory directory;
  write_file(directory / "a.obj", "v 0 0 zero\n");
  const auto motion = sinking_triangle(kSinking);
  std::vector<double> x(3 * std::size_t{motion->topology().vertex_count()});
  ASSERT_TRUE(motion->read_frame(0, x));
  const std::string said = directory / "said.txt";
  const int error = ::open(said.c_str(), O_WRONLY | O_CREAT, 0600);
  ASSERT_GE(error, 0);
  const Outcome watched =
      run_program({"check", "a.obj", "--watch", "--json", "a.json"},
                  {.directory = directory.path(), .error = error, .while_it_runs = [&](pid_t child) {
                     wait_for(said, "foldproof: a.obj:1");
                     EXPECT_TRUE(write_obj(directory / "a.obj", motion->topology(), x));
                     wait_for(directory / "a.json", "\"clean\":true");
                     ::kill(child, SIGTERM);
                   }});
  ::close(error);
  EXPECT_EQ(watched.code, 130);
}

TEST(Watch, NamesAFileThatWasRemoved) {
  const TemporaryDirectory directory;
  const auto motion = sinking_triangle({3, 2, 1});
  std::vector<double> x(3 * std::size_t{motion->topology().vertex_count()});
  for (Index k = 0; k < 3; ++k) {
    ASSERT_TRUE(motion->read_frame(k, x));
    ASSERT_TRUE(write_obj(directory / ("f" + std::to_string(k + 1) + ".obj"), motion->topology(), x));
  }
  const Outcome watched = run_program({"check", "f%d.obj", "--watch", "--json", "a.json"},
                                      {.directory = directory.path(), .while_it_runs = [&](pid_t child) {
                                         wait_for(directory / "a.json", "\"clean\":true");
                                         std::this_thread::sleep_for(std::chrono::milliseconds(1500));
                                         std::filesystem::remove(directory / "f2.obj");
                                         wait_for(directory / "a.json", "jump from 1 to 3");
                                         ::kill(child, SIGINT);
                                       }});
  EXPECT_THAT(watched.err, HasSubstr("f2.obj has changed."));
  EXPECT_THAT(watched.err, Not(HasSubstr("f3.obj has changed.")));
}

TEST(Watch, MistakesOnTheCommandLineEndIt) {
  const TemporaryDirectory directory;
  expect_one_line_error(check_in(directory, {"a.obj", "--watch", "--thickness", "-1"}), "--thickness");
}

}  // namespace
}  // namespace foldproof
