// Clients that are slow, demanding or never end, and their effect on others.
#include "page/connections.h"

#include <arpa/inet.h>
#include <malloc.h>
#include <sys/socket.h>
#include <unistd.h>

#include <filesystem>

#include "page/served.h"

namespace foldproof {
namespace {

using namespace foldproof::testing;
using namespace std::chrono_literals;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::StartsWith;
using Clock = std::chrono::steady_clock;

/// A client that sends arbitrary bytes.
class Raw {
 public:
  explicit Raw(int port) : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    ::sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(::connect(socket_, reinterpret_cast<const ::sockaddr*>(&address), sizeof address), 0);
    const ::timeval patience{.tv_sec = 20, .tv_usec = 0};
    ::setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    ::setsockopt(socket_, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience);
  }
  ~Raw() {
    if (socket_ >= 0) ::close(socket_);
  }
  Raw(Raw&& other) noexcept : socket_(std::exchange(other.socket_, -1)) {}
  Raw& operator=(Raw&&) = delete;

  /// False: the other side has closed.
  bool say(std::string_view text) const {
    while (!text.empty()) {
      const ssize_t count = ::send(socket_, text.data(), text.size(), MSG_NOSIGNAL);
      if (count <= 0) return false;
      text.remove_prefix(static_cast<std::size_t>(count));
    }
    return true;
  }
  /// Reads to the end of the connection. Fails the test if it is not closed.
  std::string all() const {
    std::string text;
    std::array<char, 4096> bytes;
    for (;;) {
      const ssize_t count = ::recv(socket_, bytes.data(), bytes.size(), 0);
      EXPECT_FALSE(count < 0 && errno == EAGAIN) << "the connection stays open";
      if (count <= 0) return text;
      text.append(bytes.data(), static_cast<std::size_t>(count));
    }
  }
  bool is_open() const {
    char byte = 0;
    const ssize_t count = ::recv(socket_, &byte, 1, MSG_PEEK | MSG_DONTWAIT);
    return count > 0 || (count < 0 && errno == EAGAIN);
  }

 private:
  int socket_;
};

std::string head(int port, const std::string& line, const std::string& more = "") {
  return line + "\r\nHost: 127.0.0.1:" + std::to_string(port) + "\r\n" + more + "\r\n";
}

std::vector<Raw> crowd(int port, int count, const std::string& words) {
  std::vector<Raw> all;
  for (int k = 0; k < count; ++k) {
    all.emplace_back(port);
    all.back().say(words);
  }
  return all;
}

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
extern "C" std::size_t __sanitizer_get_current_allocated_bytes();
#endif

/// Resident memory of this program, bytes. Under a sanitizer, what is allocated: the sanitizer itself needs
/// several times as much.
std::size_t memory() {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  return __sanitizer_get_current_allocated_bytes();
#else
  std::ifstream file("/proc/self/statm");
  std::size_t pages = 0;
  file >> pages >> pages;
  return pages * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
#endif
}

void expect_quick_answer(int port, std::chrono::seconds limit = 2s) {
  const auto start = Clock::now();
  httplib::Client client("127.0.0.1", port);
  client.set_read_timeout(20);
  const auto answer = client.Get("/api/scene");
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->status, 200);
  EXPECT_LT(Clock::now() - start, limit);
}

TEST(PageConnections, SlowClientsDoNotBlockOthers) {
  Served served(page_of(list(colliding_tube(3))));
  const std::vector<Raw> silent = crowd(served.port(), 200, "");
  expect_quick_answer(served.port());
  const std::vector<Raw> slow = crowd(served.port(), 200, "GET /api/scene HTTP/1.1\r\nHost: 127");
  expect_quick_answer(served.port());
  // The oldest were closed.
  EXPECT_FALSE(silent.front().is_open());
  EXPECT_TRUE(slow.back().is_open());
}

TEST(PageConnections, UnreadAnswersDoNotBlockOthersAndMemoryIsBounded) {
  const auto page = page_of(list(colliding_tube(3)));
  const std::string large(std::size_t{1} << 22, 'x');
  const PageFile files[] = {{"view/index.html", large}};
  auto server = PageServer::open(*page, files);
  ASSERT_TRUE(server);
  std::atomic<bool> stop = false;
  std::thread thread([&] { EXPECT_TRUE(server->serve(stop)); });
  const std::size_t before = memory();
  const std::string words = head(server->port(), "GET / HTTP/1.1", "Connection: close\r\n");
  const std::vector<Raw> lazy = crowd(server->port(), 120, words);
  // It follows all earlier answers, half a GB, on a machine that may be busy.
  expect_quick_answer(server->port(), 20s);
  ::malloc_trim(0);
  EXPECT_LT(memory(), before + Connections::kMaxUnsent * 5 / 4);
  expect_quick_answer(server->port());
  EXPECT_LT(lazy.front().all().size(), large.size()) << "the oldest is dropped";
  EXPECT_GT(lazy.back().all().size(), large.size());
  stop = true;
  thread.join();
}

