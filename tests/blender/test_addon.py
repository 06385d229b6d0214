"""The Blender add-on in Blender, without a window. Run as:

blender --background --factory-startup --python-exit-code 1 --python test_addon.py -- FOLDPROOF ADDON.zip DIRECTORY [NAME]

DIRECTORY is empty, for what tests write. The add-on is installed under its own name, or as NAME: Blender 4.2 calls an extension
bl_ext.REPOSITORY.ID.
"""

import addon_utils
import importlib
import json
import os
import pathlib
import shutil
import struct
import subprocess
import sys
import time
import tomllib
import types
import unittest
import unittest.mock

import bmesh
import bpy
import mathutils
import numpy as np

ARGUMENTS = sys.argv[sys.argv.index("--") + 1 :]
PROGRAM, ZIP, WORK = (pathlib.Path(a).resolve() for a in ARGUMENTS[:3])
os.environ["TMPDIR"] = str(WORK)
os.environ["PATH"] = f"{PROGRAM.parent}:{os.environ['PATH']}"
NAME = (ARGUMENTS + ["foldproof_addon"])[3]


def addon(module):
    return sys.modules[f"{NAME}.{module}"]


def new_object(name, vertices, faces):
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(vertices, [], faces)
    made = bpy.data.objects.new(name, mesh)
    bpy.context.collection.objects.link(made)
    made.select_set(True)
    return made


def grid(cells, x0, x1, y0, y1):
    """Squares, row by row along x."""
    xs, ys = np.linspace(x0, x1, cells + 1), np.linspace(y0, y1, cells + 1)
    vertices = [(x, y, 0.0) for y in ys for x in xs]
    side = cells + 1
    faces = [
        (r * side + c, r * side + c + 1, (r + 1) * side + c + 1, (r + 1) * side + c)
        for r in range(cells)
        for c in range(cells)
    ]
    return vertices, faces


def key(animated, path, values, index=-1):
    """Linear between keys."""
    for frame, value in values.items():
        if index < 0:
            setattr(animated, path, value)
        else:
            getattr(animated, path)[index] = value
        animated.keyframe_insert(path, index=index, frame=frame)
    for curve in addon("compatibility").curves_of(animated.id_data):
        for point in curve.keyframe_points:
            point.interpolation = "LINEAR"


def two_planes():
    """A floor of 4 x 4 squares of side 0.5, and a strip of 2 squares that passes through it a quarter of the way from
    frame 6 to 7, over squares 10 and 11 of the floor. The floor stands half a metre up and is twice as large as its
    mesh, so that only world space gives the right answer."""
    vertices, faces = grid(4, -0.5, 0.5, -0.5, 0.5)
    floor = new_object("Floor", vertices, faces)
    floor.location.z = 0.5
    floor.scale = (2, 2, 2)
    strip = new_object(
        "Strip",
        [(0.3, 0.3, 0), (0.45, 0.3, 0), (0.7, 0.3, 0), (0.3, 0.4, 0), (0.45, 0.4, 0), (0.7, 0.4, 0)],
        [(0, 1, 4, 3), (1, 2, 5, 4)],
    )
    key(strip, "location", {1: (0, 0, 1.55), 11: (0, 0, -0.45)})
    return floor, strip


def ball_in_box():
    """A cube of side 2 around the origin, and a ball of radius 0.5 that dips into its top from frame 3 on, is deepest, by
    0.4, at frame 6, and has left at frame 11."""
    cube = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    box = new_object("Box", cube, [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)])
    made = bmesh.new()
    bmesh.ops.create_uvsphere(made, u_segments=24, v_segments=12, radius=0.5)
    ball = new_object("Ball", [], [])
    made.to_mesh(ball.data)
    made.free()
    ball.location = (0.2, 0.1, 0)
    key(ball, "location", {1: 2, 6: 1.1, 11: 2}, index=2)
    return box, ball


def bending_tube():
    """A tube that an armature of two bones folds onto itself: keyed straight at 1, folded at 11."""
    rings, around = 25, 12
    vertices = [
        (0.3 * np.cos(a), 0.3 * np.sin(a), z)
        for z in np.linspace(0, 4, rings)
        for a in np.linspace(0, 2 * np.pi, around, endpoint=False)
    ]
    faces = [
        (r * around + c, r * around + (c + 1) % around, (r + 1) * around + (c + 1) % around, (r + 1) * around + c)
        for r in range(rings - 1)
        for c in range(around)
    ]
    tube = new_object("Tube", vertices, faces)
    armature = bpy.data.armatures.new("Bones")
    bones = bpy.data.objects.new("Bones", armature)
    bpy.context.collection.objects.link(bones)
    bpy.context.view_layer.objects.active = bones
    bpy.ops.object.mode_set(mode="EDIT")
    lower = armature.edit_bones.new("lower")
    lower.head, lower.tail = (0, 0, 0), (0, 0, 2)
    upper = armature.edit_bones.new("upper")
    upper.head, upper.tail, upper.parent = (0, 0, 2), (0, 0, 4), lower
    bpy.ops.object.mode_set(mode="OBJECT")
    for name, weight in (("lower", lambda z: np.clip(1.5 - z / 2, 0, 1)), ("upper", lambda z: np.clip(z / 2 - 0.5, 0, 1))):
        group = tube.vertex_groups.new(name=name)
        for i, (_, _, z) in enumerate(vertices):
            group.add([i], float(weight(z)), "REPLACE")
    tube.modifiers.new("Armature", "ARMATURE").object = bones
    bone = bones.pose.bones["upper"]
    bone.rotation_mode = "XYZ"
    key(bone, "rotation_euler", {1: (0, 0, 0), 11: (np.radians(172), 0, 0)})
    return tube


def program_says(objects, frames):
    """The number of collisions per step that the program finds in world coordinates, computed without the add-on."""
    paths = []
    for made in objects:
        poses = []
        for frame in frames:
            bpy.context.scene.frame_set(frame)
            shown = made.evaluated_get(bpy.context.evaluated_depsgraph_get())
            poses.append([shown.matrix_world @ v.co for v in shown.data.vertices])
        shown.data.calc_loop_triangles()
        paths.append(WORK / f"{made.name}-expected.npz")
        np.savez(paths[-1], faces=[tuple(t.vertices) for t in shown.data.loop_triangles], vertices=np.array(poses))
    report = WORK / "expected.json"
    code = subprocess.run([PROGRAM, "check", *paths, "--quiet", "--json", report]).returncode
    assert code in (0, 1), code
    return [sum(step["collisions"].values()) for step in json.loads(report.read_text())["steps"]]


def stand_in(script):
    """A program that does this instead."""
    path = WORK / "stand-in"
    path.write_text(f"#!/bin/sh\n{script}\n")
    path.chmod(0o755)
    return str(path)


def marked(made):
    return [i for i, each in enumerate(made.data.attributes["foldproof_collides"].data) if each.value]


def meeting(made):
    return [i for i, each in enumerate(made.data.attributes["foldproof_meets"].data) if each.value]


def markers():
    return {m.frame: m.name for m in bpy.context.scene.timeline_markers}


