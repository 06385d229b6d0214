// Prints: walk.obj:12: face refers to vertex 99, but there are 42; export the mesh again
// Errors are values: a Result holds either what was asked for or an Error that says where, what and how to
// fix it.
#include <cstdio>

#include "foldproof/base.h"

foldproof::Result<int> read_number() {
  return foldproof::fail("walk.obj:12", "face refers to vertex 99, but there are 42",
                         "export the mesh again");
}

int main() {
  const auto number = read_number();
  if (number) return 1;
  std::puts(number.error().line().c_str());
}
