// Truncated, inconsistent and corrupted files: an error or a mesh, never a crash.
#include <chrono>

#include "io/gltf_builder.h"
#include "io/memory_limit.h"
#include "io/npz_builder.h"

namespace foldproof::testing {
namespace {

/// A valid file of a format, and its name.
struct Sample {
  std::string name;
  std::string bytes;
  std::string mesh;  ///< The mesh file of a point cache.
  bool text = false;
};

GltfBuilder animated() {
  GltfBuilder b;
  Json& primitive = b.triangle();
  primitive["indices"] = b.accessor<std::uint8_t>("SCALAR", {0, 1, 2});
  primitive["targets"] = {{{"POSITION", b.floats("VEC3", {1, 1, 1, 2, 2, 2, 3, 3, 3})}}};
  primitive["attributes"]["JOINTS_0"] = b.accessor<std::uint8_t>("VEC4", std::vector<std::uint8_t>(12, 0));
  primitive["attributes"]["WEIGHTS_0"] = b.floats("VEC4", std::vector<float>(12, 0.25f));
  b.json["skins"] = {{{"joints", {0}}}};
  b.json["nodes"] = {{{"mesh", 0}, {"skin", 0}}};
  const int times = b.floats("SCALAR", {0, 1});
  b.animate(0, "weights", times, b.floats("SCALAR", {0, 1}));
  b.animate(0, "rotation", times, b.floats("VEC4", {0, 0, 0, 1, 0, 0, 1, 0}));
  return b;
}

std::string binary_stl() {
  std::string bytes(80, ' ');
  bytes += bytes_of(std::uint32_t{1}) + std::string(12, '\0');
  for (const double x : kTrianglePositions) bytes += bytes_of(static_cast<float>(x));
  return bytes + "ab";
}

/// With appended raw arrays.
std::string vtp() {
  std::string xml =
      "<VTKFile type=\"PolyData\"><PolyData><Piece NumberOfPoints=\"3\" NumberOfPolys=\"1\">"
      "<Points><DataArray type=\"Float64\" format=\"appended\" offset=\"0\"/></Points><Polys>"
      "<DataArray type=\"Int32\" Name=\"connectivity\" format=\"appended\" offset=\"76\"/>"
      "<DataArray type=\"Int32\" Name=\"offsets\" format=\"appended\" offset=\"92\"/>"
      "</Polys></Piece></PolyData><AppendedData encoding=\"raw\">_";
  for (const std::string& bytes :
       {array(kTrianglePositions), array<std::int32_t>({0, 1, 2}), array<std::int32_t>({3})})
    xml += bytes_of(static_cast<std::uint32_t>(bytes.size())) + bytes;
  return xml;
}

const char* const kVtu =
    "<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid><Piece NumberOfPoints=\"4\" NumberOfCells=\"1\">"
    "<Points><DataArray type=\"Float32\" format=\"ascii\">0 0 0 1 0 0 0 1 0 0 0 1</DataArray></Points><Cells>"
    "<DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">0 1 2 3</DataArray>"
    "<DataArray type=\"Int64\" Name=\"offsets\" format=\"binary\">CAAAAAQAAAAAAAAA</DataArray>"
    "<DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">10</DataArray>"
    "</Cells></Piece></UnstructuredGrid></VTKFile>";
const char* const kVtk =
    "# vtk DataFile Version 5.1\na\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 float\n0 0 0 1 0 0 0 1 0 0 0 "
    "1\n"
    "CELLS 2 4\nOFFSETS vtktypeint64\n0 4\nCONNECTIVITY vtktypeint64\n0 1 2 3\nCELL_TYPES 1\n10\n"
    "CELL_DATA 1\nFIELD FieldData 1\ngroup 1 1 int\n7\n";

std::string binary_vtk() {
  std::string bytes = "# vtk DataFile Version 3.0\na\nBINARY\nDATASET POLYDATA\nPOINTS 3 double\n";
  for (const double x : kTrianglePositions) bytes += bytes_of(x, std::endian::big);
  bytes += "\nPOLYGONS 1 4\n";
  for (const std::int32_t x : {3, 0, 1, 2}) bytes += bytes_of(x, std::endian::big);
  return bytes;
}

const char* const kMsh =
    "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 3 1 3\n2 1 0 3\n1\n2\n3\n0 0 0\n1 0 0\n0 1 "
    "0\n$EndNodes\n"
    "$Elements\n1 1 1 1\n2 1 2 1\n1 1 2 3\n$EndElements\n";

std::vector<Sample> samples() {
  const ScratchDirectory files;
  const auto topology = Topology::make(4, {{0, 1, 2}, {1, 3, 2}});
  const std::vector<double> still{0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0.5};
  std::vector<double> moved = still;
  for (double& x : moved) x += 3;
  const auto motion = memory_motion("sample", *topology, {still, moved});
  EXPECT_TRUE(write_obj_pc2(files.path("a.obj"), files.path("a.pc2"), *motion));
  EXPECT_TRUE(write_npz(files.path("a.npz"), *motion));
  EXPECT_TRUE(write_ply(files.path("a.ply"), *topology, still, {}));
  const std::string obj = read_bytes(files.path("a.obj"));
  std::string mdd = bytes_of<std::int32_t>(1, std::endian::big) + bytes_of<std::int32_t>(4, std::endian::big);
  mdd += std::string(4 + 48, '\1');
  GltfBuilder b = animated();
  return {{"a.obj", obj, "", true},
          {"a.off", "OFF\n4 2 0\n0 0 0\n1 0 0\n0 1 0\n1 1 0.5\n3 0 1 2\n3 1 3 2\n", "", true},
          {"b.ply",
           "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float "
           "z\nelement face 1\n"
           "property list uchar int vertex_index\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
           "", true},
          {"a.ply", read_bytes(files.path("a.ply")), "", false},
          {"a.pc2", read_bytes(files.path("a.pc2")), obj, false},
          {"a.mdd", mdd, obj, false},
          {"a.stl", binary_stl(), "", false},
          {"b.stl",
           "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\n"
           "endfacet\nendsolid\n",
           "", true},
          {"a.vtp", vtp(), "", false},
          {"a.vtu", kVtu, "", false},
          {"a.vtk", kVtk, "", true},
          {"b.vtk", binary_vtk(), "", false},
          {"a.msh", kMsh, "", true},
          {"a.npy", npy("<f8", "4, 3", array(still)),
           npy("<i4", "2, 3", array<std::int32_t>({0, 1, 2, 1, 3, 2})), false},
          {"a.npz", read_bytes(files.path("a.npz")), "", false},
          {"a.gltf", b.gltf(), "", false},
          {"a.glb", b.glb(), "", false}};
}

class HostileTest : public IoTest {
 protected:
  /// Opens, reads the first and the last frame; the error, if any, is one line that names the file.
  bool survives(const Sample& sample, std::string_view bytes) {
    std::vector<std::string> arguments;
    if (!sample.mesh.empty())
      arguments.push_back(files.write(sample.name == "a.npy" ? "faces.npy" : "mesh.obj", sample.mesh));
    arguments.push_back(files.write(sample.name, bytes));
    const auto motions = open_motions(arguments);
    Result<void> read;
    if (motions) {
      Motion& motion = *motions->front();
      std::vector<double> positions(std::size_t{3} * motion.topology().vertex_count());
      read = motion.read_frame(0, positions);
      if (read) read = motion.read_frame(motion.frame_count() - 1, positions);
      for (const double x : positions) EXPECT_TRUE(!read || std::isfinite(x));
      const ObjectParts& parts = motion.info().parts;
      EXPECT_EQ(parts.of_triangle.size(), parts.names.empty() ? 0 : motion.topology().triangles().size());
      for (const Index part : parts.of_triangle) EXPECT_LT(part, parts.names.size());
    } else {
      read = tl::unexpected(motions.error());
    }
    if (read) return true;
    EXPECT_THAT(read.error().where, ::testing::HasSubstr(sample.name));
    EXPECT_FALSE(read.error().problem.empty());
    EXPECT_FALSE(read.error().remedy.empty());
    EXPECT_EQ(read.error().line().find('\n'), std::string::npos);
    EXPECT_EQ(read.error().problem.find("memory"), std::string::npos) << sample.name << " asks for memory";
    return false;
  }
};

TEST_F(HostileTest, CompleteSamplesAreValid) {
  for (const Sample& sample : samples()) EXPECT_TRUE(survives(sample, sample.bytes)) << sample.name;
}

TEST_F(HostileTest, FilesTruncatedAtAnyLengthAreErrors) {
  for (const Sample& sample : samples()) {
    for (std::size_t length = 0; length < sample.bytes.size(); ++length) {
      const bool good = survives(sample, std::string_view(sample.bytes).substr(0, length));
      // A text may lose the end of its last line, or whole faces, and still be a mesh.
      EXPECT_TRUE(sample.text || !good) << sample.name << " cut to " << length;
    }
  }
}

TEST_F(HostileTest, AnyByteMayBeCorrupt) {
  for (const Sample& sample : samples()) {
    for (std::size_t at = 0; at < sample.bytes.size(); ++at) {
      for (const char corrupt : {'\0', '\xff', '9', '-', static_cast<char>(sample.bytes[at] ^ 1)}) {
        std::string bytes = sample.bytes;
        bytes[at] = corrupt;
        survives(sample, bytes);
      }
    }
  }
}

/// A header that is trusted before it is checked would exceed the limit, whether or not the memory is used.
TEST_F(HostileTest, FalseHeadersUseNoMemory) {
  const auto little = std::endian::little, big = std::endian::big;
  const std::string mesh = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  const std::string ply_end = "\nproperty double x\nproperty double y\nproperty double z\nelement face ";
  const std::string list = "\nproperty list uint int vertex_indices\nend_header\n";
  GltfBuilder sparse;
  Json& primitive = sparse.triangle();
  primitive["targets"] = {{{"POSITION", 1}}};
  sparse.json["accessors"].push_back({{"componentType", 5126}, {"count", 1000000000000}, {"type", "VEC3"}});
  sparse.json["nodes"] = {{{"mesh", 0}}};
  GltfBuilder copies;
  copies.triangle();
  copies.json["accessors"][0]["count"] = 30000;
  copies.json["bufferViews"][0]["byteLength"] = 360000;
  copies.buffer.resize(360000);
  copies.json["nodes"] = Json::array();
  for (int i = 0; i < 10000; ++i) copies.json["nodes"].push_back({{"mesh", 0}});
  copies.json.erase("scene");
  const std::vector<Sample> false_headers{
      {"a.off", "OFF\n4000000000 4000000000 0\n0 0 0\n", "", true},
      {"a.off", "OFF\n9223372036854775807 9223372036854775807 0\n0 0 0\n", "", true},
      {"a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n4000000000 0 1 2\n", "", true},
      {"a.ply", "ply\nformat ascii 1.0\nelement vertex 4000000000" + ply_end + "1" + list, "", true},
      {"a.ply",
       "ply\nformat binary_little_endian 1.0\nelement vertex 9223372036854775807" + ply_end + "1" + list, "",
       true},
      {"a.ply",
       "ply\nformat binary_little_endian 1.0\nelement vertex 0" + ply_end + "4000000000" + list + "abcd", "",
       true},
      {"a.ply",
       "ply\nformat binary_big_endian 1.0\nelement vertex 0" + ply_end + "1" + list + "\xff\xff\xff\xff", "",
       true},
      {"a.stl", std::string(80, ' ') + "\xff\xff\xff\xff", ""},
      {"a.npy", npy("<f8", "1152921504606846976, 3", ""), npy("<i4", "1, 3", array<std::int32_t>({0, 1, 2}))},
      {"a.vtp", vtp().replace(vtp().find("\"3\""), 3, "\"4000000000\""), ""},
      {"a.vtp", vtp().replace(vtp().find('_') + 1, 4, "\xff\xff\xff\xff"), ""},
      {"a.vtk", "# vtk DataFile Version 3.0\na\nBINARY\nDATASET POLYDATA\nPOINTS 4000000000 double\n", ""},
      {"a.vtk",
       "# vtk DataFile Version 3.0\na\nASCII\nFIELD f 1\na 4000000000 4000000000 int\n1 2\nDATASET "
       "POLYDATA\n",
       ""},
      {"a.pc2",
       std::string("POINTCACHE2\0", 12) + bytes_of(1, little) + bytes_of(3) + bytes_of(0.f) + bytes_of(1.f) +
           bytes_of(2147483647),
       mesh},
      {"a.mdd", bytes_of(2147483647, big) + bytes_of(3, big), mesh},
      {"a.gltf", sparse.gltf(), ""},
      {"a.gltf", copies.gltf(), ""},
  };
  const MemoryLimit limit(100'000'000);
  if (!limit.holds()) GTEST_SKIP() << "nothing limits memory here";
  const auto start = std::chrono::steady_clock::now();
  for (const Sample& liar : false_headers)
    EXPECT_FALSE(survives(liar, liar.bytes)) << liar.name << liar.bytes.substr(0, 200);
  const auto seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  EXPECT_LT(seconds, 20);
}

}  // namespace
}  // namespace foldproof::testing
