/// Bodies with known distances, and a motion's contacts.
#pragma once

#include <optional>
#include <vector>

#include "check/animations.h"
#include "foldproof/contacts.h"

namespace foldproof::oracle {

/// A sphere of radius 1 about the origin: an octahedron, each triangle divided into divisions^2.
Mesh unit_sphere(Index divisions);
/// A torus about the z axis: a tube of radius `small` around a circle of radius `large`.
Mesh torus(double large, double small, Index around, Index across);
/// A square with side 2 in the plane z = 0, of 2 size^2 triangles.
Mesh square(Index size);

Mesh scene_mesh(std::vector<Vec3> vertices, std::vector<Triangle> triangles);
/// A box from middle - half to middle + half, each side divided into n^2 squares.
Mesh box(const Vec3& middle, const Vec3& half, int n);

/// The mesh's positions, scaled, then moved.
Pose placed(const Mesh& mesh, double scale, const Vec3& shift);
/// Two meshes as one object.
Mesh together(const Mesh& a, const Mesh& b);

/// Everything that a finder said about an animation, whose frames have the times 0, 1, ...
struct Found {
  std::vector<Contact> contacts;  ///< By number.
  std::vector<StepResult> steps;
  /// Per step: its pairs' contacts, and those of the crossings at its end; resolved, so that contacts that
  /// have joined have one number.
  std::vector<std::vector<Index>> vertex_face, edge_edge;
  std::vector<std::vector<Index>> crossing_contacts;     ///< Per frame.
  std::vector<std::vector<TriangleCrossing>> crossings;  ///< Per frame.
};
Found contacts_of(const Animation& animation, const StepSettings& settings = {});

}  // namespace foldproof::oracle
