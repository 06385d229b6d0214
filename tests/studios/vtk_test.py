"""Reads the output of `foldproof check --vtk` with VTK's own reader.

Run as: vtk_test.py PROGRAM. Exit code 77, which ctest calls skipped, without VTK.
"""

import json
import pathlib
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree

try:
    import numpy as np
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkIOXML import vtkXMLPolyDataReader
except ImportError as error:
    print(f"skipped: {error}; Debian's package python3-vtk9 has VTK's reader")
    sys.exit(77)

PROGRAM = None


def sheet(cells):
    """A square of cells x cells x 2 triangles: vertices (n x 3, at z = 0) and triangles."""
    side = cells + 1
    corners = np.stack(np.meshgrid(np.arange(side), np.arange(side)), axis=-1).reshape(-1, 2) / cells
    first = (np.arange(cells)[:, None] * side + np.arange(cells)).ravel()
    triangles = np.concatenate(
        [np.stack([first, first + 1, first + side], 1), np.stack([first + 1, first + side + 1, first + side], 1)]
    )
    return np.column_stack([corners, np.zeros(len(corners))]), triangles


def motion_of(offsets, tilt):
    """Generated: a sheet with bumps in it, tilted, and lifted by each of the offsets in turn."""
    x, triangles = sheet(6)
    x[:, 2] = 0.1 * np.sin(5 * x[:, 0]) * np.cos(4 * x[:, 1]) + tilt * x[:, 0]
    return triangles, np.stack([x + [0.013 * k, 0.007 * k, z] for k, z in enumerate(offsets)])


def faces_of(pairs, triangles_of):
    """Per object, the triangles that collide by a JSON report, including those around colliding vertices and edges."""
    marks = [np.zeros(len(triangles), bool) for triangles in triangles_of]
    for vertex_object, vertex, face_object, face, _ in pairs["vf"]:
        marks[vertex_object] |= (triangles_of[vertex_object] == vertex).any(1)
        marks[face_object][face] = True
    for object_a, a0, a1, object_b, b0, b1, _ in pairs["ee"]:
        for which, ends in ((object_a, (a0, a1)), (object_b, (b0, b1))):
            marks[which] |= np.isin(triangles_of[which], ends).sum(1) == 2
    for object_a, a, object_b, b in pairs.get("tt", []):
        marks[object_a][a] = marks[object_b][b] = True
    return np.concatenate(marks)


def read(path):
    reader = vtkXMLPolyDataReader()
    reader.SetFileName(str(path))
    reader.Update()
    assert reader.GetErrorCode() == 0, path
    return reader.GetOutput()


def arrays_of(attributes):
    return {
        attributes.GetArrayName(i): vtk_to_numpy(attributes.GetArray(i)) for i in range(attributes.GetNumberOfArrays())
    }


