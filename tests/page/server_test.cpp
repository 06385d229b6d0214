// Access control, the files and errors that are served, and clients that keep connections open.
#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

#include <deque>
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

/// A connection over which any bytes go.
class Raw {
 public:
  explicit Raw(int port) {
    ::sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(::connect(socket_, reinterpret_cast<const ::sockaddr*>(&address), sizeof address), 0);
  }
  Raw(int port, std::string_view text) : Raw(port) {
    EXPECT_EQ(::send(socket_, text.data(), text.size(), MSG_NOSIGNAL), std::ssize(text));
  }
  ~Raw() { ::close(socket_); }
  Raw(const Raw&) = delete;
  Raw& operator=(const Raw&) = delete;

  /// What comes until the server closes the connection.
  std::string answer() const {
    std::string text;
    std::array<char, 4096> bytes;
    for (ssize_t count; (count = ::recv(socket_, bytes.data(), bytes.size(), 0)) > 0;)
      text.append(bytes.data(), static_cast<std::size_t>(count));
    return text;
  }

 private:
  int socket_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
};

std::string request(int port, const std::string& line, const std::string& more = "") {
  return line + "\r\nHost: 127.0.0.1:" + std::to_string(port) + "\r\n" + more + "\r\n";
}

std::ptrdiff_t count_of(std::string_view what, std::string_view text) {
  std::ptrdiff_t count = 0;
  for (std::size_t at = 0; (at = text.find(what, at)) != text.npos; ++at) ++count;
  return count;
}

TEST(PageServer, ServesThePageAndNothingElse) {
  Served served(page_of(list(colliding_tube(3))));
  const httplib::Response index = served.get("/");
  EXPECT_EQ(index.status, 200);
  EXPECT_EQ(index.body, kStubPage[0].bytes);
  EXPECT_EQ(index.get_header_value("Content-Type"), "text/html; charset=utf-8");
  EXPECT_EQ(served.get("/assets/page.js").body, kStubPage[1].bytes);
  EXPECT_EQ(served.get("/assets/page.js").get_header_value("Content-Type"), "text/javascript; charset=utf-8");
  for (const char* path :
       {"/assets/", "/assets/none.js", "/report/report.js", "/../report/report.js", "/etc/passwd",
        "/../../../../etc/passwd", "/assets/../../../../etc/passwd", "/assets/%2e%2e/%2e%2e/etc/passwd",
        "/assets/..%2f..%2fetc%2fpasswd", "/api", "/api/", "/api/nothing", "/api/objects/0",
        "/api/../etc/passwd", "//etc/passwd", "/api/scene/"}) {
    const Json answer = served.json(path, 404);
    EXPECT_EQ(answer["error"], "there is nothing here") << path;
  }
}

TEST(PageServer, RefusesBadNumbersInOneLine) {
  Served served(page_of(list(colliding_tube(3))));
  served.all_steps();
  for (const char* path :
       {"/api/objects/-1/triangles", "/api/objects/x/frames/0", "/api/objects/0/frames/1.5",
        "/api/objects/0/frames/", "/api/objects/0/frames/99999999999999999999",
        "/api/objects/0/boxes?frame=a", "/api/objects/0/boxes?level=-1", "/api/steps?from=x",
        "/api/steps/0/collisions?limit=1001", "/api/steps/0/collisions?offset=0x1",
        "/api/steps/%200/collisions"}) {
    const Json answer = served.json(path, 400);
    EXPECT_EQ(std::count(answer["error"].begin(), answer["error"].end(), '\n'), 0);
    EXPECT_THAT(answer["error"].get<std::string>(), HasSubstr("no number")) << path;
  }
  for (const char* path :
       {"/api/objects/1/triangles", "/api/objects/0/frames/3", "/api/objects/0/boxes?frame=3",
        "/api/objects/0/boxes?level=99", "/api/steps/2/collisions", "/api/steps/0/faces/1",
        "/api/objects/4294967296/triangles", "/api/steps/18446744073709551615/collisions"}) {
    EXPECT_THAT(served.json(path, 404)["error"].get<std::string>(), ::testing::Not("")) << path;
  }
}

