// Every text format with the ends of lines that Windows writes.
#include "io/support.h"

namespace foldproof::testing {
namespace {

struct Text {
  std::string name, text;
};

const std::vector<Text>& texts() {
  static const std::vector<Text> all{
      {"a.obj",
       "# a \\\ncomment\no square\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 \\\n0\nusemtl cloth\nf 1 2 3\nf 2 4 3\n"},
      {"a.off", "OFF\n# squares\n4 2 0\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n3 0 1 2\n3 1 3 2\n"},
      {"a.ply",
       "ply\nformat ascii 1.0\ncomment squares\nelement vertex 4\nproperty float x\nproperty float y\n"
       "property float z\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n"
       "0 0 0\n1 0 0\n0 1 0\n1 1 0\n3 0 1 2\n3 1 3 2\n"},
      {"a.stl",
       "solid a square\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
       "endloop\nendfacet\nfacet normal 0 0 1\nouter loop\nvertex 1 0 0\nvertex 1 1 0\nvertex 0 1 0\n"
       "endloop\nendfacet\nendsolid a square\n"},
      {"a.msh",
       "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n2 1 \"cloth\"\n$EndPhysicalNames\n"
       "$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 1 1 0\n$EndNodes\n$Elements\n2\n"
       "1 2 2 1 1 1 2 3\n2 2 2 1 1 2 4 3\n$EndElements\n"},
      {"a.vtk",
       "# vtk DataFile Version 3.0\na square\nASCII\nDATASET POLYDATA\nPOINTS 4 float\n0 0 0 1 0 0\n"
       "0 1 0 1 1 0\nPOLYGONS 2 8\n3 0 1 2\n3 1 3 2\n"},
      {"a.vtp",
       "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\">\n<PolyData>\n"
       "<Piece NumberOfPoints=\"4\" NumberOfPolys=\"2\">\n<Points>\n"
       "<DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n"
       "</DataArray>\n</Points>\n<Polys>\n<DataArray type=\"Int32\" Name=\"connectivity\" format=\"ascii\">\n"
       "0 1 2\n1 3 2\n</DataArray>\n<DataArray type=\"Int32\" Name=\"offsets\" format=\"ascii\">\n3\n6\n"
       "</DataArray>\n</Polys>\n</Piece>\n</PolyData>\n</VTKFile>\n"},
      {"a.vtu",
       "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\">\n<UnstructuredGrid>\n"
       "<Piece NumberOfPoints=\"4\" NumberOfCells=\"2\">\n<Points>\n"
       "<DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n"
       "</DataArray>\n</Points>\n<Cells>\n<DataArray type=\"Int32\" Name=\"connectivity\" format=\"ascii\">\n"
       "0 1 2\n1 3 2\n</DataArray>\n<DataArray type=\"Int32\" Name=\"offsets\" format=\"ascii\">\n3\n6\n"
       "</DataArray>\n<DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">\n5\n5\n</DataArray>\n"
       "</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n"},
      {"a.gltf",
       "{\"asset\": {\"version\": \"2.0\"},\n\"scenes\": [{\"nodes\": [0]}], \"scene\": 0,\n"
       "\"nodes\": [{\"mesh\": 0}],\n\"meshes\": [{\"primitives\": [{\"attributes\": {\"POSITION\": 0}}]}],\n"
       "\"accessors\": [{\"bufferView\": 0, \"componentType\": 5126, \"count\": 3, \"type\": \"VEC3\",\n"
       "\"min\": [0, 0, 0], \"max\": [1, 1, 0]}],\n\"bufferViews\": [{\"buffer\": 0, \"byteLength\": 36}],\n"
       "\"buffers\": [{\"byteLength\": 36, \"uri\": \"a.bin\"}]}\n"},
      {"a.pvd",
       "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\">\n<Collection>\n"
       "<DataSet timestep=\"0\" file=\"a.vtp\"/>\n<DataSet timestep=\"1\" file=\"a.vtp\"/>\n</Collection>\n"
       "</VTKFile>\n"}};
  return all;
}

std::string with_returns(const std::string& text) {
  std::string changed;
  for (const char c : text) changed += c == '\n' ? std::string("\r\n") : std::string(1, c);
  return changed;
}

using LineEndsTest = IoTest;

TEST_F(LineEndsTest, OfWindowsChangeNothing) {
  for (const char* folder : {"here/", "there/"}) {
    std::string positions;
    for (const double x : kTrianglePositions) positions += bytes_of(static_cast<float>(x));
    files.write(folder + std::string("a.bin"), positions);
    for (const auto& [name, text] : texts())
      files.write(folder + name, folder[0] == 'h' ? text : with_returns(text));
  }
  for (const auto& [name, text] : texts()) {
    SCOPED_TRACE(name);
    const auto here = open({files.path("here/" + name)}), there = open({files.path("there/" + name)});
    ASSERT_TRUE(here && there);
    ASSERT_EQ(here->topology().face_count(), name == "a.gltf" ? 1 : 2);
    EXPECT_EQ(triangles(*here), triangles(*there));
    EXPECT_EQ(here->frame_count(), there->frame_count());
    EXPECT_EQ(frame(*here, here->frame_count() - 1), frame(*there, there->frame_count() - 1));
    EXPECT_EQ(here->info().notes, there->info().notes);
    EXPECT_EQ(here->info().parts.names, there->info().parts.names);
  }
}

}  // namespace
}  // namespace foldproof::testing
