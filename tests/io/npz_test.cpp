#include "io/npz_builder.h"

namespace foldproof::testing {
namespace {

const std::vector<double> kFrames{1, 2, 3, 4, 5, 6, 7, 8, 9, -1, -2, -3, -4, -5, -6, -7, -8, -9};
const std::string kFaces = npy("<i4", "1, 3", array<std::int32_t>({0, 1, 2}));
const std::string kVertices = npy("<f8", "2, 3, 3", array(kFrames));

class NpzTest : public IoTest {
 protected:
  std::string npz(const std::vector<std::pair<std::string, std::string>>& members, bool packed = false) {
    return write_archive(files.path("a.npz"), members, packed);
  }
  std::string npz_of(const std::string& faces, const std::string& vertices, bool packed = false) {
    return npz({{"faces.npy", faces}, {"vertices.npy", vertices}}, packed);
  }
  std::string npz_error(const std::string& faces, const std::string& vertices) {
    return open_error({npz_of(faces, vertices)});
  }
};

TEST_F(NpzTest, ReadsStoredAndPackedFramesInAnyOrder) {
  for (const bool packed : {false, true}) {
    SCOPED_TRACE(packed);
    const auto motion = open({npz_of(kFaces, kVertices, packed)});
    ASSERT_TRUE(motion);
    EXPECT_EQ(motion->frame_count(), 2u);
    EXPECT_EQ(triangles(*motion), kOneTriangle);
    EXPECT_EQ(frame(*motion, 1), (std::vector<double>{-1, -2, -3, -4, -5, -6, -7, -8, -9}));
    EXPECT_EQ(frame(*motion, 0), (std::vector<double>{1, 2, 3, 4, 5, 6, 7, 8, 9}));
    EXPECT_EQ(frame(*motion, 1)[0], -1);
  }
}

TEST_F(NpzTest, ReadsEveryTypeOrderAndHeaderVersion) {
  const auto big = std::endian::big;
  for (const auto& [faces, vertices] : std::vector<std::pair<std::string, std::string>>{
           {npy("|u1", "1, 3", array<std::uint8_t>({0, 1, 2})),
            npy(">f8", "1, 3, 3", array(kTrianglePositions, big))},
           {npy("|i1", "1,3", array<std::int8_t>({0, 1, 2})), npy("<f8", "3, 3,", array(kTrianglePositions))},
           {npy(">u2", "1, 3", array<std::uint16_t>({0, 1, 2}, big)),
            npy("<f4", "3, 3", array<float>({0, 0, 0, 1, 0, 0, 0, 1, 0}), 2)},
           {npy("<i2", "1, 3", array<std::int16_t>({0, 1, 2}), 3),
            npy(">f4", "1, 3, 3", array<float>({0, 0, 0, 1, 0, 0, 0, 1, 0}, big))},
           {npy(">i4", "1, 3", array<std::int32_t>({0, 1, 2}, big)),
            npy("=f8", "3, 3", array(kTrianglePositions, std::endian::native))},
           {npy("<u4", "1, 3", array<std::uint32_t>({0, 1, 2})),
            npy("<f8", "3, 3", array(kTrianglePositions))},
           {npy("<i8", "1, 3", array<std::int64_t>({0, 1, 2})),
            npy("<f8", "3, 3", array(kTrianglePositions))},
           {npy(">u8", "1, 3", array<std::uint64_t>({0, 1, 2}, big)),
            npy("<f8", "3, 3", array(kTrianglePositions))},
       }) {
    SCOPED_TRACE(faces + vertices);
    const auto motion = open({npz_of(faces, vertices)});
    ASSERT_TRUE(motion);
    EXPECT_EQ(triangles(*motion), kOneTriangle);
    EXPECT_EQ(motion->frame_count(), 1u);
    EXPECT_EQ(frame(*motion, 0), kTrianglePositions);
  }
}

TEST_F(NpzTest, ReadsArraysUnderTheNamesThatPeopleUse) {
  for (const auto& [faces, vertices] :
       std::vector<std::pair<std::string, std::string>>{{"F", "V"},
                                                        {"faces", "verts"},
                                                        {"triangles", "positions"},
                                                        {"tris", "points"},
                                                        {"cells", "points"},
                                                        {"f", "x"}}) {
    const auto motion = open({npz({{faces + ".npy", kFaces}, {vertices + ".npy", kVertices}})});
    ASSERT_TRUE(motion) << faces;
    EXPECT_EQ(triangles(*motion), kOneTriangle);
    EXPECT_EQ(motion->frame_count(), 2u);
  }
}

/// A rest pose beside the frames must not be checked in their place.
TEST_F(NpzTest, OfSeveralArraysTheOneWithFramesIsMeant) {
  const std::string rest = npy("<f8", "3, 3", array(kTrianglePositions));
  for (const auto& [pose, frames] : std::vector<std::pair<std::string, std::string>>{
           {"vertices", "positions"}, {"V", "vertices"}, {"v", "x"}, {"x", "v"}}) {
    const auto motion = open({npz({{pose + ".npy", rest}, {frames + ".npy", kVertices}, {"F.npy", kFaces}})});
    ASSERT_TRUE(motion) << pose;
    EXPECT_EQ(motion->frame_count(), 2u) << pose;
  }
  const std::string one = "; save only the one that is meant";
  EXPECT_EQ(open_error({npz({{"v.npy", rest}, {"V.npy", rest}, {"faces.npy", kFaces}})}),
            "a.npz: holds several arrays of vertices: v, V" + one);
  EXPECT_EQ(open_error({npz({{"verts.npy", kVertices}, {"x.npy", kVertices}, {"faces.npy", kFaces}})}),
            "a.npz: holds several arrays of vertices: verts, x" + one);
  EXPECT_EQ(open_error({npz({{"x.npy", kVertices}, {"f.npy", kFaces}, {"faces.npy", kFaces}})}),
            "a.npz: holds several arrays of faces: f, faces" + one);
}

TEST_F(NpzTest, ReadsAPairOfNpyFilesInEitherOrder) {
  const std::string faces = files.write("faces.npy", kFaces), vertices = files.write("x.npy", kVertices);
  for (const auto& arguments : {std::vector{faces, vertices}, std::vector{vertices, faces}}) {
    const auto motion = open(arguments);
    ASSERT_TRUE(motion);
    EXPECT_EQ(motion->name(), vertices);
    EXPECT_EQ(triangles(*motion), kOneTriangle);
    EXPECT_EQ(frame(*motion, 1), (std::vector<double>{-1, -2, -3, -4, -5, -6, -7, -8, -9}));
  }
  EXPECT_EQ(open_error({vertices}),
            "x.npy: is one array; name two .npy files, one after the other: vertices and faces");
  EXPECT_EQ(open_error({faces, faces}),
            "faces.npy: is not float32 or float64; save vertices.astype('float64')");
  EXPECT_EQ(open_error({vertices, vertices}), "x.npy: does not hold integers; save faces.astype('int32')");
  EXPECT_EQ(open_error({faces, files.write("cut.npy", kVertices.substr(0, kVertices.size() - 8))}),
            "cut.npy: its shape does not fit its 136 bytes; save the array with NumPy again");
  EXPECT_EQ(open_error({faces, files.write("nan.npy", "abc")}),
            "nan.npy: is not a NumPy array; save the array with NumPy again");
}

TEST_F(NpzTest, ReportsArrayAndRemedy) {
  const std::string again = "; save the array with NumPy again";
  EXPECT_EQ(
      open_error({npz({{"faces.npy", kFaces}})}),
      "a.npz: holds no array 'vertices'; save arrays named 'faces' and 'vertices'; its arrays are faces.npy");
  EXPECT_EQ(open_error({npz({{"v.npy", kVertices}})}),
            "a.npz: holds no array 'faces'; save arrays named 'faces' and 'vertices'; its arrays are v.npy");
  EXPECT_EQ(open_error({files.write("b.npz", "PK")}),
            "b.npz: is not a whole ZIP archive; copy the file again, or save it with numpy.savez");
  EXPECT_EQ(npz_error("hello", kVertices), "a.npz, array 'faces': is not a NumPy array" + again);
  EXPECT_EQ(npz_error(kFaces.substr(0, 40), kVertices),
            "a.npz, array 'faces': ends within its array header" + again);
  EXPECT_EQ(npz_error(npy("<i4", "1, 3", "", 4), kVertices),
            "a.npz, array 'faces': has an unknown array format version" + again);
  EXPECT_EQ(npz_error(npy("<i4", std::string(5000, ' ') + "1, 3", ""), kVertices),
            "a.npz, array 'faces': has an array header that is too long" + again);
  EXPECT_EQ(npz_error(npy("<i4", "1, x", ""), kVertices),
            "a.npz, array 'faces': has an array header that is not understood" + again);
  EXPECT_EQ(npz_error(npy("<f4", "1, 3", std::string(12, '\0')), kVertices),
            "a.npz, array 'faces': does not hold integers; save faces.astype('int32')");
  EXPECT_EQ(npz_error(npy("<i4", "1, 4", std::string(16, '\0')), kVertices),
            "a.npz, array 'faces': is not of shape triangles x 3; triangulate the faces and reshape them");
  EXPECT_EQ(npz_error(npy("<i4", "0, 3", ""), kVertices),
            "a.npz, array 'faces': is empty; save at least one triangle and one frame");
  EXPECT_EQ(npz_error(kFaces, npy("<f8", "0, 3, 3", "")),
            "a.npz, array 'vertices': is empty; save at least one triangle and one frame");
  EXPECT_EQ(npz_error(kFaces, npy("<f2", "3, 3", std::string(18, '\0'))),
            "a.npz, array 'vertices': is not float32 or float64; save vertices.astype('float64')");
  EXPECT_EQ(npz_error(kFaces, npy("<f8", "9", array(kTrianglePositions))),
            "a.npz, array 'vertices': is not of shape frames x n x 3 (or n x 3); reshape it before saving");
  EXPECT_EQ(npz_error(kFaces, npy("<f8", "2, 3, 3", array(kTrianglePositions))),
            "a.npz, array 'vertices': its shape does not fit its 72 bytes" + again);
  EXPECT_EQ(npz_error(kFaces, npy("<f8", "1, 2, 3", array(kTrianglePositions))),
            "a.npz, array 'vertices': its shape does not fit its 72 bytes" + again);
  EXPECT_EQ(npz_error(kFaces, npy("<f8", "1099511627776, 1099511627776, 3", array(kTrianglePositions))),
            "a.npz, array 'vertices': its shape does not fit its 72 bytes" + again);
  std::string fortran = kVertices;
  fortran.replace(fortran.find("False"), 5, "True ");
  EXPECT_EQ(npz_error(kFaces, fortran),
            "a.npz, array 'vertices': is in Fortran order; save numpy.ascontiguousarray(array)");
  for (const std::int64_t bad :
       {std::int64_t{3}, std::int64_t{-1}, std::int64_t{1} << 32, std::int64_t{-1} << 32}) {
    EXPECT_EQ(
        npz_error(npy("<i8", "2, 3", array<std::int64_t>({0, 1, 2, 0, 1, bad})), kVertices),
        "a.npz, array 'faces', face 1: refers to a vertex that does not exist: there are 3, counting from 0" +
            again);
  }
  auto values = kFrames;
  values[17] = std::numeric_limits<double>::infinity();
  const auto motion = open({npz_of(kFaces, npy("<f8", "2, 3, 3", array(values)))});
  ASSERT_TRUE(motion);
  EXPECT_EQ(frame_error(*motion, 1),
            "a.npz, array 'vertices', frame 1, vertex 2: a coordinate is not finite; "
            "export the mesh without NaN or infinite coordinates");
}

TEST_F(NpzTest, RefusesASizeThatPackedBytesCannotGive) {
  std::string bytes = read_bytes(npz_of(kFaces, kVertices, true));
  // The size of 'vertices' in the directory, the last entry: 24 bytes after its signature.
  const std::size_t entry = bytes.rfind("PK\1\2");
  bytes.replace(entry + 24, 4, bytes_of(std::uint32_t{0xf0000000}));
  const std::string error = open_error({files.write("b.npz", bytes)});
  EXPECT_THAT(
      error, ::testing::HasSubstr("b.npz, array 'vertices': announces 4026531840 bytes, but the file holds"));
  EXPECT_THAT(error, ::testing::EndsWith("packed bytes for it; copy or save the archive again"));
}

std::string many_frames() {
  std::vector<double> values(18000);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<double>(i * i % 977) / 7;
  return npy("<f8", "2000, 3, 3", array(values));
}

TEST_F(NpzTest, ComparesTheChecksumsOfWhatIsReadWhole) {
  std::string bytes = read_bytes(npz_of(kFaces, many_frames()));
  const std::string error = ": its checksum is wrong; save the array with NumPy again";
  const auto motion = open({files.write("b.npz", bytes)});
  for (const Index k : {7u, 1999u, 3u, 1999u}) EXPECT_EQ(frame_error(*motion, k), "no error");
  for (Index k = 0; k < 2000; ++k) ASSERT_EQ(frame_error(*motion, k), "no error") << k;
  for (const Index k : {1999u, 0u}) EXPECT_EQ(frame_error(*motion, k), "no error");

  bytes[bytes.size() / 2] ^= 1;  // the last bit of a number
  const auto damaged = open({files.write("b.npz", bytes)});
  for (Index k = 0; k + 1 < 2000; ++k) ASSERT_EQ(frame_error(*damaged, k), "no error") << k;
  EXPECT_EQ(frame_error(*damaged, 1999), "b.npz, array 'vertices'" + error);

  bytes = read_bytes(npz_of(npy("<i4", "1, 3", array<std::int32_t>({0, 1, 2})), many_frames()));
  bytes[bytes.find(std::string("\2\0\0\0PK", 6))] = 1;
  EXPECT_EQ(open_error({files.write("b.npz", bytes)}), "b.npz, array 'faces'" + error);

  bytes = read_bytes(npz_of(kFaces, many_frames(), true));
  // The checksum of 'vertices' in the directory, the last entry.
  bytes[bytes.rfind("PK\1\2") + 16] ^= 1;
  EXPECT_EQ(open_error({files.write("b.npz", bytes)}), "b.npz, array 'vertices'" + error);
}

TEST_F(NpzTest, NoticesDamagedPackedData) {
  std::string bytes = read_bytes(npz_of(kFaces, many_frames(), true));
  for (std::size_t i = bytes.size() / 2; i < bytes.size() / 2 + 50; ++i)
    bytes[i] = static_cast<char>(~bytes[i]);
  EXPECT_EQ(open_error({files.write("b.npz", bytes)}),
            "b.npz, array 'vertices': the packed data is damaged; save the array with NumPy again");
}

}  // namespace
}  // namespace foldproof::testing