TEST(PageServer, IsForThisMachineOnly) {
  Served served(page_of(list(colliding_tube(3))));
  const std::string port = std::to_string(served.port());
  for (const std::string& host : {"127.0.0.1:" + port, "localhost:" + port, "[::1]:" + port})
    EXPECT_EQ(served.get("/api/scene", {{"Host", host}}).status, 200) << host;
  for (const std::string& host :
       std::vector<std::string>{"127.0.0.1", "localhost", "evil.example:" + port, "127.0.0.1:1",
                                "127.0.0.1:" + port + ".evil.example", "LOCALHOST.evil:" + port, ""}) {
    for (const char* path : {"/", "/api/scene", "/assets/page.js", "/nothing"}) {
      const httplib::Response response = served.get(path, {{"Host", host}});
      EXPECT_EQ(response.status, 403) << host << path;
      EXPECT_THAT(Json::parse(response.body)["error"].get<std::string>(), HasSubstr("machine"));
    }
  }
  // It listens on loopback: from elsewhere there is nothing to connect to.
  httplib::Client elsewhere("127.0.0.2", served.port());
  EXPECT_FALSE(elsewhere.Get("/"));
}

TEST(PageServer, RefusesDisguisedHosts) {
  Served served(page_of(list(colliding_tube(3))));
  const std::string here = "127.0.0.1:" + std::to_string(served.port());
  const auto answer = [&](const std::string& hosts) {
    return Raw(served.port(), "GET /api/scene HTTP/1.1\r\n" + hosts + "\r\n").answer();
  };
  EXPECT_THAT(answer("Host: " + here + "\r\n"), StartsWith("HTTP/1.1 200 "));
  EXPECT_THAT(answer("hOST:" + here + " \r\n"), StartsWith("HTTP/1.1 200 "));
  using std::string_literals::operator""s;
  const std::string disguised[] = {
      "",
      "Host:\r\n",
      "Host: " + here + "\r\nHost: evil.example\r\n",
      "Host: evil.example\r\nHost: " + here + "\r\n",
      "Host: " + here + "\r\nhost: " + here + "\r\n",
      "Host: " + here + "%00.evil.example\r\n",
      "Host: " + here + "\0.evil.example\r\n"s,
      "Host: " + here + "%2Eevil.example\r\n",
      "Host: evil%2Eexample\r\n",
      "Host: EVIL.EXAMPLE\r\n",
      "Host: " + here + "@evil.example\r\n",
      "Host: evil.example@" + here + "\r\n",
      "Host: " + here + ",evil.example\r\n",
      "Host: http://" + here + "\r\n",
      "Host: 127.0.0.1.:" + std::to_string(served.port()) + "\r\n",
      "X-Forwarded-Host: " + here + "\r\nHost: evil.example\r\n",
  };
  for (const std::string& hosts : disguised)
    EXPECT_THAT(answer(hosts), StartsWith("HTTP/1.1 403 ")) << ::testing::PrintToString(hosts);
}

