// What is thrown ends neither the server nor a check that is done. This file replaces operator new.
#include <algorithm>
#include <cstdlib>
#include <new>
#include <utility>

#include "page/served.h"
#include "report/sinking_triangle.h"

namespace {
thread_local bool next_fails = false;
}

[[gnu::noinline]] void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  return std::exchange(next_fails, false) ? nullptr : std::malloc(std::max<std::size_t>(size, 1));
}
[[gnu::noinline]] void* operator new(std::size_t size) {
  void* p = operator new(size, std::nothrow);
  if (p == nullptr) throw std::bad_alloc();
  return p;
}
[[gnu::noinline]] void operator delete(void* p) noexcept { std::free(p); }
[[gnu::noinline]] void operator delete(void* p, std::size_t) noexcept { std::free(p); }

namespace foldproof {
namespace {

using namespace foldproof::testing;
using ::testing::HasSubstr;

/// A motion whose reader throws in the last frame.
struct Throwing final : Motion {
  const std::string& name() const override { return motion->name(); }
  const Topology& topology() const override { return motion->topology(); }
  Index frame_count() const override { return motion->frame_count(); }
  Result<void> read_frame(Index k, std::span<double> out) override {
    if (k + 1 == frame_count()) throw std::length_error("too long");
    return motion->read_frame(k, out);
  }

  std::unique_ptr<Motion> motion = colliding_tube(4);
};

TEST(PageExceptions, EndTheCheckAndAnswer500) {
  Served served(page_of(list(std::make_unique<Throwing>())));
  const Json steps = served.all_steps();
  EXPECT_EQ(steps["state"], "failed");
  EXPECT_THAT(steps["error"].get<std::string>(), HasSubstr("too long"));
  EXPECT_THAT(served.json("/api/objects/0/frames/3", 500)["error"].get<std::string>(), HasSubstr("too long"));
  served.json("/api/scene");
}

TEST(PageExceptions, WithoutMemoryForARadiusTheCheckStaysDone) {
  const std::vector<double> angles{0.2, 0.5, 0.9};
  CheckSettings check;
  check.models = {std::make_shared<const Model>(trained(*bending_tube(kSmallTube, angles)))};
  const auto page = page_of(list(bending_tube(kSmallTube, angles)), check);
  const std::atomic<bool> stop = false;
  while (page->advance(stop)) {
  }
  page->get("/api/objects/0/model/radius");
  next_fails = true;
  EXPECT_TRUE(page->advance(stop));
  EXPECT_FALSE(page->advance(stop)) << "the radius is still queued";
  const Json radius = Json::parse(page->get("/api/objects/0/model/radius").body);
  EXPECT_EQ(radius["state"], "failed");
  EXPECT_THAT(radius["error"].get<std::string>(), HasSubstr("memory"));
  EXPECT_EQ(Json::parse(page->get("/api/steps").body)["state"], "done");
}

}  // namespace
}  // namespace foldproof
