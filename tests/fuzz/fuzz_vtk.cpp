#include "file_target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return foldproof::fuzz::read_as(".vtk", data, size);
}