// Else a page whose host is refused would send a request with another Host in the body of its own.
TEST(PageServer, AnswersOneRequestPerConnection) {
  Served served(page_of(list(colliding_tube(3))));
  const int port = served.port();
  const std::string inner = request(port, "GET /api/scene HTTP/1.1");
  const std::string length = "Content-Length: " + std::to_string(inner.size()) + "\r\n";
  const std::string foreign = " / HTTP/1.1\r\nHost: evil.example\r\n" + length;
  for (const auto& [text, status] : std::vector<std::pair<std::string, std::string>>{
           {"POST" + foreign + "\r\n" + inner, "403"},
           {"GET" + foreign + "\r\n" + inner, "403"},
           {"POST" + foreign + "Connection: keep-alive\r\n\r\n" + inner, "403"},
           {"POST / HTTP/1.1\r\nHost: evil.example\r\nTransfer-Encoding: chunked\r\n\r\n" + inner, "403"},
           {"GET / HTTP/9.9\r\nHost: evil.example\r\n\r\n" + inner, "400"},
           {"GET /" + std::string(9000, 'x') + " HTTP/1.1\r\n\r\n" + inner, "414"},
           {"GET / HTTP/1.1\r\nRange: bytes=2-1\r\n\r\n" + inner, "416"},
           {request(port, "GET /nothing HTTP/1.1") + inner, "404"},
           {inner, "200"}}) {
    const std::string answer = Raw(port, text).answer();
    EXPECT_THAT(answer, StartsWith("HTTP/1.1 " + status + " ")) << text;
    EXPECT_EQ(count_of("HTTP/1.1 ", answer), 1) << text;
    EXPECT_THAT(answer, HasSubstr("\r\nConnection: close\r\n")) << text;
  }
}

TEST(PageServer, SendsNothingBeyondAnAnswer) {
  Served served(page_of(list(colliding_tube(3))));
  const std::string body(kStubPage[0].bytes);
  const auto part = [&](const std::string& range) {
    const std::string answer =
        Raw(served.port(), request(served.port(), "GET / HTTP/1.1", "Range: bytes=" + range + "\r\n"))
            .answer();
    return answer.substr(answer.find("\r\n\r\n") + 4);
  };
  EXPECT_EQ(part("2-4"), body.substr(2, 3));
  EXPECT_EQ(part("2-1000000"), body.substr(2));
  EXPECT_EQ(part("1000000-"), "");
  EXPECT_EQ(part("1000000-2000000"), "");
  EXPECT_EQ(part("-5"), body.substr(body.size() - 5));
  for (const char* several : {"0-1,1000000-2000000", "0-1,-5", "0-,2-1000000", "-1000000,0-1"})
    EXPECT_LT(part(several).size(), 1000u) << several;
  // Answers are not compressed, which takes longer than sending them.
  EXPECT_EQ(served.get("/", {{"Accept-Encoding", "gzip, br"}}).body, body);
}

TEST(PageServer, IsForBrowsersThatLeaveOutPort80) {
  auto page = page_of(list(colliding_tube(3)));
  if (!PageServer::open(*page, kStubPage, 80)) GTEST_SKIP() << "port 80 is taken, or not ours to take";
  Served served(std::move(page), 80);
  for (const char* host : {"127.0.0.1", "localhost", "[::1]", "127.0.0.1:80"})
    EXPECT_EQ(served.get("/api/scene", {{"Host", host}}).status, 200) << host;
  for (const char* host : {"evil.example", "evil.example:80", "127.0.0.1.evil.example", "127.0.0.1:81", ""})
    EXPECT_EQ(served.get("/api/scene", {{"Host", host}}).status, 403) << host;
}

TEST(PageServer, SendsSecurityHeaders) {
  Served served(page_of(list(colliding_tube(3))));
  for (const char* path : {"/", "/api/scene", "/api/objects/0/triangles", "/nothing"}) {
    const httplib::Response response = served.get(path);
    const std::string policy = response.get_header_value("Content-Security-Policy");
    EXPECT_THAT(policy, HasSubstr("default-src 'none'; script-src 'self';"));
    EXPECT_THAT(policy, HasSubstr("connect-src 'self'; base-uri 'none';"));
    EXPECT_THAT(policy, EndsWith("; frame-ancestors http://127.0.0.1:* http://localhost:*"));
    EXPECT_EQ(response.get_header_value("X-Content-Type-Options"), "nosniff");
    EXPECT_EQ(response.get_header_value("Referrer-Policy"), "no-referrer");
    EXPECT_FALSE(response.has_header("Access-Control-Allow-Origin"));
  }
}

