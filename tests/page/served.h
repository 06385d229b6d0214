/// Serves a page on a real socket, and reads it as a browser does.
#pragma once

#include <gmock/gmock.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <numbers>
#include <thread>

#include "model/cylinder.h"
#include "page/page.h"
#include "report/sinking_triangle.h"

// Last: system headers in it define macros that Eigen stumbles over.
#include <httplib.h>

namespace foldproof::testing {

using Json = nlohmann::json;

inline constexpr PageFile kStubPage[] = {{"view/index.html", "<!doctype html><title>stub</title>"},
                                         {"view/assets/page.js", "'stub'"},
                                         {"report/report.js", "'report'"},
                                         {"report/report.css", "body{}"},
                                         {"report/report.js.sha256", "c3R1Yg=="}};

inline std::unique_ptr<Page> page_of(std::vector<std::unique_ptr<Motion>> motions, CheckSettings check = {}) {
  auto page = Page::open({std::move(motions), std::move(check), {}});
  EXPECT_TRUE(page) << page.error().line();
  return page ? std::move(*page) : nullptr;
}

/// The body as an array of numbers.
template <class T>
std::vector<T> numbers_in(const std::string& body) {
  EXPECT_EQ(body.size() % sizeof(T), 0u);
  std::vector<T> values(body.size() / sizeof(T));
  std::memcpy(values.data(), body.data(), values.size() * sizeof(T));
  return values;
}

/// Serves a page until it is destroyed.
class Served {
 public:
  explicit Served(std::unique_ptr<Page> page, int port = 0) : page_(std::move(page)) {
    auto server = PageServer::open(*page_, kStubPage, port);
    EXPECT_TRUE(server) << server.error().line();
    server_ = std::make_unique<PageServer>(std::move(*server));
    client_ = std::make_unique<httplib::Client>("127.0.0.1", server_->port());
    client_->set_read_timeout(60);  // for busy machines
    thread_ = std::thread([this] {
      const auto served = server_->serve();
      EXPECT_TRUE(served) << served.error().line();
    });
  }
  ~Served() {
    server_->stop();
    thread_.join();
  }
  Served(const Served&) = delete;
  Served& operator=(const Served&) = delete;

  int port() const { return server_->port(); }
  httplib::Client& client() { return *client_; }

  httplib::Response get(const std::string& path, const httplib::Headers& headers = {}) {
    const auto result = client_->Get(path, headers);
    EXPECT_TRUE(result) << path;
    return result ? *result : httplib::Response{};
  }
  Json json(const std::string& path, int status = 200) {
    const httplib::Response response = get(path);
    EXPECT_EQ(response.status, status) << path << ": " << response.body.substr(0, 200);
    EXPECT_EQ(response.get_header_value("Content-Type"), "application/json");
    return Json::parse(response.body, nullptr, false);
  }
  template <class T>
  std::vector<T> numbers(const std::string& path) {
    const httplib::Response response = get(path);
    EXPECT_EQ(response.status, 200) << path << ": " << response.body.substr(0, 200);
    EXPECT_EQ(response.get_header_value("Content-Type"), "application/octet-stream");
    return numbers_in<T>(response.body);
  }
  /// The answer for all steps, once the check has ended.
  Json all_steps() {
    for (int k = 0; k < 1000; ++k) {
      Json answer = json("/api/steps?from=0");
      if (answer["state"] != "running") return answer;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    ADD_FAILURE() << "the check does not end";
    return {};
  }

 private:
  std::unique_ptr<Page> page_;
  std::unique_ptr<PageServer> server_;
  std::unique_ptr<httplib::Client> client_;
  std::thread thread_;
};

/// A tube that bends until its ends collide.
inline std::unique_ptr<Motion> colliding_tube(std::size_t frames = 8, double max_angle = 7) {
  std::vector<double> angles;
  for (std::size_t k = 0; k < frames; ++k)
    angles.push_back(0.5 + max_angle * static_cast<double>(k) / static_cast<double>(frames));
  return bending_tube({24, 30}, angles, "tube");
}

inline std::vector<double> frame_of(Motion& motion, Index k) {
  std::vector<double> x(3 * std::size_t{motion.topology().vertex_count()});
  EXPECT_TRUE(motion.read_frame(k, x));
  return x;
}

/// A unit sphere centered at (x, y, 0).
inline std::vector<double> sphere_at(double center_x, double center_y = 0, Index around = 16,
                                     Index rings = 12) {
  std::vector<double> x;
  for (Index ring = 0; ring <= rings; ++ring) {
    const double angle = std::numbers::pi * (ring + 0.01) / (rings + 0.02);  // no two vertices at a pole
    for (Index i = 0; i < around; ++i) {
      const double turn = 2 * std::numbers::pi * i / around;
      x.insert(x.end(), {center_x + std::sin(angle) * std::cos(turn), center_y + std::cos(angle),
                         std::sin(angle) * std::sin(turn)});
    }
  }
  return x;
}

/// Two spheres that move together. At a distance of 1 they overlap by half.
inline std::vector<std::unique_ptr<Motion>> sphere_pair(std::size_t frames, double distance = 1) {
  std::vector<std::vector<double>> left, right;
  for (std::size_t k = 0; k < frames; ++k) {
    left.push_back(sphere_at(0.3 * static_cast<double>(k)));
    // Not a mirror image, so that no two edges touch.
    right.push_back(sphere_at(0.3 * static_cast<double>(k) + distance, 0.07));
  }
  return list(memory_motion("left", tube(16, 12), std::move(left)),
              memory_motion("right", tube(16, 12), std::move(right)));
}

/// A motion that cannot be read from a frame on.
class UnreadableFrom final : public Motion {
 public:
  UnreadableFrom(std::unique_ptr<Motion> motion, Index frame) : motion_(std::move(motion)), frame_(frame) {}
  const std::string& name() const override { return motion_->name(); }
  const Topology& topology() const override { return motion_->topology(); }
  Index frame_count() const override { return motion_->frame_count(); }
  Result<void> read_frame(Index k, std::span<double> out) override {
    if (k < frame_) return motion_->read_frame(k, out);
    return fail(ErrorCode::InvalidFile, name() + ", frame " + std::to_string(k), "is torn",
                "export it again");
  }

 private:
  std::unique_ptr<Motion> motion_;
  Index frame_;
};

}  // namespace foldproof::testing