TEST(PageConnections, RefusesLongRequests) {
  Served served(page_of(list(colliding_tube(3))));
  const int port = served.port();
  const std::string many_headers = [] {
    std::string text;
    for (int k = 0; k < 4000; ++k) text += "X-" + std::to_string(k) + ": y\r\n";
    return text;
  }();
  for (const std::string& words :
       {"GET /" + std::string(20'000, 'x'), head(port, "GET / HTTP/1.1", many_headers),
        head(port, "GET / HTTP/1.1", "X: " + std::string(20'000, 'y') + "\r\n")}) {
    const Raw client(port);
    client.say(words);
    EXPECT_THAT(client.all(), StartsWith("HTTP/1.1 431 Request Header Fields Too Large\r\n"));
  }
  // Smaller heads go to the library, which limits single lines.
  const Raw client(port);
  client.say(head(port, "GET /" + std::string(9000, 'x') + " HTTP/1.1", "Connection: close\r\n"));
  EXPECT_THAT(client.all(), StartsWith("HTTP/1.1 414 "));
}

TEST(PageConnections, AnEndlessRequestLineUsesNoMemory) {
  Served served(page_of(list(colliding_tube(3))));
  served.all_steps();
  const std::size_t before = memory();
  const Raw client(served.port());
  const std::string megabyte(std::size_t{1} << 20, 'x');
  const auto start = Clock::now();
  client.say("GET /");
  std::size_t peak = 0;
  for (int k = 0; k < 50 && client.say(megabyte); ++k) peak = std::max(peak, memory());
  client.all();
  EXPECT_LT(Clock::now() - start, 10s);
  EXPECT_LT(peak, before + (std::size_t{16} << 20));
  EXPECT_EQ(served.get("/").status, 200);
}

TEST(PageConnections, ClosesIdleAndSlowConnections) {
  Served served(page_of(list(colliding_tube(3))));
  const Raw idle(served.port()), used(served.port()), slow(served.port());
  used.say(head(served.port(), "GET /nothing HTTP/1.1"));
  const std::string words = "GET /" + std::string(1000, 'x');
  const auto start = Clock::now();
  for (std::size_t k = 0; Clock::now() - start < 7s && slow.is_open(); ++k) {
    slow.say(std::string_view(words).substr(std::min(k, words.size() - 1), 1));
    std::this_thread::sleep_for(10ms);
  }
  const auto lasted = Clock::now() - start;
  EXPECT_GT(lasted, Connections::kHeadTime - 1s);
  EXPECT_LT(lasted, Connections::kHeadTime + 1s);
  EXPECT_EQ(idle.all(), "");
  EXPECT_THAT(used.all(), EndsWith("{\"error\":\"there is nothing here\"}"));
}

TEST(PageConnections, StopsAtOnceWithOpenConnections) {
  auto served = std::make_unique<Served>(page_of(list(colliding_tube(3))));
  served->all_steps();
  const int port = served->port();
  const std::vector<Raw> idle = crowd(port, 20, ""), slow = crowd(port, 20, "GET / HT"),
                         used = crowd(port, 20, head(port, "GET / HTTP/1.1"));
  served->get("/");
  const auto start = Clock::now();
  served.reset();
  EXPECT_LT(Clock::now() - start, 1s);
}

TEST(PageConnections, AnswersSeveralRequestsOnAConnection) {
  Served served(page_of(list(colliding_tube(3))));
  const int port = served.port();
  const auto answers = [&](const std::string& words) {
    const Raw client(port);
    client.say(words);
    std::vector<std::string> lines;
    const std::string text = client.all();
    for (std::size_t at = 0; (at = text.find("HTTP/1.1 ", at)) != text.npos; at += 9)
      lines.push_back(text.substr(at + 9, 3));
    return lines;
  };
  using Lines = std::vector<std::string>;
  const std::string closing = "Connection: close\r\n";
  EXPECT_EQ(answers(head(port, "GET / HTTP/1.1") + head(port, "GET /nothing HTTP/1.1") +
                    head(port, "HEAD / HTTP/1.1", closing)),
            (Lines{"200", "404", "200"}));
  EXPECT_EQ(answers(head(port, "GET / HTTP/1.0")), Lines{"200"});
  // A body is never taken for a request.
  const std::string inner = head(port, "GET /api/scene HTTP/1.1");
  const std::string length = "Content-Length: " + std::to_string(inner.size()) + "\r\n";
  EXPECT_EQ(answers(head(port, "POST / HTTP/1.1", length) + inner), Lines{"405"});
  EXPECT_EQ(answers(head(port, "GET / HTTP/1.1", length) + inner), Lines{"200"});
  EXPECT_EQ(answers(head(port, "GET / HTTP/1.1", "Transfer-Encoding: chunked\r\nConnection: keep-alive\r\n") +
                    inner),
            Lines{"200"});
  EXPECT_EQ(answers(head(port, "POST / HTTP/1.1", length + "Expect: 100-continue\r\n")), Lines{"405"});
  // Invalid requests close the connection.
  for (const char* words : {"\r\n\r\n", "\n\r\n", "GET\r\n\r\n", "\r\nGET / HTTP/1.1\r\n\r\n",
                            "GET / HTTP/9.9\r\nHost: x\r\n\r\n", "\x16\x03\x01\n\r\n"})
    EXPECT_EQ(answers(words + inner), Lines{"400"}) << words;
}

TEST(PageConnections, IgnoresRanges) {
  Served served(page_of(list(colliding_tube(3))));
  std::string many = "bytes=0-1";
  while (many.size() < 8000) many += ",0-1";
  for (const std::string& range : {std::string("bytes=0-3"), many}) {
    const httplib::Response response = served.get("/", {{"Range", range}, {"Accept-Encoding", "gzip, br"}});
    EXPECT_EQ(response.status, 200);
    EXPECT_EQ(response.body, kStubPage[0].bytes);
    EXPECT_FALSE(response.has_header("Content-Encoding"));
  }
  // The library's answer to an invalid range.
  EXPECT_EQ(served.get("/", {{"Range", "bytes=99999999999999999999999-"}}).status, 416);
}

/// The socket on which this program listens.
int listening_at(int port) {
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) {
    const int socket = std::stoi(entry.path().filename());
    int listens = 0;
    ::socklen_t size = sizeof listens;
    if (::getsockopt(socket, SOL_SOCKET, SO_ACCEPTCONN, &listens, &size) != 0 || listens == 0) continue;
    ::sockaddr_in address{};
    size = sizeof address;
    ::getsockname(socket, reinterpret_cast<::sockaddr*>(&address), &size);
    if (ntohs(address.sin_port) == port) return socket;
  }
  return -1;
}

TEST(PageConnections, ReportsWhenListeningFails) {
  for (const bool while_it_serves : {false, true}) {
    const auto page = page_of(list(colliding_tube(3)));
    auto server = PageServer::open(*page, kStubPage);
    ASSERT_TRUE(server);
    const int socket = listening_at(server->port());
    ASSERT_GE(socket, 0);
    const auto end = [&] { ::shutdown(socket, SHUT_RDWR); };
    std::thread ender;
    if (while_it_serves) {
      ender = std::thread([&] {
        EXPECT_TRUE(httplib::Client("127.0.0.1", server->port()).Get("/"));
        end();
      });
    } else {
      end();
    }
    const auto start = Clock::now();
    const std::atomic<bool> never = false;
    const auto served = server->serve(never);
    if (ender.joinable()) ender.join();
    ASSERT_FALSE(served);
    EXPECT_EQ(served.error().line(),
              "the page's server: can no longer listen: Invalid argument; start it again");
    EXPECT_LT(Clock::now() - start, 10s);
  }
}

TEST(PageConnections, ReportsWhenThereAreNoMoreSockets) {
  const auto page = page_of(list(colliding_tube(3)));
  // While there are sockets it opens. UBSan checks its type here first, which takes file descriptors.
  ASSERT_TRUE(PageServer::open(*page, kStubPage));
  std::vector<int> all;
  for (int taken; (taken = ::dup(STDERR_FILENO)) >= 0 && all.size() < 100'000;) all.push_back(taken);
  const auto server = PageServer::open(*page, kStubPage);
  for (const int taken : all) ::close(taken);
  if (all.size() == 100'000) GTEST_SKIP() << "there is no limit here";
  ASSERT_FALSE(server);
  EXPECT_THAT(server.error().line(), HasSubstr("cannot listen: Too many open files"));
}

}  // namespace
}  // namespace foldproof