TEST(PageServer, OnlyReads) {
  Served served(page_of(list(colliding_tube(3))));
  httplib::Client& client = served.client();
  EXPECT_EQ(client.Post("/api/scene", "x=1", "text/plain")->status, 405);
  EXPECT_EQ(client.Put("/api/scene", "x=1", "text/plain")->status, 405);
  EXPECT_EQ(client.Delete("/api/scene")->status, 405);
  EXPECT_EQ(client.Options("/api/scene")->status, 405);
  const auto head = client.Head("/api/scene");
  EXPECT_EQ(head->status, 200);
  EXPECT_EQ(head->body, "");
}

TEST(PageServer, TakesAFreePortAndReportsATakenOne) {
  const auto a = page_of(list(colliding_tube(3))), b = page_of(list(colliding_tube(3)));
  const auto first = PageServer::open(*a, kStubPage), second = PageServer::open(*b, kStubPage);
  ASSERT_TRUE(first && second);
  EXPECT_GE(first->port(), kFirstPagePort);
  EXPECT_NE(second->port(), first->port());
  const auto third = PageServer::open(*b, kStubPage, first->port());
  ASSERT_FALSE(third);
  EXPECT_EQ(third.error().line(),
            "port " + std::to_string(first->port()) +
                ": cannot listen: Address already in use; give another, or none: a free one is found");
}

TEST(PageServer, ReportsWhenThereAreNoMoreSockets) {
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

TEST(PageServer, ReportsWhenListeningFails) {
  const auto page = page_of(list(colliding_tube(3)));
  auto server = PageServer::open(*page, kStubPage);
  ASSERT_TRUE(server);
  ::shutdown(listening_at(server->port()), SHUT_RDWR);
  const auto served = server->serve();
  ASSERT_FALSE(served);
  EXPECT_EQ(served.error().line(), "the page's server: can no longer listen; start it again");
}

TEST(PageServer, StopsDuringACheck) {
  // Some seconds of work.
  auto served =
      std::make_unique<Served>(page_of(list(bending_tube({64, 200}, std::vector<double>(400, 6.2)))));
  EXPECT_EQ(served->json("/api/steps")["state"], "running");
  const auto start = Clock::now();
  served.reset();
  EXPECT_LT(Clock::now() - start, 4s);
}

// Browsers open some connections ahead of requests, and may not read an answer while they are busy.
TEST(PageServer, AnswersWhileTabsKeepConnectionsOpen) {
  const auto page = page_of(list(colliding_tube(3)));
  const std::string large(std::size_t{1} << 24, 'x');
  const PageFile files[] = {{"view/index.html", large}};
  auto server = PageServer::open(*page, files);
  ASSERT_TRUE(server);
  std::deque<Raw> tabs;
  for (int k = 0; k < 12; ++k) tabs.emplace_back(server->port());
  for (int k = 0; k < 12; ++k) tabs.emplace_back(server->port(), request(server->port(), "GET / HTTP/1.1"));
  std::thread thread([&] { EXPECT_TRUE(server->serve()); });
  const auto start = Clock::now();
  for (int k = 0; k < 20; ++k) {
    const auto answer = httplib::Client("127.0.0.1", server->port()).Get("/api/scene");
    EXPECT_TRUE(answer && answer->status == 200);
  }
  EXPECT_LT(Clock::now() - start, 3s);
  EXPECT_THAT(tabs.back().answer(), EndsWith(large));
  tabs.clear();
  server->stop();
  thread.join();
}

TEST(PageServer, ServesManyClientsAtATime) {
  Served served(page_of(list(colliding_tube(8))));
  std::vector<std::thread> browsers;
  std::atomic<int> good = 0;
  for (int b = 0; b < 8; ++b) {
    browsers.emplace_back([&] {
      httplib::Client client("127.0.0.1", served.port());
      for (int k = 0; k < 24; ++k) {
        const auto answer = client.Get("/api/objects/0/frames/" + std::to_string(k % 8));
        good += answer && answer->status == 200 && answer->body.size() == 12u * 24 * 31;
      }
    });
  }
  for (std::thread& browser : browsers) browser.join();
  EXPECT_EQ(good, 8 * 24);
}

}  // namespace
}  // namespace foldproof