class Addon(unittest.TestCase):
    def setUp(self):
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
        bpy.ops.preferences.addon_enable(module=NAME)
        bpy.context.preferences.addons[NAME].preferences.program = ""
        self.scene = bpy.context.scene
        self.scene.frame_start, self.scene.frame_end = 1, 11
        self.settings = self.scene.foldproof
        self.before = set(WORK.iterdir())

    def expect_nothing_left(self):
        self.assertFalse([p for p in set(WORK.iterdir()) - self.before if p.name.startswith("foldproof-")])
        for mesh in bpy.data.meshes:
            self.assertNotIn("foldproof_origin", mesh.attributes)

    def fails(self, operator, said):
        with self.assertRaisesRegex(RuntimeError, said):
            operator()
        self.assertRegex(self.settings.message, said)
        self.expect_nothing_left()

    def test_marks_the_faces_and_frames_that_collide(self):
        floor, strip = two_planes()
        expected = program_says([floor, strip], range(1, 12))
        self.assertEqual([i + 1 for i, count in enumerate(expected) if count], [6])
        self.scene.timeline_markers.new("mine", frame=3)
        self.scene.frame_set(4)
        self.assertEqual(bpy.ops.foldproof.check(), {"FINISHED"})
        self.assertEqual(self.scene.frame_current, 4)
        self.assertEqual(markers(), {3: "mine", 6: "Foldproof: Floor - Strip"})
        self.assertEqual(self.settings.message, "Floor and Strip meet each other between frames 6 and 7")
        for frame, floor_faces, strip_faces in ((5, [], []), (6, [10, 11], [0, 1]), (7, [], [])):
            self.scene.frame_set(frame)
            self.assertEqual((meeting(floor), meeting(strip)), (floor_faces, strip_faces), frame)
            self.assertEqual((marked(floor), marked(strip)), ([], []), frame)
        self.scene.frame_set(6)
        pink = [c.color[1] < 0.3 < c.color[2] for c in floor.data.color_attributes["foldproof_color"].data]
        self.assertEqual(pink, [face in (10, 11) for face in range(16) for _ in range(4)])
        self.assertEqual(floor.data.color_attributes.active_color.name, "foldproof_color")
        bpy.ops.foldproof.select()
        self.assertEqual([p.index for p in floor.data.polygons if p.select], [10, 11])
        bpy.ops.foldproof.clear()
        self.assertEqual(markers(), {3: "mine"})
        self.assertEqual([a.name for a in floor.data.attributes if a.name.startswith("foldproof")], [])
        self.expect_nothing_left()

    def test_a_vertex_that_meets_a_face_marks_the_faces_around_it(self):
        floor, strip = two_planes()
        bpy.data.objects.remove(strip)
        needle = new_object(
            "Needle", [(0.1, 0.2, 0), (0.1, 0.25, 1), (0.15, 0.2, 1), (0.15, 0.25, 2)], [(0, 1, 2), (1, 3, 2)]
        )
        key(needle, "location", {1: (0, 0, 1.5), 11: (0, 0, 0)})
        self.settings.samples = 4
        bpy.ops.foldproof.check()
        self.assertRegex(self.settings.message, "^Floor and Needle .* in frame ")
        self.scene.frame_set(7)
        self.assertEqual((meeting(floor), meeting(needle)), ([10], [0]))

    def test_edges_that_meet_mark_the_faces_along_them(self):
        floor, strip = two_planes()
        bpy.data.objects.remove(strip)
        # Its lower edge passes through the corner of square 15; its ends pass beside the floor.
        blade = new_object(
            "Blade", [(1.2, 0.7, 0), (0.7, 1.2, 0), (1, 1, 1), (1.2, 1.2, 2), (0.7, 1.2, 2)], [(0, 1, 2), (2, 3, 4)]
        )
        key(blade, "location", {1: (0, 0, 1.5), 11: (0, 0, 0)})
        bpy.ops.foldproof.check()
        self.scene.frame_set(7)
        self.assertEqual((meeting(floor), meeting(blade)), ([15], [0]))

    def test_faces_that_modifiers_make_are_those_of_the_mesh(self):
        floor, strip = two_planes()
        floor.modifiers.new("Finer", "SUBSURF").subdivision_type = "SIMPLE"
        strip.modifiers.new("Mirror", "MIRROR")
        self.assertEqual(bpy.ops.foldproof.check(), {"FINISHED"})
        self.scene.frame_set(6)
        self.assertEqual((meeting(floor), meeting(strip)), ([8, 9, 10, 11], [0, 1]))

    def test_parts_of_frames_thickness_and_poses(self):
        floor, strip = two_planes()
        addon("compatibility").curves_of(strip)[2].keyframe_points[1].co[1] = 0.51  # stops a hundredth above the floor
        self.settings.samples = 3
        bpy.ops.foldproof.check()
        self.assertEqual(markers(), {})
        self.assertEqual(self.settings.message, "No collisions: no triangles cross in frame 1, and all 30 steps are proven free")
        self.settings.thickness = 0.02
        bpy.ops.foldproof.check()
        self.assertEqual(list(markers()), [10])
        self.settings.kind = "POSES"
        bpy.ops.foldproof.check()
        self.assertEqual(markers(), {})
        self.assertEqual(self.settings.message, "No triangles cross in any of 11 frames, proven. What happens between frames was not tested")
        strip.rotation_euler.y = 0.3  # now it stands in the floor at frame 10, and below it at frame 11
        bpy.ops.foldproof.check()
        self.assertEqual(list(markers()), [10])

    def test_what_is_inside_is_red_at_every_frame(self):
        floor, strip = two_planes()
        strip.animation_data_clear()
        strip.location.z, strip.rotation_euler.y = 0.6, 0.3  # it stands in the floor at every frame
        bpy.ops.foldproof.check()
        self.assertRegex(self.settings.message, r"^Floor and Strip go through each other, .* in frame 1$")
        self.assertEqual(list(markers()), [1])
        for frame in (1, 7, 11):
            self.scene.frame_set(frame)
            inside = marked(floor)
            self.assertTrue(inside and set(inside) <= {10, 11}, inside)
            self.assertEqual(meeting(floor), [])
            red = {i // 4 for i, c in enumerate(floor.data.color_attributes["foldproof_color"].data)
                      if c.color[1] < 0.3 and c.color[2] < 0.3}
            self.assertEqual(red, set(inside))
        bpy.ops.foldproof.select()
        self.assertEqual([p.index for p in floor.data.polygons if p.select], inside)

        self.scene.frame_end = 1  # a single frame stands still
        bpy.ops.foldproof.check()
        self.assertRegex(self.settings.message, "^Floor and Strip go through each other, .* in frame 1$")
        self.scene.frame_set(1)
        self.assertEqual(marked(floor), inside)
        strip.location.z = 2
        bpy.ops.foldproof.check()
        self.assertEqual(self.settings.message, "No collisions: no triangles cross in frame 1, proven")
        bpy.ops.foldproof.clear()
        self.assertEqual([a.name for a in floor.data.attributes if a.name.startswith("foldproof")], [])

    def test_vertex_groups_are_parts(self):
        """The group with the most weight in a face; those of no bone do not count where there are bones."""
        tube = bending_tube()
        tube.vertex_groups.new(name="pinned").add(list(range(300)), 1, "REPLACE")
        bpy.ops.foldproof.check()
        self.assertEqual({each.name for each in self.settings.contacts}, {"lower - upper"})
        self.assertRegex(self.settings.message, "^(lower and upper|upper and lower) go through each other")
        self.assertIn("Foldproof: ", " ".join(g.name for g in tube.vertex_groups))
        bpy.ops.foldproof.check()  # the add-on's own groups are no parts
        self.assertEqual({each.name for each in self.settings.contacts}, {"lower - upper"})

    def test_contacts_are_listed_marked_and_shown(self):
        box, ball = ball_in_box()
        mine = ball.vertex_groups.new(name="mine")
        bpy.ops.foldproof.check()
        contact, = self.settings.contacts
        self.assertEqual((contact.name, contact.frames()), ("Ball - Box", "4-8"))
        self.assertEqual(contact.worst, 6)
        self.assertAlmostEqual(contact.depth, 0.4, delta=0.05)
        self.assertEqual(contact.how_bad(self.scene.unit_settings), "40 cm deep")
        self.assertRegex(self.settings.message, "^Ball and Box go through each other, 40 cm at worst, in frame 6$")
        self.assertEqual(markers(), {3: "Foldproof: Ball - Box, begins", 6: "Foldproof: Ball - Box, worst"})
        self.assertEqual([g.name for g in box.vertex_groups], ["Foldproof: Ball - Box"])  # its top crosses
        group = ball.vertex_groups["Foldproof: Ball - Box"]
        self.assertEqual(ball.vertex_groups.active, mine)
        weights = {v.index: g.weight for v in ball.data.vertices for g in v.groups if g.group == group.index}
        below = {v.index for v in ball.data.vertices if v.co.z + 1.1 < 1}
        self.assertEqual({v for v, weight in weights.items() if weight == 1} - below, set())
        self.assertGreater(list(weights.values()).count(1), 12)
        self.assertEqual(below - set(weights), set())

        # What a click does. Without a window no view moves by itself.
        self.scene.frame_set(2)
        self.settings.contact = 0
        self.assertEqual(self.scene.frame_current, 6)
        behind = (-mathutils.Vector(contact.normal)).to_track_quat("Z", "Y")
        view = types.SimpleNamespace(view_perspective="CAMERA", view_rotation=behind)
        addon("contacts").aim(view, contact)
        seen_from = view.view_rotation @ mathutils.Vector((0, 0, 1))
        np.testing.assert_allclose(seen_from, contact.normal, atol=1e-3)
        self.assertGreater(abs(contact.normal[2]), 0.9)
        aslant = view.view_rotation = mathutils.Quaternion((1, 0, 0), 0.5) @ view.view_rotation
        addon("contacts").aim(view, contact)
        self.assertEqual(view.view_rotation, aslant)
        shading = types.SimpleNamespace(type="SOLID", color_type="MATERIAL")
        for marks, expected in ((True, "VERTEX"), (False, "MATERIAL")):
            addon("marks").color(shading, marks)
            self.assertEqual(shading.color_type, expected)
        shading.color_type = "OBJECT"
        for marks in (True, False):
            addon("marks").color(shading, marks)
        self.assertEqual(shading.color_type, "OBJECT")
        self.assertEqual(contact.in_words(self.scene.unit_settings), "Ball - Box: frames 4-8, 40 cm deep")
        self.assertEqual(view.view_perspective, "PERSP")
        np.testing.assert_allclose(view.view_location, (0.2, 0.1, 0.6), atol=0.1)
        self.assertGreater(view.view_distance, 0.5)
        self.settings.contact = 7  # there is none
        self.assertEqual(self.scene.frame_current, 6)

        bpy.ops.foldproof.check()  # replaces what there was
        self.assertEqual((len(self.settings.contacts), len(markers())), (1, 2))
        self.assertEqual([g.name for g in ball.vertex_groups], ["mine", "Foldproof: Ball - Box"])
        bpy.ops.ed.undo_push(message="before")
        bpy.ops.foldproof.clear()
        bpy.ops.ed.undo_push(message="cleared")
        bpy.ops.ed.undo()
        self.assertEqual((len(bpy.context.scene.foldproof.contacts), len(markers())), (1, 2))
        self.assertEqual(len(bpy.data.objects["Ball"].vertex_groups), 2)
        bpy.ops.ed.redo()
        self.assertEqual((len(bpy.context.scene.foldproof.contacts), markers()), (0, {}))
        groups = {o.name: [g.name for g in o.vertex_groups] for o in bpy.data.objects}
        self.assertEqual(groups, {"Ball": ["mine"], "Box": []})

    def test_contacts_of_one_object_and_between_frames(self):
        self.settings.samples = 2
        tube = bending_tube()
        bpy.ops.foldproof.check()
        worst = self.settings.contacts[0]
        self.assertEqual(worst.name, "lower - upper")
        self.assertTrue(worst.crosses and worst.first <= worst.worst <= worst.last <= 11)
        self.assertEqual(worst.worst % 0.5, 0)
        bpy.data.objects.remove(tube)
        two_planes()
        bpy.ops.foldproof.check()
        contact, = self.settings.contacts
        self.assertEqual((contact.frames(), contact.how_bad(self.scene.unit_settings)), ("6.25", "touches"))

    def test_a_contact_that_may_cross_says_so(self):
        ball_in_box()
        preferences = bpy.context.preferences.addons[NAME].preferences
        preferences.program = stand_in(f'exec "{PROGRAM}" "$@" --limit 1')
        bpy.ops.foldproof.check()
        contact = self.settings.contacts[0]
        self.assertEqual(contact.how_bad(self.scene.unit_settings), "touches, may cross")

    def test_every_object_has_a_file_of_its_own(self):
        square = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
        upright = [(0.5, 0.5, -1), (0.5, 2, -1), (0.5, 2, 1), (0.5, 0.5, 1)]
        harmless = [new_object(name, square, [(0, 1, 2, 3)]) for name in ("Cube.001", "Cube.001_2")]
        crossing = new_object("Cube_001", square + upright, [(0, 1, 2, 3), (4, 5, 6, 7)])
        same = [new_object(name, square, [(0, 1, 2, 3)]) for name in ("cube/001", "CUBE_001", "Cube_001_3")]
        names = addon("motion").file_names([*harmless, crossing, *same])
        self.assertEqual(len({name.lower() for name in names}), 6, names)
        self.settings.kind, self.settings.pairs = "POSES", "WITHIN"
        bpy.ops.foldproof.check()
        self.assertEqual(marked(crossing), [0, 1])
        self.assertIn("Foldproof: Cube_001", markers()[1])

    def test_a_file_may_have_the_name_of_another_object(self):
        class Sampled:
            def __init__(self, file, name):
                self.path, self.object, self.part_names = pathlib.Path(file), type("Object", (), {"name": name}), {}

        sampled = [Sampled("/tmp/a.npz", "b"), Sampled("/tmp/b.npz", "c"), Sampled("/tmp/c.d.npz", "e.f")]
        said = ["a and b go through each other in frame ", 0.5, "; /tmp/a.npz, ab, c.d"]
        self.assertEqual(addon("jobs")._sentence(said, sampled, [10, 20]), "b and c go through each other in frame 15; b, ab, e.f")

    def test_a_rig_and_a_model_trained_from_its_keys(self):
        tube = bending_tube()
        expected = program_says([tube], range(1, 12))
        colliding = [i + 1 for i, count in enumerate(expected) if count]
        self.assertTrue(colliding and colliding[0] > 3, expected)
        bpy.ops.foldproof.check()
        kept = tube.data["foldproof"].to_dict()
        self.assertEqual(sorted(map(int, kept["meeting"])), colliding)
        self.assertEqual(markers()[colliding[0]].removesuffix(", begins"), "Foldproof: lower - upper")
        self.assertGreater(len(kept["meeting"][str(colliding[-1])]), 2)

        self.fails(bpy.ops.foldproof.train, "has no name yet: save it")
        self.settings.folder = str(WORK / "models")
        self.assertEqual(bpy.ops.foldproof.train(), {"FINISHED"})
        self.assertEqual(self.settings.message, "Learned 1 mesh from 2 poses")
        self.assertTrue((WORK / "models" / "Tube.model").is_file())
        self.assertTrue(self.settings.use_models)
        bpy.ops.foldproof.clear()
        bpy.ops.foldproof.check()
        self.assertEqual(tube.data["foldproof"].to_dict(), kept)
        (WORK / "models" / "Tube.model").write_bytes(b"no model")
        self.fails(bpy.ops.foldproof.check, "Tube.model")
        (WORK / "models" / "Tube.model").unlink()
        self.fails(bpy.ops.foldproof.check, "There is no model of Tube: train one")

    def test_a_point_cache_in_a_modifier(self):
        """As after an import: the mesh is static, and a modifier reads its points from a file."""
        tube = bending_tube()
        expected = [i + 1 for i, count in enumerate(program_says([tube], range(1, 12))) if count]
        frames = np.load(WORK / "Tube-expected.npz")["vertices"].astype("<f4")
        header = struct.pack("<12siiffi", b"POINTCACHE2\0", 1, frames.shape[1], 0, 1, len(frames))
        (WORK / "tube.pc2").write_bytes(header + frames.tobytes())
        tube.modifiers.clear()
        cache = tube.modifiers.new("Cache", "MESH_CACHE")
        cache.cache_format, cache.filepath, cache.frame_start = "PC2", str(WORK / "tube.pc2"), 1
        bpy.ops.foldproof.check()
        self.assertEqual(sorted(map(int, tube.data["foldproof"]["meeting"].keys())), expected)

    def test_marks_stay_in_the_file(self):
        two_planes()
        bpy.ops.foldproof.check()
        path = str(WORK / "saved.blend")
        bpy.ops.wm.save_as_mainfile(filepath=path)
        bpy.ops.wm.open_mainfile(filepath=path)
        bpy.context.scene.frame_set(6)
        self.assertEqual(meeting(bpy.data.objects["Floor"]), [10, 11])
        bpy.context.scene.frame_set(5)
        self.assertEqual(meeting(bpy.data.objects["Floor"]), [])

    def test_says_what_is_wrong(self):
        preferences = bpy.context.preferences.addons[NAME].preferences
        floor, strip = two_planes()
        preferences.program = "/nowhere/foldproof"
        self.fails(bpy.ops.foldproof.check, "'/nowhere/foldproof' is not a program: correct it in Preferences")
        preferences.program = ""
        preferences.program = "/bin/false"
        self.fails(bpy.ops.foldproof.check, "The program gave no answer: see")
        preferences.program = stand_in("echo 'not of this system' >&2; exit 1")
        self.fails(bpy.ops.foldproof.check, r"The program gave no answer \(not of this system\): see")
        preferences.program = stand_in('while [ "$1" != --json ]; do shift; done; echo \'{"steps": []}\' > "$2"')
        self.fails(bpy.ops.foldproof.check, "The program foldproof is too old for this add-on: install its version")
        preferences.program = ""

        self.settings.pairs = "BETWEEN"
        floor.select_set(False)
        self.fails(bpy.ops.foldproof.check, "nothing between meshes")
        self.settings.pairs = "ALL"
        strip.animation_data_clear()
        self.fails(bpy.ops.foldproof.train, "keyframes")
        floor.select_set(True)
        build = floor.modifiers.new("Build", "BUILD")
        build.frame_start, build.frame_duration = -10, 30
        self.fails(bpy.ops.foldproof.check, "Floor has other faces at frame 2 than at the first")

    def test_finds_the_program_that_came_with_it(self):
        program = addon("program")
        with unittest.mock.patch.dict(program.BUNDLED, clear=True):
            self.assertEqual(program.find(""), str(PROGRAM))
            with unittest.mock.patch.dict(os.environ, PATH="/nowhere"):
                two_planes()
                self.fails(bpy.ops.foldproof.check, "The program foldproof was not found: install it")
        bundled = program.HERE / "linux-x64" / "foldproof"
        if not bundled.exists():
            self.skipTest("the add-on was built without a program inside")
        files = [bundled, *(bundled.parent / "lib").iterdir()]
        for file in files:
            file.chmod(0o644)  # as Blender unpacks them
        with unittest.mock.patch.object(pathlib.Path, "chmod", side_effect=PermissionError(13, "Permission denied", "/there")):
            self.fails(bpy.ops.foldproof.check, "/there cannot be made executable: Permission denied; copy its folder")
        with unittest.mock.patch.dict(os.environ, PATH="/nowhere"):
            self.assertEqual(bpy.ops.foldproof.check(), {"FINISHED"})
        self.assertEqual(list(markers()), [6])
        self.assertEqual({file.stat().st_mode & 0o777 for file in files}, {0o755})

    def test_the_manifest(self):
        """Limits of docs.blender.org/manual/en/4.2/advanced/extensions/getting_started.html"""
        found = tomllib.loads((addon("program").HERE / "blender_manifest.toml").read_text())
        self.assertEqual((found["schema_version"], found["type"]), ("1.0.0", "add-on"))
        self.assertEqual(found["version"], ".".join(map(str, sys.modules[NAME].bl_info["version"])))
        self.assertEqual(set(found["permissions"]), {"files"})
        for text in (found["tagline"], *found["permissions"].values()):
            self.assertLessEqual(len(text), 64)
            self.assertRegex(text[-1], r"\w")

    def test_curves_of_every_version(self):
        curves_of = addon("compatibility").curves_of
        _, strip = two_planes()
        self.assertEqual(len(curves_of(strip)), 3)
        self.assertEqual(curves_of(strip.data), [])
        new = types.SimpleNamespace
        channels = {"mine": new(fcurves=["x", "y"]), "another's": new(fcurves=["z"])}
        layer = new(strips=[new(channelbag=channels.get)])
        for slot, curves in (("mine", ["x", "y"]), ("empty", []), (None, [])):
            animation = new(action=new(layers=[layer]), action_slot=slot)
            self.assertEqual(curves_of(new(animation_data=animation), (5, 0, 0)), curves)

    def test_instances_are_refused(self):
        """The strip stays above the floor, but its instances, 6 below it, pass through."""
        _, strip = two_planes()
        key(strip, "location", {1: (0, 0, 7), 11: (0, 0, 6)})
        bpy.ops.foldproof.check()
        self.assertEqual(self.settings.message, "No collisions: no triangles cross in frame 1, and all 10 steps are proven free")
        tree = bpy.data.node_groups.new("Scatter", "GeometryNodeTree")
        tree.inputs.new("NodeSocketGeometry", "Geometry")
        tree.outputs.new("NodeSocketGeometry", "Geometry")
        kinds = ("NodeGroupInput", "GeometryNodeInstanceOnPoints", "GeometryNodeTranslateInstances", "GeometryNodeMeshCube",
                 "GeometryNodeJoinGeometry", "NodeGroupOutput")
        given, on_points, move, cube, join, out = (tree.nodes.new(kind) for kind in kinds)
        move.inputs["Translation"].default_value = (0, 0, -6)
        for start, end, name in ((given, on_points, "Points"), (cube, on_points, "Instance"), (on_points, move, 0),
                                 (move, join, 0), (given, join, 0), (join, out, 0)):
            tree.links.new(start.outputs[0], end.inputs[name])
        strip.modifiers.new("Scatter", "NODES").node_group = tree
        self.fails(bpy.ops.foldproof.check, "Strip shows instances, which are no faces of it: realize instances first")
        realize = tree.nodes.new("GeometryNodeRealizeInstances")
        tree.links.new(join.outputs[0], realize.inputs[0])
        tree.links.new(realize.outputs[0], out.inputs[0])
        bpy.ops.foldproof.check()
        self.assertIn(" go through ", self.settings.message)  # 1-unit cubes, which cross each other, too

        strip.modifiers.clear()
        child = new_object("Child", [(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)])
        child.parent, strip.instance_type = strip, "FACES"
        child.select_set(False)
        self.fails(bpy.ops.foldproof.check, "Strip shows instances")

    def test_simulations_must_be_baked(self):
        floor, strip = two_planes()
        cloth = strip.modifiers.new("Cloth", "CLOTH")
        self.fails(bpy.ops.foldproof.check, "Cloth of Strip is not baked: bake it first")
        cloth.show_viewport = False
        bpy.ops.foldproof.check()
        self.assertEqual(list(markers()), [6])
        cloth.show_viewport = True
        bpy.ops.foldproof.clear()
        cloth.point_cache.frame_start, cloth.point_cache.frame_end = 1, 11
        with bpy.context.temp_override(scene=self.scene, active_object=strip, object=strip, point_cache=cloth.point_cache):
            bpy.ops.ptcache.bake(bake=True)
        bpy.ops.foldproof.check()
        self.assertEqual(markers(), {})  # it falls by itself, slower than its keys would move it

    def test_rigid_bodies(self):
        """A ball that falls through a floor; its copy is none."""
        vertices, faces = grid(4, -1, 1, -1, 1)
        floor = new_object("Floor", vertices, faces)
        bpy.ops.mesh.primitive_uv_sphere_add(radius=0.5, location=(0.1, 0.2, 1))
        ball = bpy.context.object
        ball.name = "Ball"
        bpy.ops.rigidbody.object_add()
        floor.select_set(True)
        self.fails(bpy.ops.foldproof.check, "Rigid Body of Ball is not baked: bake it first")
        cache = self.scene.rigidbody_world.point_cache
        cache.frame_start, cache.frame_end = 1, 11
        with bpy.context.temp_override(scene=self.scene, point_cache=cache):
            bpy.ops.ptcache.bake(bake=True)
        bpy.ops.foldproof.check()
        self.assertRegex(self.settings.message, "^Ball and Floor go through each other")
        bpy.ops.foldproof.repair()
        copy = bpy.data.objects["Ball repaired"]
        self.assertEqual((copy.rigid_body, [c.name for c in copy.users_collection]), (None, [bpy.context.collection.name]))
        self.assertEqual(ball.rigid_body.type, "ACTIVE")
        bpy.ops.foldproof.check()
        self.assertIn("No collisions", self.settings.message)

    def test_says_what_was_left_out(self):
        two_planes()
        self.scene.frame_step = 5
        bpy.data.objects["Strip"].location.z = 9
        bpy.data.objects["Strip"].animation_data_clear()
        bpy.ops.foldproof.check()
        self.assertEqual(self.settings.message, "No collisions: no triangles cross in frame 1, and all 2 steps are proven free; only every 5th frame was checked")
        for step, name in ((1, ""), (2, "2nd"), (3, "3rd"), (11, "11th"), (21, "21st"), (112, "112th")):
            self.scene.frame_step = step
            self.assertEqual(addon("jobs")._left_out(bpy.context), name and f"; only every {name} frame was checked")
        self.scene.frame_step = 1
        for number, text in ((1, "1 selected object that is no mesh was"), (2, "2 selected objects that are no meshes were")):
            curve = bpy.data.objects.new("Curve", bpy.data.curves.new("Curve", "CURVE"))
            bpy.context.collection.objects.link(curve)
            curve.select_set(True)
            bpy.ops.foldproof.check()
            self.assertEqual(self.settings.message, f"No collisions: no triangles cross in frame 1, and all 10 steps are proven free; {text} not checked")

    def test_a_mesh_that_was_edited_meanwhile_gets_no_marks(self):
        floor, _ = two_planes()
        bpy.context.view_layer.objects.active = floor
        vertices, faces = grid(4, -0.5, 0.5, -0.5, 0.5)

        def reverse():  # as many faces, in another order
            floor.data.clear_geometry()
            floor.data.from_pydata(vertices, [], faces[::-1])

        for edit in (reverse, lambda: bpy.ops.object.mode_set(mode="EDIT")):
            job = addon("jobs").check(bpy.context, str(PROGRAM))
            while next(job).needs_scene:
                pass
            edit()
            with self.assertRaisesRegex(addon("problem").Problem, "Floor was edited meanwhile: check again"):
                for _ in job:
                    pass
            bpy.ops.object.mode_set(mode="OBJECT")
            self.assertEqual((markers(), len(self.settings.contacts), len(floor.vertex_groups)), ({}, 0, 0))
            self.assertNotIn("foldproof", floor.data)

    def test_other_polygons_over_the_same_corners_are_refused(self):
        def mesh(faces):
            made = bpy.data.meshes.new("Seven")
            made.from_pydata([(x, x * x, 0) for x in range(7)], [], faces)
            return made

        changing = bpy.data.objects.new("Changing", mesh([(0, 1, 2, 3), (4, 5, 6)]))
        bpy.context.collection.objects.link(changing)
        sampled = addon("motion").Sampled(changing, str(WORK / "changing.npz"))
        sampled.begin(1)
        changing.data = mesh([(0, 1, 2), (3, 4, 5, 6)])
        with self.assertRaisesRegex(addon("problem").Problem, "Changing has other faces at frame 1"):
            sampled.add(1)
        sampled._vertices.write(bytes(8 * 3 * 7))
        sampled.close()

    def test_cancelling_leaves_everything_as_it_was(self):
        floor, _ = two_planes()
        bpy.ops.foldproof.check()
        kept = floor.data["foldproof"].to_dict()
        jobs = addon("jobs")
        self.scene.frame_set(3)
        job = jobs.check(bpy.context, str(PROGRAM))
        self.assertTrue(next(job).needs_scene)
        next(job)
        job.close()
        self.assertEqual(self.scene.frame_current, 3)
        self.expect_nothing_left()

        sleeper = WORK / "sleeper"
        sleeper.write_text(f'#!/bin/sh\necho $$ > "{WORK}/pid"\nexec sleep 60\n')
        sleeper.chmod(0o755)
        job = jobs.check(bpy.context, str(sleeper))
        while next(job).needs_scene:
            pass
        while not (WORK / "pid").is_file() or not (WORK / "pid").read_text():
            time.sleep(0.01)
        next(job)
        job.close()
        with self.assertRaises(ProcessLookupError):
            os.kill(int((WORK / "pid").read_text()), 0)
        self.assertEqual(floor.data["foldproof"].to_dict(), kept)
        self.assertEqual(list(markers()), [6])
        self.expect_nothing_left()

    def modal(self, event_types):
        """Drives the operator like a window. Blender without a window cannot, so this simulates it."""
        interface = addon("interface")

        class Played(interface.FOLDPROOF_OT_check.__mro__[1]):
            said = []

            def start(self, context, executable):
                return addon("jobs").check(bpy.context, executable)

            def report(self, levels, text):
                self.said.append((levels, text))

        manager = types.SimpleNamespace(
            progress_begin=lambda *_: None,
            progress_update=lambda value: self.assertTrue(0 <= value <= 100),
            progress_end=lambda: None,
            event_timer_add=lambda *_, **__: "timer",
            event_timer_remove=lambda timer: self.assertEqual(timer, "timer"),
        )
        context = types.SimpleNamespace(scene=self.scene, window_manager=manager, screen=None)
        played = Played()
        played.steps = played.start(context, str(PROGRAM))
        played.timer, played.needs_scene = "timer", True
        for kind in event_types:
            answer = played.modal(context, types.SimpleNamespace(type=kind))
            if answer & {"FINISHED", "CANCELLED"}:
                break
            self.assertTrue(answer & {"RUNNING_MODAL", "PASS_THROUGH"})
        self.assertIsNone(interface._running)
        return answer, played.said

    def test_the_modal_operator(self):
        two_planes()
        answer, said = self.modal(["TIMER", "TIMER", "MOUSEMOVE", "ESC"])
        self.assertEqual((answer, said[-1]), ({"CANCELLED"}, ({"WARNING"}, "Cancelled: nothing was changed")))
        self.assertEqual(markers(), {})
        self.expect_nothing_left()

        def timer():
            while True:
                time.sleep(0.001)
                yield "TIMER"

        answer, said = self.modal(timer())
        self.assertEqual(answer, {"FINISHED"})
        self.assertEqual(list(markers()), [6])

    def test_the_panel(self):
        """Without a window nothing is drawn, but the names that the panel uses can be checked."""
        icons = bpy.types.UILayout.bl_rna.functions["label"].parameters["icon"].enum_items.keys()
        test, drawn = self, []

        class Layout:
            def prop(self, data, name, text=""):
                getattr(data, name)
                drawn.append(text)

            def prop_search(self, data, name, of, names, text=""):
                getattr(data, name)
                getattr(of, names)

            def operator(self, name, text="", icon="NONE"):
                test.assertIn(icon, icons)
                module, operator = name.split(".")
                getattr(getattr(bpy.ops, module), operator).get_rna_type()
                return types.SimpleNamespace()

            def label(self, text, icon="BLANK1"):
                test.assertIn(icon, icons)
                drawn.append(text)

            def template_list(self, name, _id, data, items, active_data, active, rows):
                test.assertTrue(isinstance(getattr(active_data, active), int))
                for item in getattr(data, items):
                    getattr(addon("interface"), name).draw_item(None, context, self, data, item, 0, active_data, active)

            def row(self, align=False):
                return self

            def split(self, factor):
                return self

            def column(self, align=False, heading=""):
                return self

            separator = lambda self: None

        panel = types.SimpleNamespace(layout=Layout())
        context = types.SimpleNamespace(
            scene=self.scene, region=types.SimpleNamespace(width=200), preferences=bpy.context.preferences,
            view_layer=bpy.context.view_layer,
        )
        context.selected_objects = two_planes()
        bpy.ops.foldproof.check()
        self.settings.contact = 0
        self.settings.message = "what was found " * 5
        bpy.context.preferences.addons[NAME].preferences.program = "/nowhere/foldproof"
        for name in ("panel", "still", "marks", "models"):
            getattr(addon("interface"), f"FOLDPROOF_PT_{name}").draw(panel, context)
        self.assertIn("'/nowhere/foldproof' is not", "".join(drawn))
        self.assertEqual([text for text in drawn if text in ("Floor - Strip", "touches")], ["Floor - Strip", "touches"])
        self.assertIn("Floor - Strip: frame 6.25, touches", " ".join("".join(drawn).split()))
        self.assertIn("Strip", drawn)
        self.assertEqual("".join(drawn).count("found"), 5)
        self.assertLess(max(map(len, drawn)), 30)

    def test_names_that_do_not_fit(self):
        shortened = addon("interface").shortened
        self.assertEqual(shortened("Arm - Leg", 9), "Arm - Leg")
        self.assertEqual(shortened("Skeleton_arm_1 - Leg", 14), "Ske…rm_1 - Leg")
        self.assertEqual(shortened("Leg - Skeleton_arm_1", 14), "Leg - Ske…rm_1")
        self.assertEqual(shortened("Skeleton_arm_1 - Skeleton_arm_2", 15), "Sk…m_1 - Sk…m_2")
        self.assertEqual(shortened("Skeleton_arm_1 with itself", 15), "Sk…m_1 - itself")

    def test_repair_makes_a_copy_that_touches_nothing(self):
        box, ball = ball_in_box()
        ball.data.materials.append(bpy.data.materials.new("Skin"))
        ball.vertex_groups.new(name="mine").add([0, 1], 1, "REPLACE")
        before = [tuple(v.co) for v in ball.data.vertices]
        box.foldproof_collider = True
        bpy.ops.foldproof.check()
        self.scene.frame_set(4)
        bpy.ops.ed.undo_push(message="before")
        self.assertEqual(bpy.ops.foldproof.repair(), {"FINISHED"})
        bpy.ops.ed.undo_push(message="repaired")
        self.assertEqual(self.scene.frame_current, 4)
        self.assertEqual(
            self.settings.message,
            "Proven: nothing touches, in no frame and at no time between frames. Made Ball repaired, and hid the original",
        )
        copy = bpy.data.objects["Ball repaired"]
        self.assertEqual({o.name for o in bpy.context.selected_objects}, {"Ball repaired", "Box"})
        self.assertEqual((ball.hide_get(), ball.hide_render, [tuple(v.co) for v in ball.data.vertices]), (True, True, before))
        self.assertEqual([m.name for m in copy.data.materials], ["Skin"])
        self.assertEqual([g.name for g in copy.vertex_groups], ["mine"])
        self.assertEqual(len(copy.data.shape_keys.key_blocks), 11)
        # It moves up about as much as the ball was deep, straight between frames, and hardly where the ball was free.
        self.scene.frame_set(1)
        np.testing.assert_allclose(self.positions(copy), self.positions(ball), atol=0.1)
        at = {}
        for frame in (5, 5.5, 6):
            addon("motion").set_time(self.scene, frame)
            at[frame] = self.positions(copy)
        np.testing.assert_allclose(at[5.5], (at[5] + at[6]) / 2, atol=1e-5)
        self.assertGreater(at[6][:, 2].min(), 1)
        self.assertLess(at[6][:, 2].min() - self.positions(ball)[:, 2].min(), 0.5)
        bpy.ops.foldproof.check()
        self.assertEqual(self.settings.message, "No collisions: no triangles cross in frame 1, and all 10 steps are proven free")
        self.expect_nothing_left()
        bpy.ops.ed.undo()
        self.assertNotIn("Ball repaired", bpy.data.objects)
        self.assertFalse(bpy.data.objects["Ball"].hide_render)

    def test_a_copy_looks_as_its_original(self):
        """Parented, scaled, with modifiers, constraints and materials of its own, in a collection."""
        box, ball = ball_in_box()
        box.foldproof_collider = True
        ball.data.materials.append(bpy.data.materials.new("of the mesh"))
        ball.data.uv_layers.new(name="Map")
        ball.material_slots[0].link = "OBJECT"
        ball.material_slots[0].material = bpy.data.materials.new("of the object")
        ball.color, ball.pass_index, ball["mine"] = (1, 0, 0, 1), 7, 5
        ball.data.polygons.foreach_set("use_smooth", [True] * len(ball.data.polygons))
        parent = bpy.data.objects.new("Parent", None)
        home = bpy.data.collections.new("Home")
        self.scene.collection.children.link(home)
        home.objects.link(parent)
        home.objects.link(ball)
        bpy.context.collection.objects.unlink(ball)
        ball.parent, parent.scale = parent, (0.8, 0.9, 1)
        ball.delta_location.x = 0.1
        ball.constraints.new("LIMIT_LOCATION")
        ball.modifiers.new("Finer", "SUBSURF")
        self.assertEqual(bpy.ops.foldproof.repair(), {"FINISHED"})
        copy = bpy.data.objects["Ball repaired"]
        self.assertEqual(copy.material_slots[0].material.name, "of the object")
        self.assertEqual((tuple(copy.color), copy.pass_index, copy["mine"]), ((1, 0, 0, 1), 7, 5))
        self.assertEqual([layer.name for layer in copy.data.uv_layers], ["Map"])
        self.assertTrue(all(polygon.use_smooth for polygon in copy.data.polygons))
        self.assertEqual([each.name for each in copy.users_collection], ["Home"])
        self.assertEqual((copy.parent, len(copy.modifiers), len(copy.constraints)), (None, 0, 0))
        self.scene.frame_set(1)
        np.testing.assert_allclose(self.positions(copy), self.positions(ball), atol=0.02)
        self.assertEqual((len(ball.modifiers), ball.parent, ball.data.name), (1, parent, "Ball"))

    def test_repair_of_one_contact_leaves_the_others(self):
        """A ball that dips into a box, and a tube beside them that is folded onto itself."""
        box, ball = ball_in_box()
        tube = bending_tube()
        tube.location = bpy.data.objects["Bones"].location = (9, 0, 0)
        for each in (box, ball, tube):
            each.select_set(True)
        with self.assertRaises(RuntimeError):  # none is chosen
            bpy.ops.foldproof.repair_contact()
        bpy.ops.foldproof.check()
        names = [each.name for each in self.settings.contacts]
        self.assertEqual(set(names), {"Ball - Box", "lower - upper"})
        self.settings.contact = names.index("Ball - Box")
        box.foldproof_collider = True
        self.assertEqual(bpy.ops.foldproof.repair_contact(), {"FINISHED"})
        self.assertRegex(
            self.settings.message,
            r"^Proven: what was chosen is gone, in all frames and at all times between them; left: (lower and upper|upper and lower)"
            r" go through each other, .*cm at worst, in frame .*\. Made Ball repaired, and hid the original$",
        )
        self.assertEqual({o.name for o in bpy.context.selected_objects}, {"Ball repaired", "Box", "Tube"})
        self.assertFalse(tube.hide_get())
        self.assertEqual({each.name: each.gone for each in self.settings.contacts}, {"Ball - Box": True, "lower - upper": False})
        with self.assertRaises(RuntimeError):  # it is gone
            bpy.ops.foldproof.repair_contact()
        self.settings.contact = 1 - self.settings.contact
        tube.select_set(False)
        self.fails(bpy.ops.foldproof.repair_contact, "Tube is not selected: select it, or check what is selected")
        tube.select_set(True)
        tube.vertex_groups["upper"].name = "other"
        self.fails(bpy.ops.foldproof.repair_contact, "Tube has no faces of upper any more: check again")
        tube.vertex_groups["other"].name = "upper"
        bpy.ops.foldproof.repair_contact()
        self.assertRegex(self.settings.message, "^Proven: nothing touches.*Made Tube repaired, and hid")
        self.assertTrue(all(each.gone for each in self.settings.contacts))

    def test_parts_that_stay(self):
        """Of a tube that is folded onto itself only the upper half gives way, then only the lower one."""
        tube = bending_tube()
        lower = [v.index for v in tube.data.vertices if v.co.z < 1.5]
        upper = [v.index for v in tube.data.vertices if v.co.z > 2.5]
        bpy.ops.foldproof.check()
        self.settings.contact = 0
        contact = self.settings.contacts[0]
        for still, moves in (("lower", upper), ("upper", lower)):
            for part, name in contact.parts():
                setattr(contact, name, getattr(contact, part) == still)
            bpy.ops.foldproof.repair_contact()
            self.assertRegex(self.settings.message, "^Proven: nothing touches")
            self.scene.frame_set(11)
            shift = np.abs(self.positions(bpy.data.objects["Tube repaired"]) - self.positions(tube)).max(axis=1)
            self.assertLess(shift[upper if moves is lower else lower].max(), 1e-5)
            self.assertGreater(shift[moves].max(), 0.05)
            bpy.ops.foldproof.before_after()
            bpy.data.objects.remove(bpy.data.objects["Tube repaired"])
            contact = self.settings.contacts[0]
            contact.gone = False
        for _, name in contact.parts():
            setattr(contact, name, True)
        self.fails(bpy.ops.foldproof.repair_contact, "Nothing may move: untick a part, or choose other")

    def test_painted_vertices_stay(self):
        """Of a ball that dips into a box, which may not move, the upper half, and the subdivided ball's."""
        box, ball = ball_in_box()
        box.foldproof_collider = True
        painted = ball.vertex_groups.new(name="painted")
        painted.add([v.index for v in ball.data.vertices if v.co.z > 0], 1, "REPLACE")
        painted.add([v.index for v in ball.data.vertices if v.co.z <= 0], 0.2, "REPLACE")
        ball.foldproof_still = "painted"
        for _ in range(2):
            self.assertEqual(bpy.ops.foldproof.repair(), {"FINISHED"})
            self.assertRegex(self.settings.message, "^Proven: nothing touches")
            self.scene.frame_set(6)
            copy = bpy.data.objects["Ball repaired"]
            shift = np.abs(self.positions(copy) - self.positions(ball)).max(axis=1)
            upper = self.positions(ball)[:, 2] > 1.1 + 0.15
            self.assertLess(shift[upper].max(), 1e-5)
            self.assertGreater(shift[~upper].max(), 0.3)
            bpy.ops.foldproof.before_after()
            bpy.data.objects.remove(copy)
            ball.modifiers.new("Finer", "SUBSURF")
        painted.add(range(len(ball.data.vertices)), 1, "REPLACE")
        self.fails(bpy.ops.foldproof.repair, "Nothing may move: untick a part, or choose other vertex groups")

    def test_one_contact_after_the_other_in_copies(self):
        """A copy has no armature, and the parts that its original has."""
        tube = bending_tube()
        tube.vertex_groups.new(name="pinned").add(list(range(300)), 1, "REPLACE")
        ball = ball_in_box()[1]
        ball.name = "Other"
        bpy.data.objects["Box"].foldproof_collider = True
        ball.location.x = bpy.data.objects["Box"].location.x = 9
        tube.select_set(True)
        bpy.ops.foldproof.check()
        names = [each.name for each in self.settings.contacts]
        for name, left in (("lower - upper", "; left: "), ("Box - Other", "")):
            self.settings.contact = names.index(name)
            bpy.ops.foldproof.repair_contact()
            self.assertIn(left, self.settings.message)
        self.assertRegex(self.settings.message, "^Proven: nothing touches.*Made Other repaired, and hid")

        def parts(name):
            with addon("motion").evaluated(bpy.data.objects[name], all_layers=True) as (mesh, _):
                mesh.calc_loop_triangles()
                triangles = addon("motion").numbers(mesh.loop_triangles, "vertices", 3).reshape(-1, 3)
                return addon("motion").parts_of(bpy.data.objects[name], mesh, triangles).tolist()

        self.assertEqual(set(parts("Tube")), {"lower", "upper"})
        self.assertEqual(parts("Tube repaired"), parts("Tube"))

    def test_parts_of_one_name_in_two_objects(self):
        one, two = bending_tube(), bending_tube()
        two.location.x = 3
        bpy.data.objects["Bones.001"].location.x = 3
        one.select_set(True)
        bpy.ops.foldproof.check()
        self.assertEqual({each.name for each in self.settings.contacts},
                         {"lower of Tube - upper of Tube", "lower of Tube.001 - upper of Tube.001"})
        self.assertRegex(self.settings.message, r"^(lower|upper) of Tube(\.001)? and (lower|upper) of Tube(\.001)? go through")
        self.settings.contact = [each.object_a for each in self.settings.contacts].index("Tube.001")
        bpy.ops.foldproof.repair_contact()
        self.assertRegex(self.settings.message, r"left: (lower|upper) of Tube and (lower|upper) of Tube go.* Made Tube.001 repaired, and")

    def test_parts_that_are_no_bones(self):
        """Of several objects they have the object's name; a copy has the same parts, also where a face is in none."""
        box, ball = ball_in_box()
        ball.vertex_groups.new(name="Pin").add([v.index for v in ball.data.vertices if v.co.z > 0.2], 1, "REPLACE")
        box.foldproof_collider = True
        bpy.ops.foldproof.check()
        self.assertEqual({each.name for each in self.settings.contacts}, {"Ball - Box"})
        ball.vertex_groups["Pin"].add([v.index for v in ball.data.vertices if v.co.z < -0.2], 1, "REPLACE")
        bpy.ops.foldproof.check()
        names = [each.name for each in self.settings.contacts]
        self.assertIn("Pin of Ball - Box", names)
        bpy.ops.foldproof.repair()
        self.settings.thickness = 0.02
        bpy.ops.foldproof.check()
        self.assertIn("Pin of Ball repaired - Box", [each.name for each in self.settings.contacts])
        self.settings.contact = 0
        bpy.ops.foldproof.repair_contact()
        self.assertRegex(self.settings.message, "^Proven: ")

    def test_vertices_at_one_place_are_one(self):
        """Importers make several of one, for faces that differ in normals or texture coordinates."""
        box, ball = ball_in_box()
        bpy.ops.foldproof.check()
        expected = self.settings.message, ball.data["foldproof"].to_dict()
        self.assertTrue(expected[1]["meeting"])
        apart = bmesh.new()
        apart.from_mesh(ball.data)
        bmesh.ops.split_edges(apart, edges=apart.edges)
        apart.to_mesh(ball.data)
        apart.free()
        self.assertGreater(len(ball.data.vertices), 1000)
        ball.rotation_euler = (0.3, 0.2, 0.1)
        bpy.ops.foldproof.check()
        turned = self.settings.message
        ball.rotation_euler = (0, 0, 0)
        bpy.ops.foldproof.check()
        self.assertEqual((self.settings.message, ball.data["foldproof"].to_dict()), expected)
        self.assertRegex(turned, "^Ball and Box go through each other, ")
        bpy.ops.foldproof.repair()
        self.assertIn("Proven: nothing touches", self.settings.message)
        bpy.ops.foldproof.check()
        self.assertIn("No collisions", self.settings.message)
        # Those that stay together are one, whatever leaves.
        bpy.ops.foldproof.before_after()
        ball.shape_key_add(name="Basis")
        aside = ball.shape_key_add(name="one face aside")
        for vertex in ball.data.polygons[100].vertices:
            aside.data[vertex].co.x += 9
        key(aside, "value", {1: 0, 11: 1})
        self.assertEqual(bpy.ops.foldproof.check(), {"FINISHED"})
        self.assertRegex(self.settings.message, "^Ball and Box go through each other, ")
        first = addon("motion").first_at_same_place
        rows = np.array([[0, 0, 1], [1, 2, 3], [-0.0, 0, 1], [1, 2, 3], [0, 0, 2]])
        np.testing.assert_array_equal(first(rows), [0, 1, 0, 1, 4])
        rows = np.array([[0, 0, 1], [1, 2, 4], [5, 5, 5], [1, 2, 3], [0, 0, 2]])
        np.testing.assert_array_equal(addon("motion").still_together(np.array([0, 1, 0, 1, 0]), rows), [0, 1, 2, 3, 4])
        rows[[2, 4]] = 7
        np.testing.assert_array_equal(addon("motion").still_together(np.array([0, 1, 0, 1, 0]), rows), [0, 1, 2, 3, 2])

    def test_before_and_after(self):
        box, ball = ball_in_box()
        box.foldproof_collider = True
        with self.assertRaises(RuntimeError):
            bpy.ops.foldproof.before_after()
        bpy.ops.foldproof.repair()
        copy = bpy.data.objects["Ball repaired"]
        shown = lambda: {o.name for o in bpy.context.view_layer.objects if o.visible_get() and not o.hide_render}
        selected = lambda: {o.name for o in bpy.context.selected_objects}
        self.assertEqual(shown(), {"Box", "Ball repaired"})
        bpy.ops.foldproof.before_after()
        self.assertEqual((shown(), selected()), ({"Box", "Ball"}, {"Box", "Ball"}))
        copy.name = "Mine"
        bpy.ops.foldproof.before_after()
        self.assertEqual((shown(), selected()), ({"Box", "Mine"}, {"Box", "Mine"}))
        copy.name = "Ball repaired"

        # A copy of the copy: the first and the last one are before and after.
        self.settings.thickness = 1
        self.settings.kind = "POSES"  # in which thickness is not asked for
        bpy.ops.foldproof.repair()
        self.assertEqual(self.settings.message, "The motion is as it was: nothing touches")
        self.settings.kind = "MOTION"
        self.fails(bpy.ops.foldproof.repair, "Thickness: 1 is more than the gaps of Ball repaired itself: ")
        self.settings.thickness = 0.02
        bpy.ops.foldproof.repair()
        self.assertEqual(shown(), {"Box", "Ball repaired.001"})
        bpy.ops.foldproof.before_after()
        self.assertEqual(shown(), {"Box", "Ball"})
        bpy.ops.foldproof.before_after()
        self.assertEqual((shown(), selected()), ({"Box", "Ball repaired.001"},) * 2)
        bpy.data.objects.remove(ball)
        bpy.data.objects.remove(bpy.data.objects["Ball repaired"])
        with self.assertRaises(RuntimeError):
            bpy.ops.foldproof.before_after()

    def positions(self, made):
        shown = made.evaluated_get(bpy.context.evaluated_depsgraph_get())
        return np.array([shown.matrix_world @ v.co for v in shown.data.vertices])

    def test_repair_of_one_frame_of_what_is_free_and_of_what_may_not_move(self):
        bending_tube()
        self.scene.frame_start = self.scene.frame_end = 10
        bpy.ops.foldproof.repair()
        self.assertRegex(self.settings.message, r"^Proven: nothing touches.*\. Made Tube repaired, and hid")
        self.assertIsNone(bpy.data.objects["Tube repaired"].data.shape_keys)
        bpy.ops.foldproof.repair()  # of the copy
        self.assertEqual(self.settings.message, "The motion is as it was: nothing touches")
        self.assertEqual([o.name for o in bpy.data.objects], ["Bones", "Tube", "Tube repaired"])
        for each in bpy.context.selected_objects:
            each.foldproof_collider = True
        self.fails(bpy.ops.foldproof.repair, "All selected meshes are colliders, so nothing may move: untick one")

    def test_can_be_turned_off_and_on(self):
        show = addon("marks").show
        for _ in range(2):
            self.assertEqual(bpy.app.handlers.frame_change_pre.count(show), 1)
            bpy.ops.preferences.addon_disable(module=NAME)
            self.assertFalse(hasattr(bpy.types.Scene, "foldproof"))
            self.assertNotIn("show", [h.__name__ for h in bpy.app.handlers.frame_change_pre])
            bpy.ops.preferences.addon_enable(module=NAME)
            self.assertTrue(hasattr(bpy.types.Scene, "foldproof"))
            show = addon("marks").show
        two_planes()
        self.assertEqual(bpy.ops.foldproof.check(), {"FINISHED"})
        self.assertEqual(list(markers()), [6])


def install_as_extension():
    """Puts it where Python finds it by this name, and lets Blender 3.4 enable such names."""
    to = pathlib.Path(bpy.utils.user_resource("SCRIPTS", path="addons"), *NAME.split("."))
    to.parent.mkdir(parents=True)
    shutil.unpack_archive(ZIP, to.parent)
    (to.parent / "foldproof_addon").rename(to)
    sys.path.append(str(to.parents[2]))
    addon_utils.__import__ = importlib.import_module


if "." in NAME:
    install_as_extension()
else:
    bpy.ops.preferences.addon_install(filepath=str(ZIP))
result = unittest.main(argv=["test_addon"], exit=False, verbosity=2).result
if not result.wasSuccessful():
    raise SystemExit(1)
