// Files that are not what their names say.
#include "io/support.h"

namespace foldproof::testing {
namespace {

class RecognizeTest : public IoTest {};

constexpr const char* kPointer =
    "version https://git-lfs.github.com/spec/v1\n"
    "oid sha256:4d7a214614ab2935c943f9e0ff69d22eadbb8f32b1258daaa5e2ca24d17e2393\nsize 12345\n";

/// The text in UTF-16, with its mark.
std::string utf16(std::string_view text, std::endian order) {
  std::string bytes = bytes_of<std::uint16_t>(0xfeff, order);
  for (const char c : text) bytes += bytes_of<std::uint16_t>(static_cast<unsigned char>(c), order);
  return bytes;
}

TEST_F(RecognizeTest, NamesThemInEveryFormat) {
  const std::string html = ": is an HTML page, not the file itself; download it again",
                    wide = ": is UTF-16 text; save it as UTF-8", obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  const std::vector<std::pair<std::string, std::string>> cases{
      {kPointer, ": is a pointer of Git LFS, not the file itself; run 'git lfs pull'"},
      {"", ": is empty; copy or export it again"},
      {"\n<!DOCTYPE HTML>\n<html lang=\"en\"><head></head></html>", html},
      {"\xef\xbb\xbf<HTML>", html},
      {"<?xml version=\"1.0\"?>\n<!doctype html>", html},
      {utf16(obj, std::endian::little), wide},
      {utf16(obj, std::endian::big), wide}};
  const std::string mesh = files.write("mesh.obj", obj);
  for (const std::string extension : {"obj", "off", "ply", "stl", "vtp", "vtu", "vtk", "msh", "pc2", "mdd",
                                      "npz", "npy", "pvd", "gltf", "glb"}) {
    for (const auto& [bytes, expected] : cases) {
      const std::string name = "a." + extension, path = files.write(name, bytes);
      std::vector<std::string> arguments{path};
      if (extension == "pc2" || extension == "mdd") arguments.insert(arguments.begin(), mesh);
      if (extension == "npy") arguments.push_back(path);
      EXPECT_EQ(open_error(arguments), name + expected);
      const auto table = read_csv(path);
      EXPECT_EQ(table ? "no error" : shown(table.error()), name + expected);
    }
  }
}

TEST_F(RecognizeTest, TakesNothingElseForThem) {
  // A binary STL may begin with any bytes.
  for (const char* header : {"\xff\xfe", "\xfe\xff", "<", "version "}) {
    std::string bytes = header;
    bytes.resize(80, '\x7f');
    bytes += bytes_of(std::uint32_t{1}) + std::string(12, '\0');
    for (const double x : kTrianglePositions) bytes += bytes_of(static_cast<float>(x));
    EXPECT_TRUE(open({files.write("a.stl", bytes + "ab")})) << header;
  }
  EXPECT_TRUE(open({files.write("a.obj", "# <html>\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")}));
}

}  // namespace
}  // namespace foldproof::testing
