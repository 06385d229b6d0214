// Access control, and the files and errors that are served.
#include "page/served.h"

namespace foldproof {
namespace {

using namespace foldproof::testing;
using ::testing::EndsWith;
using ::testing::HasSubstr;

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
  EXPECT_EQ(served.get("/", {{"Host", "127.0.0.1:" + port}, {"Host", "evil.example"}}).status, 403);
  // It listens on loopback: from elsewhere there is nothing to connect to.
  httplib::Client elsewhere("127.0.0.2", served.port());
  EXPECT_FALSE(elsewhere.Get("/"));
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
                ": is taken, or not yours to take; give another, or none: a free one is found");
}

TEST(PageServer, StopsDuringACheckWithAnOpenConnection) {
  // Some seconds of work, and a connection that idles.
  auto served =
      std::make_unique<Served>(page_of(list(bending_tube({64, 200}, std::vector<double>(400, 6.2)))));
  served->get("/api/scene");
  EXPECT_EQ(served->json("/api/steps")["state"], "running");
  const auto start = std::chrono::steady_clock::now();
  httplib::Client idle("127.0.0.1", served->port());
  idle.set_keep_alive(true);
  EXPECT_TRUE(idle.Get("/"));
  served.reset();
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(4));
}

TEST(PageServer, ServesManyClientsAtATime) {
  Served served(page_of(list(colliding_tube(8))));
  std::vector<std::thread> browsers;
  std::atomic<int> good = 0;
  for (int b = 0; b < 8; ++b) {
    browsers.emplace_back([&] {
      httplib::Client client("127.0.0.1", served.port());
      client.set_keep_alive(true);
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
