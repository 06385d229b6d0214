// Contacts as the page asks for them.
#include "page/served.h"

namespace foldproof {
namespace {

using namespace foldproof::testing;
using ::testing::HasSubstr;
using ::testing::SizeIs;

TEST(PageContacts, AreListedAtTheEndOfTheCheck) {
  Served served(page_of(sphere_pair(5)));
  served.all_steps();
  const Json answer = served.json("/api/contacts");
  EXPECT_EQ(answer["searched"], true);
  EXPECT_EQ(answer["unknown_frames"], 0);
  EXPECT_EQ(answer["total"], 1);
  ASSERT_THAT(answer["items"], SizeIs(1));
  const Json& item = answer["items"][0];
  EXPECT_EQ(item["from_start"], true);
  EXPECT_EQ(item["sides"][0]["name"], "left");
  EXPECT_THAT(item["frames"], SizeIs(5));
  EXPECT_GT(item["depth"], 0.3);
  EXPECT_FALSE(item.contains("curves"));
  const Json contact = served.json("/api/contacts/0");
  EXPECT_EQ(contact["depth"], item["depth"]);
  EXPECT_THAT(contact["curves"], SizeIs(1));
  EXPECT_FALSE(contact["sides"][1]["inside"].empty());
  EXPECT_THAT(contact["view"], SizeIs(3));
  EXPECT_EQ(contact["group"], 0);
  const Json verdict = served.json("/api/steps")["verdict"];
  EXPECT_EQ(verdict["kind"], "found");
  EXPECT_THAT(verdict["text"].get<std::string>(), HasSubstr("left and right go through each other, "));
  EXPECT_THAT(served.json("/api/contacts/1", 404)["error"], HasSubstr("no contact 1 among 1"));
  EXPECT_THAT(served.json("/api/contacts?offset=1")["items"], SizeIs(0));
  served.json("/api/contacts?limit=1001", 400);
}

TEST(PageContacts, WaitForTheEndOfTheCheck) {
  const auto page = page_of(sphere_pair(3));
  EXPECT_EQ(page->get("/api/contacts").status, 425);
  const std::atomic<bool> stop{true};
  page->work(stop);
  EXPECT_EQ(page->get("/api/contacts/0").status, 404);
  EXPECT_THAT(page->get("/api/contacts").body, HasSubstr("stopped"));
}

}  // namespace
}  // namespace foldproof
