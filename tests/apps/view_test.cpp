// view and report on the command line.
#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <sys/socket.h>

#include <csignal>
#include <regex>

#include "apps/program.h"
#include "model/cylinder.h"

namespace foldproof {
namespace {

using namespace foldproof::testing;
using ::testing::HasSubstr;
using ::testing::StartsWith;

struct ViewScene : TemporaryDirectory {
  ViewScene() {
    EXPECT_TRUE(write_npz(path() + "/bend.npz", *bending_tube(kTube, {0, 1, 4.5, 6.5})));
    EXPECT_TRUE(write_npz(path() + "/free.npz", *bending_tube(kSmallTube, {0, 0.1, 0.2})));
  }
  Outcome run(std::vector<std::string> arguments) const {
    return run_program(std::move(arguments), {.directory = path()});
  }
};

/// Skipped if the program was built without a page; then it says how to get one.
class View : public ::testing::Test {
 protected:
  void SetUp() override {
    const Outcome outcome = scene_.run({"report", "free.npz", "--quiet", "-o", "probe.html"});
    if (outcome.code == 0) return;
    EXPECT_EQ(outcome.err,
              "foldproof: this build of foldproof: has no page to show; make it with './dev build'\n");
    GTEST_SKIP() << "This build of the program has no page: './dev build' makes one.";
  }
  ViewScene scene_;
};

/// Reads until the end of a line.
std::string line_from(int stream) {
  std::string line;
  for (char c = 0; c != '\n' && ::read(stream, &c, 1) == 1;) line += c;
  return line;
}

/// Connects as a browser does that asks for nothing yet, and waits until it is accepted.
void open_connection(int socket, int port) {
  ::sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  EXPECT_EQ(::connect(socket, reinterpret_cast<const ::sockaddr*>(&address), sizeof address), 0);
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
}

TEST_F(View, PrintsItsAddressAndEndsWithCtrlC) {
  int ends[2];
  ASSERT_EQ(::pipe2(ends, O_CLOEXEC), 0);
  std::string line;
  Outcome second;
  std::chrono::steady_clock::time_point interrupted;
  const int tab = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const Outcome outcome =
      run_program({"view", "bend.npz", "--no-browser"},
                  {.directory = scene_.path(), .output = ends[1], .while_it_runs = [&](pid_t child) {
                     line = line_from(ends[0]);
                     std::smatch port;
                     if (std::regex_search(line, port, std::regex(R"(127\.0\.0\.1:(\d+)/)"))) {
                       second = scene_.run({"view", "bend.npz", "--no-browser", "--port", port[1]});
                       open_connection(tab, std::stoi(port[1]));
                     }
                     interrupted = std::chrono::steady_clock::now();
                     ::kill(child, SIGINT);
                   }});
  EXPECT_LT(std::chrono::steady_clock::now() - interrupted, std::chrono::seconds(2));
  ::close(tab);
  EXPECT_TRUE(std::regex_match(line, std::regex(R"(http://127\.0\.0\.1:7[45]\d\d/ \(Ctrl-C ends it\)\n)")))
      << line;
  EXPECT_EQ(outcome.code, 0);
  EXPECT_EQ(outcome.signal, 0);
  EXPECT_EQ(outcome.err, "");
  EXPECT_EQ(second.code, 2);
  EXPECT_THAT(second.err, StartsWith("foldproof: port 7"));
  EXPECT_THAT(second.err,
              HasSubstr("cannot listen: Address already in use; give another, or none: a free one is found"));
  ::close(ends[0]);
  ::close(ends[1]);
}

TEST_F(View, ReportsWithTheExitCodesOfACheck) {
  EXPECT_EQ(scene_.run({"report", "free.npz", "-o", "free.html"}).code, 0);
  const Outcome outcome = scene_.run({"report", "bend.npz", "-o", "it's.html"});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_THAT(outcome.out, HasSubstr("Collisions in "));
  EXPECT_THAT(outcome.out, HasSubstr("% of leaf pairs"));
  EXPECT_THAT(read_file(scene_ / "it's.html"),
              HasSubstr(R"("command":"foldproof report bend.npz -o 'it'\\''s.html'")"));
  EXPECT_EQ(scene_.run({"report", "bend.npz", "--frames", "0", "--static", "-o", "pose.html"}).code, 0);
  EXPECT_EQ(scene_.run({"report", "bend.npz", "--static", "-o", "poses.html"}).code, 1);
}

TEST_F(View, ExplainsMistakesInOneLine) {
  const std::vector<std::pair<std::vector<std::string>, const char*>> mistakes{
      {{"view"}, "MOTION is required"},
      {{"view", "none.npz"}, "none.npz"},
      {{"view", "bend.npz", "--port", "70000"}, "--port: 70000 is not between 1 and 65535"},
      {{"view", "bend.npz", "--frames", "9:"}, "--frames"},
      {{"view", "bend.npz", "--model", "bend.npz"}, "bend.npz"},
      {{"view", "bend.npz", "free.npz"}, "equally many frames"},
      {{"view", "bend.npz", "--static", "--thickness", "1"}, "--static"},
      {{"report", "bend.npz", "--static", "--substeps", "2", "-o", "a.html"}, "--static"},
      {{"report", "bend.npz"}, "--output is required"},
      {{"report", "bend.npz", "-o", "no/a.html"}, "no/a.html"},
      {{"report", "bend.npz", "--frames", "9:", "-o", "a.html"}, "--frames"},
  };
  for (const auto& [arguments, problem] : mistakes) {
    const Outcome outcome = scene_.run(arguments);
    EXPECT_EQ(outcome.code, 2) << problem;
    EXPECT_EQ(outcome.out, "");
    EXPECT_THAT(outcome.err, StartsWith("foldproof: "));
    EXPECT_THAT(outcome.err, HasSubstr(problem));
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  }
  EXPECT_FALSE(std::filesystem::exists(scene_ / "a.html"));
}

TEST(ViewHelp, Teaches) {
  const ViewScene scene;
  EXPECT_THAT(scene.run({"view", "--help"}).out, HasSubstr("foldproof view walk.glb --model body.model"));
  EXPECT_THAT(scene.run({"report", "--help"}).out, HasSubstr("foldproof report walk.glb -o report.html"));
}

}  // namespace
}  // namespace foldproof
