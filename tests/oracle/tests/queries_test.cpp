// The oracle against the published single queries, whose answers were computed symbolically by their authors.
#include <gtest/gtest.h>

#include "oracle/data.h"
#include "oracle/oracle.h"

namespace foldproof::oracle {
namespace {

TEST(RealQueries, AreAnsweredAsPublished) {
  const auto data = data_directory();
  if (!data) GTEST_SKIP() << kNoData;
  const std::vector<Query> queries = read_queries(*data);
  ASSERT_GT(queries.size(), 3000u);
  int hits = 0;
  for (const Query& q : queries) {
    hits += q.collides;
    EXPECT_EQ(touches(q.kind, q.x0, q.x1), q.collides) << q.source;
  }
  EXPECT_GT(hits, 300);
}

}  // namespace
}  // namespace foldproof::oracle