class Vtk(unittest.TestCase):
    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.directory = pathlib.Path(holder.name)
        self.motions = [motion_of([0, 0.05, 0.1, 0.15], 0), motion_of([0.5, 0.3, 0.02, -0.04], 0.31)]
        for name, (triangles, frames) in zip("ab", self.motions):
            np.savez(self.directory / f"{name}.npz", faces=triangles, vertices=frames)

    def check(self, *options):
        """The report, the times of the steps, and the meshes that VTK reads."""
        command = [PROGRAM, "check", "a.npz", "b.npz", "--json", "j.json", "--pairs", "--vtk", "out & more.pvd"]
        done = subprocess.run([*command, *options], cwd=self.directory, capture_output=True, text=True)
        self.assertEqual(done.returncode, 1, done.stderr)
        collection = xml.etree.ElementTree.parse(self.directory / "out & more.pvd")
        sets = collection.findall("./Collection/DataSet")
        report = json.loads((self.directory / "j.json").read_text())
        times = [float(entry.get("timestep")) for entry in sets]
        return report, times, [read(self.directory / entry.get("file")) for entry in sets]

    def expect_meshes(self, meshes, starts, ends):
        vertices = len(self.motions[0][1][0])
        for mesh, x0, x1 in zip(meshes, starts, ends):
            np.testing.assert_array_equal(vtk_to_numpy(mesh.GetPoints().GetData()), x0)
            points = arrays_of(mesh.GetPointData())
            np.testing.assert_array_equal(points["displacement"], x1 - x0)
            np.testing.assert_array_equal(points["object"], np.repeat([0, 1], vertices))
            triangles = vtk_to_numpy(mesh.GetPolys().GetConnectivityArray()).reshape(-1, 3)
            np.testing.assert_array_equal(
                triangles, np.concatenate([self.motions[0][0], self.motions[1][0] + vertices])
            )

    def expect_answers(self, report, meshes):
        triangles_of = [triangles for triangles, _ in self.motions]
        for step, mesh in zip(report["steps"], meshes, strict=True):
            cells = arrays_of(mesh.GetCellData())
            pairs = {**step["pairs"], "tt": []}
            np.testing.assert_array_equal(cells["meets"], faces_of(pairs, triangles_of))
            field = arrays_of(mesh.GetFieldData())
            self.assertEqual(field["frame"][0], step["frame"])
            self.assertEqual(field["substep"][0], step["substep"])
            self.assertEqual(field["collisions"][0], sum(step["collisions"].values()))
            self.assertEqual(field["earliest_toi"][0], step["earliest_toi"])

    def frames(self):
        return np.concatenate([frames for _, frames in self.motions], axis=1)

    def test_steps(self):
        report, times, meshes = self.check()
        self.assertEqual(times, [0, 1, 2, 3])
        *meshes, last = meshes
        marked = [arrays_of(mesh.GetCellData())["meets"].sum() for mesh in meshes]
        self.assertEqual(marked[0], 0)
        self.assertTrue(0 < marked[2] < 144, marked)
        self.expect_meshes(meshes, self.frames()[:-1], self.frames()[1:])
        self.expect_answers(report, meshes)
        self.expect_meshes([last], self.frames()[-1:], self.frames()[-1:])
        self.assertEqual(arrays_of(last.GetCellData())["meets"].sum(), 0)
        for mesh, each in zip([*meshes, last], [report["start"], *report["steps"]], strict=True):
            inside = np.zeros(144, np.uint8)
            for triangles, offset in zip(each["inside"], (0, 72)):
                inside[np.array(triangles, int) + offset] = 1
            np.testing.assert_array_equal(arrays_of(mesh.GetCellData())["collides"], inside)
        self.assertEqual(arrays_of(last.GetFieldData())["earliest_toi"][0], 1)

    def test_parts_of_steps_and_ranges(self):
        report, times, meshes = self.check("--frames", "1::2", "--substeps", "4")
        self.assertEqual(times, [1, 1.5, 2, 2.5, 3])
        np.testing.assert_array_equal(vtk_to_numpy(meshes[0].GetPoints().GetData()), self.frames()[1])
        middle = (self.frames()[1] + self.frames()[3]) / 2
        np.testing.assert_allclose(vtk_to_numpy(meshes[2].GetPoints().GetData()), middle, rtol=0, atol=1e-15)
        self.expect_answers(report, meshes[:-1])

    def test_poses(self):
        report, times, meshes = self.check("--static")
        self.assertEqual(times, [0, 1, 2, 3])
        self.expect_meshes(meshes, self.frames(), self.frames())
        self.expect_answers(report, meshes)

    def test_what_crosses_in_the_first_frame(self):
        """From frame 2 on the sheets intersect."""
        report, _, meshes = self.check()
        self.assertFalse(any(arrays_of(mesh.GetCellData())["collides"].any() for mesh in meshes[:2]))
        report, times, meshes = self.check("--frames", "3")
        self.assertEqual(times, [3])
        crosses = arrays_of(meshes[0].GetCellData())["collides"]
        pairs = {"vf": [], "ee": [], "tt": report["start"]["pairs"]["tt"]}
        crossing = faces_of(pairs, [triangles for triangles, _ in self.motions])
        self.assertTrue(np.all(crosses[crossing != 0] == 1))
        self.assertTrue(0 < crosses.sum() < 144)
        contact = arrays_of(meshes[0].GetCellData())["contact"]
        self.assertTrue(np.all(contact[crosses != 0] > 0))
        self.assertEqual(set(contact) - {0}, {c["number"] for c in report["contacts"]})
        report, _, meshes = self.check("--steps-only")
        self.assertFalse(any(arrays_of(mesh.GetCellData())["collides"].any() for mesh in meshes))
        self.assertNotIn("contact", arrays_of(meshes[0].GetCellData()))


if __name__ == "__main__":
    PROGRAM = sys.argv.pop(1)
    unittest.main()
