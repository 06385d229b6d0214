// What is no file; Windows has no such pipes.
#include <sys/stat.h>

#include "io/support.h"

namespace foldproof::testing {
namespace {

using PipeTest = IoTest;

TEST_F(PipeTest, IsRefusedAtOnce) {
  ASSERT_EQ(::mkfifo(files.path("pipe.obj").c_str(), 0600), 0);
  EXPECT_EQ(open_error({files.path("pipe.obj")}),
            "pipe.obj: is not a regular file; save the data to a file and name that");
}

}  // namespace
}  // namespace foldproof::testing
