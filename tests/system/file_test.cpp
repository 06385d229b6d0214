#include "system/file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <fstream>

#include "system/program.h"

namespace foldproof::system {
namespace {

namespace fs = std::filesystem;
using testing::IsEmpty, testing::UnorderedElementsAre;

/// A directory of its own, whose name is not ASCII.
class Files : public testing::Test {
 protected:
  Files() : directory_(fs::temp_directory_path() / fs::path(u8"foldproof-Größe-\u4e2d" + number())) {
    fs::create_directories(directory_);
  }
  ~Files() override {
    std::error_code ignored;
    fs::remove_all(directory_, ignored);
  }

  fs::path make(const fs::path& name, std::string_view text = "") {
    const fs::path path = directory_ / name;
    fs::create_directories(path.parent_path());
    std::ofstream(path, std::ios::binary) << text;
    return path;
  }

  /// What a pattern matches, relative to the directory.
  std::vector<std::string> matching(const std::string& pattern, ListError* error = nullptr) {
    std::vector<std::string> names;
    for (const std::string& path : glob((directory_ / pattern).generic_string(), error))
      names.push_back(fs::path(path).lexically_relative(directory_).generic_string());
    return names;
  }

  static std::u8string number() {
    const std::string text = std::to_string(process_number());
    return {text.begin(), text.end()};
  }

