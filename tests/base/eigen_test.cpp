#include "foldproof/eigen.h"

#include <gmock/gmock.h>

namespace foldproof {
namespace {

using testing::ElementsAre;

TEST(Eigen, VectorsConvertBothWays) {
  const Vec3 v(1, -2.5, 1e-300);
  EXPECT_EQ(to_eigen(v), Eigen::Vector3d(1, -2.5, 1e-300));
  EXPECT_EQ(to_vec3(to_eigen(v)), v);
  EXPECT_EQ(to_vec3(2 * to_eigen(v)), 2 * v) << "an expression";
  EXPECT_EQ(to_vec3(Eigen::RowVector3d(1, 2, 3)), Vec3(1, 2, 3)) << "a row";
  EXPECT_EQ(to_vec3(Eigen::Matrix3d::Identity().col(1)), Vec3(0, 1, 0)) << "a column";
}

TEST(Eigen, RowMajorPositionsAreReadInPlaceAndOthersCopied) {
  PositionMatrix rows(2, 3);
  rows << 1, 2, 3, 4, 5, 6;
  const std::span<const double> in_place = positions_of(rows);
  EXPECT_EQ(in_place.data(), rows.data());
  EXPECT_THAT(in_place, ElementsAre(1, 2, 3, 4, 5, 6));
  const Eigen::MatrixXd columns = rows;
  const std::vector<double> copied = positions_of(columns);
  EXPECT_THAT(copied, ElementsAre(1, 2, 3, 4, 5, 6));
  EXPECT_THAT(positions_of(columns.bottomRows(1)), ElementsAre(4, 5, 6));
  EXPECT_EQ(as_rows(copied), rows);
  EXPECT_EQ(as_rows(copied).data(), copied.data());
  EXPECT_THAT(positions_of(PositionMatrix()), testing::IsEmpty());
}

TEST(Eigen, RowsOfIds) {
  Eigen::MatrixXi faces(2, 3);
  faces << 0, 1, 2, 3, 4, 5;
  EXPECT_THAT(ids_of<3>(faces), ElementsAre(ElementsAre(0, 1, 2), ElementsAre(3, 4, 5)));
  EXPECT_THAT(ids_of<2>(faces.leftCols(2)), ElementsAre(ElementsAre(0, 1), ElementsAre(3, 4)));
}

}  // namespace
}  // namespace foldproof
