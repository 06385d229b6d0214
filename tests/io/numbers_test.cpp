// Tables of numbers: CSV and arrays of an NPZ.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include "io/support.h"

namespace foldproof::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class NumbersTest : public IoTest {
 protected:
  std::string csv_error(std::string_view text) {
    const auto table = read_csv(files.write("a.csv", text));
    return table ? "no error" : shown(table.error());
  }
};

TEST_F(NumbersTest, CsvWithAndWithoutNames) {
  const auto plain = read_csv(files.write("a.csv", "1,2.5,-3e2\n\n# half way\r\n4, +5 ,6\r\n"));
  ASSERT_TRUE(plain) << plain.error().line();
  EXPECT_THAT(plain->shape, ElementsAre(2, 3));
  EXPECT_THAT(plain->values, ElementsAre(1, 2.5, -300, 4, 5, 6));
  EXPECT_THAT(plain->names, IsEmpty());
  const auto named = read_csv(files.write("a.csv", "\xef\xbb\xbf\"frame\",x\n0,0.125"));
  ASSERT_TRUE(named) << named.error().line();
  EXPECT_THAT(named->names, ElementsAre("frame", "x"));
  EXPECT_THAT(named->values, ElementsAre(0, 0.125));
}

TEST_F(NumbersTest, BadCsvIsNamedByItsLine) {
  EXPECT_THAT(csv_error("\n"), HasSubstr("a.csv: holds no numbers; "));
  EXPECT_THAT(csv_error("x,y\n"), HasSubstr("a.csv: holds no numbers; "));
  EXPECT_THAT(csv_error("1,2\n\n3\n"), HasSubstr("a.csv:3: has 1 numbers, and the first line has 2; "));
  EXPECT_THAT(csv_error("1,2\n3,4,\n"), HasSubstr("a.csv:2: has 3 numbers"));
  EXPECT_THAT(csv_error("1,2\n3,\n"), HasSubstr("a.csv:2: '' is not a finite number; "));
  EXPECT_THAT(csv_error("1,2\n3,nan\n"), HasSubstr("'nan' is not a finite number"));
  EXPECT_THAT(csv_error("1,2\n3,1e999\n"), HasSubstr("'1e999' is not a finite number"));
  EXPECT_THAT(csv_error(std::string("1,2\n3,\x01\n")), HasSubstr("'?' is not a finite number"));
  EXPECT_FALSE(read_csv(files.path("missing.csv")));
}

TEST_F(NumbersTest, ALineWithANumberHoldsNoNames) {
  for (const char* first : {"nan,0.5", "1e999,0.5", "-INF,0.5", "x,0.5", ",0.5", "1;2,0.5", "NaN,nan",
                            "1e999,-1e999", "inf,Infinity", "-nan(ind),-1.#IND", "1.#QNAN,1.#INF"}) {
    EXPECT_THAT(csv_error(fmt::format("{}\n3,4\n", first)), HasSubstr("a.csv:1: ")) << first;
  }
  const auto named = read_csv(files.write("a.csv", "nano,information\n3,1e-999\n"));
  ASSERT_TRUE(named) << named.error().line();
  EXPECT_THAT(named->names, ElementsAre("nano", "information"));
  EXPECT_THAT(named->values, ElementsAre(3, 0));
}

/// Else a frame would vanish.
TEST_F(NumbersTest, ARowOfMissingNumbersIsNeitherACommentNorNames) {
  for (const char* row :
       {",,", "null,NULL,None", "N/A,n/a,NA", "nan,nil,<NA>", "-,--,?", "p0,,p2", "p0,#N/A,p2",
        "#N/A,#NUM!,#VALUE!", "#DIV/0!,1,2", "#REF!,1,2", "#NAME?,1,2", "#NULL!,1,2"}) {
    EXPECT_THAT(csv_error(fmt::format("{}\n1,2,3\n", row)), HasSubstr("a.csv:1: '")) << row;
    EXPECT_THAT(csv_error(fmt::format("1,2,3\n{}\n", row)), HasSubstr("a.csv:2: '")) << row;
  }
  EXPECT_THAT(csv_error("p,q,p\n1,2,3\n"),
              HasSubstr("a.csv:1: names two columns alike; give each its own name"));
  const auto named = read_csv(files.write("a.csv", "#Names of nulls:\nnullity,m\xc3\xa4r,\xc3\xa4\n1,2,3\n"));
  ASSERT_TRUE(named) << named.error().line();
  EXPECT_EQ(named->names.size(), 3u);
}

TEST_F(NumbersTest, AnArrayOfAnNpz) {
  const auto motion = memory_motion("a", *Topology::make(3, kOneTriangle), {kTrianglePositions});
  const std::string path = files.path("a.npz");
  ASSERT_TRUE(write_npz(path, *motion));
  const auto table = read_npz_numbers(path, "vertices");
  ASSERT_TRUE(table) << table.error().line();
  EXPECT_THAT(table->shape, ElementsAre(1, 3, 3));
  EXPECT_EQ(table->values, kTrianglePositions);
  EXPECT_EQ(npz_has_array(path, "vertices"), true);
  EXPECT_EQ(npz_has_array(path, "keypoints"), false);
  const auto faces = read_npz_numbers(path, "faces"), none = read_npz_numbers(path, "keypoints");
  ASSERT_FALSE(faces);
  ASSERT_FALSE(none);
  EXPECT_THAT(shown(faces.error()), HasSubstr("a.npz, array 'faces': is not float32 or float64; "));
  EXPECT_THAT(shown(none.error()), HasSubstr("a.npz: holds no array 'keypoints'; "));
  EXPECT_FALSE(npz_has_array(files.write("b.npz", "no archive"), "vertices"));
}

TEST_F(NumbersTest, APoseAsObjReadsBack) {
  const auto topology = *Topology::make(3, kOneTriangle);
  ASSERT_TRUE(write_obj(files.path("a.obj"), topology, kTrianglePositions));
  const auto motion = open({files.path("a.obj")});
  EXPECT_EQ(motion->topology(), topology);
  EXPECT_EQ(frame(*motion, 0), kTrianglePositions);
  EXPECT_FALSE(write_obj(files.path("b.obj"), topology, std::vector<double>(6)));
}

}  // namespace
}  // namespace foldproof::testing
