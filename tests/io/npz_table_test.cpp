#include "io/npz_table.h"

#include <gtest/gtest.h>
#include <zip.h>

#include <filesystem>

#include "io/npy.h"
#include "io/support.h"

namespace foldproof::io {
namespace {

using namespace foldproof::testing;

/// A member of an archive, header and data; reading it to its end checks its sum as well.
std::string member(const std::string& path, const char* name) {
  zip_t* archive = zip_open(path.c_str(), ZIP_RDONLY | ZIP_CHECKCONS, nullptr);
  EXPECT_NE(archive, nullptr) << path;
  if (archive == nullptr) return {};
  std::string bytes;
  if (zip_file_t* file = zip_fopen(archive, name, 0); file != nullptr) {
    char block[100];
    zip_int64_t count = 0;
    while ((count = zip_fread(file, block, sizeof block)) > 0) bytes.append(block, count);
    EXPECT_EQ(count, 0) << name;
    zip_fclose(file);
  } else {
    ADD_FAILURE() << path << " has no " << name;
  }
  zip_discard(archive);
  return bytes;
}

NpyHeader header_of(const std::string& bytes) {
  auto header = parse_npy_header("test", bytes);
  EXPECT_TRUE(header) << (header ? "" : header.error().line());
  return header ? *header : NpyHeader{};
}

TEST(NpzTable, KeepsColumnsApart) {
  const ScratchDirectory files;
  const std::string path = files.path("a.npz");
  auto table =
      NpzTable::open(path, {{"pair", "|i1", 1, {2}}, {"one", "<u4", 4, {}}, {"more", "|u1", 1, {3}}});
  ASSERT_TRUE(table);
  for (char row = 0; row < 5; ++row) {
    table->add(std::array{row, static_cast<char>(-row)});
    table->add(std::array{static_cast<char>(row + 100), '\0', '\0', '\0'});
    table->add(std::array{'x', 'y', row});
    ASSERT_TRUE(table->end_row());
  }
  EXPECT_FALSE(std::filesystem::exists(path)) << "before commit";
  const char* const names[] = {"a", "long"};
  ASSERT_TRUE(table->commit("names", names));

  const std::string pair = member(path, "pair.npy"), one = member(path, "one.npy"),
                    more = member(path, "more.npy"), text = member(path, "names.npy");
  EXPECT_EQ(header_of(pair).shape, (std::vector<std::uint64_t>{5, 2}));
  EXPECT_EQ(header_of(one).shape, (std::vector<std::uint64_t>{5}));
  EXPECT_EQ(header_of(more).shape, (std::vector<std::uint64_t>{5, 3}));
  EXPECT_EQ(pair.substr(header_of(pair).data), std::string("\0\0\1\xff\2\xfe\3\xfd\4\xfc", 10));
  EXPECT_EQ(one.substr(header_of(one).data), std::string("d\0\0\0e\0\0\0f\0\0\0g\0\0\0h\0\0\0", 20));
  EXPECT_EQ(more.substr(header_of(more).data), std::string("xy\0xy\1xy\2xy\3xy\4", 15));
  EXPECT_NE(text.find("'descr': '<U4'"), text.npos);
  // Python reads (2) as a number, (2,) as a shape.
  EXPECT_NE(text.find("'shape': (2,)"), text.npos);
  const auto wide = [](const std::string& name) {
    std::string bytes;
    for (std::size_t i = 0; i < 4; ++i) bytes += {i < name.size() ? name[i] : '\0', '\0', '\0', '\0'};
    return bytes;
  };
  EXPECT_EQ(text.substr(text.size() - 32), wide("a") + wide("long"));
}

TEST(NpzTable, LeavesNothingUnlessCommitted) {
  const ScratchDirectory files;
  {
    auto table = NpzTable::open(files.path("a.npz"), {{"one", "|u1", 1, {}}});
    ASSERT_TRUE(table);
    table->add(std::array{'x'});
    ASSERT_TRUE(table->end_row());
  }
  EXPECT_TRUE(std::filesystem::is_empty(std::filesystem::path(files.path("a.npz")).parent_path()));
}

}  // namespace
}  // namespace foldproof::io