  fs::path directory_;
  std::error_code code_;
};

std::string read_all(const File& file) {
  std::array<char, 100> bytes{};
  std::error_code code;
  return {bytes.data(), file.read_at(0, bytes, code)};
}

TEST_F(Files, ReadAtAnyOffset) {
  const File file = File::open(make("a", "0123456789"), File::Mode::Read, code_);
  ASSERT_TRUE(file);
  std::array<char, 4> bytes{};
  EXPECT_EQ(file.read_at(8, bytes, code_), 2);
  EXPECT_FALSE(code_);
  EXPECT_EQ(file.read_at(10, bytes, code_), 0);
  EXPECT_FALSE(code_);
  EXPECT_EQ(file.read_at(3, bytes, code_), 4);
  EXPECT_EQ(std::string_view(bytes.data(), 4), "3456");
}

TEST_F(Files, SayWhatIsWrong) {
  EXPECT_FALSE(File::open(directory_ / "none", File::Mode::Read, code_));
  EXPECT_EQ(code_, std::errc::no_such_file_or_directory);
  EXPECT_FALSE(File::open(make("a"), File::Mode::Create, code_));
  EXPECT_EQ(code_, std::errc::file_exists);
}

TEST_F(Files, HaveAStatus) {
  const fs::path path = make("a", "12345");
  const auto status = status_of(path), other = status_of(make("b"));
  ASSERT_TRUE(status && other);
  EXPECT_EQ(status->kind, FileKind::File);
  EXPECT_EQ(status->size, 5);
  EXPECT_NE(status->id, other->id);
  EXPECT_EQ(File::open(path, File::Mode::Read, code_).status()->id, status->id);
  EXPECT_EQ(status_of(directory_)->kind, FileKind::Directory);
  EXPECT_FALSE(status_of(directory_ / "none"));
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  const double seconds =
      std::chrono::duration<double>(now).count() - static_cast<double>(status->modified) * 1e-9;
  EXPECT_LT(std::abs(seconds), 60);
}

TEST_F(Files, WriteAtTheEndAndElsewhere) {
  const fs::path path = directory_ / "a";
  File file = File::open(path, File::Mode::Create, code_);
  ASSERT_TRUE(file);
  EXPECT_FALSE(file.write(std::string_view("hello")));
  EXPECT_FALSE(file.write_at(1, std::string_view("a")));
  EXPECT_FALSE(file.write(std::string_view(" world")));
  EXPECT_FALSE(file.close());
  EXPECT_EQ(read_all(File::open(path, File::Mode::Read, code_)), "hallo world");
}

TEST_F(Files, Append) {
  const fs::path path = make("a", "1\n");
  File file = File::open(path, File::Mode::Append, code_);
  ASSERT_TRUE(file);
  EXPECT_EQ(read_all(file), "1\n");
  EXPECT_FALSE(file.write(std::string_view("2\r\n")));
  EXPECT_EQ(read_all(file), "1\n2\r\n");
  EXPECT_FALSE(file.truncate(1));
  EXPECT_EQ(read_all(file), "1");
  EXPECT_TRUE(File::open(directory_ / "b", File::Mode::Append, code_));
}

TEST_F(Files, LockUntilClosed) {
  const fs::path path = make("a", "text");
  File first = File::open(path, File::Mode::Append, code_),
       second = File::open(path, File::Mode::Append, code_);
  EXPECT_TRUE(first.lock());
  EXPECT_FALSE(second.lock());
  EXPECT_EQ(read_all(second), "text");
  first = {};
  EXPECT_TRUE(second.lock());
}

TEST_F(Files, TemporaryHasNoNeighbors) {
  File a = File::temporary(code_), b = File::temporary(code_);
  ASSERT_TRUE(a && b);
  EXPECT_FALSE(a.write(std::string_view("a")));
  EXPECT_FALSE(b.write(std::string_view("b")));
  EXPECT_EQ(read_all(a) + read_all(b), "ab");
}

TEST_F(Files, MatchPatterns) {
  for (const char* name : {"f1.obj", "f2.obj", "f10.obj", ".f3.obj", "sub/f1.obj", "sub2/f1.ply"}) make(name);
  EXPECT_THAT(matching("*.obj"), UnorderedElementsAre("f1.obj", "f2.obj", "f10.obj"));
  EXPECT_THAT(matching("f?.obj"), UnorderedElementsAre("f1.obj", "f2.obj"));
  EXPECT_THAT(matching("f[2-9].obj"), UnorderedElementsAre("f2.obj"));
  EXPECT_THAT(matching("f[!2-9].obj"), UnorderedElementsAre("f1.obj"));
  EXPECT_THAT(matching("*/*.obj"), UnorderedElementsAre("sub/f1.obj"));
  EXPECT_THAT(matching("sub*/f1.*"), UnorderedElementsAre("sub/f1.obj", "sub2/f1.ply"));
  EXPECT_THAT(matching(".f*"), UnorderedElementsAre(".f3.obj"));
  EXPECT_THAT(matching("*.stl"), IsEmpty());
  ListError error;
  EXPECT_THAT(matching("none/*.obj", &error), IsEmpty());
  EXPECT_FALSE(error.code);
}

TEST(Names, MatchAsFilesDo) {
  EXPECT_TRUE(matches("/a/*.obj", "/a/b.obj"));
  EXPECT_FALSE(matches("/a/*.obj", "/a/b/c.obj"));
  EXPECT_FALSE(matches("/a/*.obj", "/a/.b.obj"));
  EXPECT_TRUE(matches("/*/b[0-9]?.obj", "/a/b12.obj"));
  EXPECT_FALSE(matches("/a/b.obj", "/a/bbobj"));
}

TEST(Names, AreUtf8) {
  for (const auto* text : {u8"Größe/中.obj", u8"a\U0001f9e6b", u8"\uffff"}) {
    const std::u8string wanted(text);
    const std::string narrow(wanted.begin(), wanted.end());
    EXPECT_EQ(fs::path(narrow), fs::path(wanted));
    EXPECT_EQ(fs::path(narrow).generic_string(), narrow);
  }
  for (const char* invalid : {"a\xff", "\xe4\xb8", "\xed\xa0\x80"}) EXPECT_FALSE(fs::path(invalid).empty());
}

TEST(Names, SeparatorsAreThoseOfPaths) {
  EXPECT_NE(separators().find('/'), std::string_view::npos);
  EXPECT_NE(separators().find(static_cast<char>(fs::path::preferred_separator)), std::string_view::npos);
}

TEST_F(Files, MayBeWritten) {
  EXPECT_TRUE(may_write(directory_));
  EXPECT_TRUE(may_write(make("a")));
  EXPECT_FALSE(may_write(directory_ / "none"));
}

TEST(Program, ThreadsWork) {
  int done = 0;
  thread_without_signals([&] { done = 1; }).join();
  EXPECT_EQ(done, 1);
}

}  // namespace
}  // namespace foldproof::system
