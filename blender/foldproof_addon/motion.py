"""Exports meshes as the viewport shows them, frame by frame, to NPZ files."""

import contextlib
import math
import pathlib
import zipfile

import bpy
import numpy as np

from . import marks
from .problem import Problem
from .progress import Progress

# Passes each polygon's index (plus 1) through modifiers, which copy face attributes to the faces that they create.
ORIGIN = "foldproof_origin"


def numbers(collection, attribute, width=1, kind=np.int32):
    out = np.empty(len(collection) * width, kind)
    collection.foreach_get(attribute, out)
    return out


def faces_of(mesh):
    """The polygon and the vertex of each corner."""
    corners = numbers(mesh.polygons, "loop_total")
    return np.stack([np.repeat(np.arange(len(corners)), corners), numbers(mesh.loops, "vertex_index")])


@contextlib.contextmanager
def evaluated(scene_object, all_layers=False):
    """The object with modifiers and armatures applied, at the scene's current frame."""
    depsgraph = bpy.context.evaluated_depsgraph_get()
    shown = scene_object.evaluated_get(depsgraph)
    mesh = shown.to_mesh(preserve_all_data_layers=True, depsgraph=depsgraph) if all_layers else shown.to_mesh()
    try:
        yield mesh, np.array(shown.matrix_world)
    finally:
        shown.to_mesh_clear()


@contextlib.contextmanager
def numbered_polygons(meshes):
    """A context in which the polygons of every mesh have an index that modifiers pass on."""
    try:
        for mesh in meshes:
            attribute = mesh.attributes.new(ORIGIN, "INT", "FACE")
            attribute.data.foreach_set("value", np.arange(1, len(mesh.polygons) + 1, dtype=np.int32))
            mesh.update()
        yield
    finally:
        for mesh in meshes:
            if ORIGIN in mesh.attributes:
                mesh.attributes.remove(mesh.attributes[ORIGIN])
            mesh.update()


def first_original(scene_object):
    """What it was copied from by repairs; it has the modifiers and the name. Itself if it is no copy."""
    while scene_object.foldproof_original:
        scene_object = scene_object.foldproof_original
    return scene_object


def bones_of(scene_object):
    return {
        bone.name
        for modifier in first_original(scene_object).modifiers
        if modifier.type == "ARMATURE" and modifier.object
        for bone in modifier.object.data.bones
    }


def parts_of(scene_object, mesh, triangles):
    """The name of the vertex group with the most weight in each triangle, of those that bones move if there are such; the
    object's name where there is none. None: the groups tell nothing apart."""
    bones = bones_of(scene_object)
    named = {g.index: g.name for g in scene_object.vertex_groups if not g.name.startswith(marks.PREFIX)}
    if bones & set(named.values()):
        named = {index: name for index, name in named.items() if name in bones}
    if not named:
        return None
    column = {index: k for k, index in enumerate(named)}
    weights = np.zeros((len(mesh.vertices), len(named)), np.float32)
    for vertex in mesh.vertices:
        for group in vertex.groups:
            if group.group in column:
                weights[vertex.index, column[group.group]] = group.weight
    sums = sum(weights[triangles[:, k]] for k in range(3))
    names = np.array([*named.values(), first_original(scene_object).name])
    parts = names[np.where(sums.max(axis=1) > 0, sums.argmax(axis=1), len(named))]
    return parts if len(set(parts)) > 1 else None


def still_vertices(scene_object, mesh):
    """Of each vertex, whether its weight in the vertex group that may not move is above a half. None: no group is chosen."""
    group = scene_object.vertex_groups.get(scene_object.foldproof_still)
    if not group:
        return None
    return np.array([any(g.group == group.index and g.weight > 0.5 for g in v.groups) for v in mesh.vertices], bool)


def first_at_same_place(positions):
    """Of each vertex, the first one at its place."""
    _, first, place = np.unique(positions + 0.0, axis=0, return_index=True, return_inverse=True)  # -0 is 0
    return first[place.ravel()]


def still_together(merged, positions):
    """Of each vertex, the first one that it was merged with and that is at its place now."""
    parted = np.flatnonzero((positions != positions[merged]).any(axis=1))
    if len(parted) == 0:
        return merged
    places = np.column_stack([merged[parted], positions[parted]])
    merged = merged.copy()
    merged[parted] = parted[first_at_same_place(places)]
    return merged


class Sampled:
    """One object: its triangles, their polygons in the object's own mesh, and the file that is being written.

    part_names: of each vertex group that is a part, what it is called in the file; empty if the object has no parts.
    still: of each vertex, whether it may not move in a repair; None: all may.
    merged: of each vertex, the first one that is at its place in all poses. Importers put several vertices there, for faces
    with other normals or texture coordinates, and what meets there is one surface.
    """

    def __init__(self, scene_object, path):
        self.object = scene_object
        self.path = path
        with evaluated(scene_object, all_layers=True) as (mesh, _):
            mesh.calc_loop_triangles()
            self.triangles = numbers(mesh.loop_triangles, "vertices", 3).reshape(-1, 3)
            if len(self.triangles) == 0:
                raise Problem(f"{scene_object.name} has no faces: select only meshes that have some")
            origin = mesh.attributes.get(ORIGIN)
            polygons = numbers(origin.data, "value") - 1 if origin else np.full(len(mesh.polygons), -1, np.int32)
            self.polygon_of = polygons[numbers(mesh.loop_triangles, "polygon_index")]
            self._faces = faces_of(mesh)
            self.vertex_count = len(mesh.vertices)
            self._parts = parts_of(scene_object, mesh, self.triangles)
            self.still = still_vertices(scene_object, mesh)
        self.part_names = {} if self._parts is None else {str(name): str(name) for name in np.unique(self._parts)}
        self._own_faces = faces_of(scene_object.data)
        self._vertices = None
        self.merged = None
        self._archive = zipfile.ZipFile(path, "x")  # never the file of another object
        with self._archive.open("faces.npy", "w") as member:
            np.lib.format.write_array(member, self.triangles)

    def begin(self, sample_count):
        """Goes before the poses."""
        if self._parts is not None:
            with self._archive.open("parts.npy", "w") as member:
                np.lib.format.write_array(member, np.array([self.part_names[name] for name in self._parts]))
        # First the header with the shape, then frame by frame, so that memory holds one frame.
        self._vertices = self._archive.open("vertices.npy", "w", force_zip64=True)
        shape = (sample_count, self.vertex_count, 3)
        np.lib.format.write_array_header_1_0(self._vertices, {"descr": "<f8", "fortran_order": False, "shape": shape})

    def add(self, time):
        """Adds the pose at the scene's current frame, `time`, in world space."""
        with evaluated(self.object) as (mesh, world):
            if len(mesh.vertices) != self.vertex_count or not np.array_equal(faces_of(mesh), self._faces):
                raise Problem(
                    f"{self.object.name} has other faces at frame {time:g} than at the first: turn off the modifier "
                    "that changes them, or choose frames between which it does not"
                )
            local = numbers(mesh.vertices, "co", 3, np.float32).reshape(-1, 3).astype(np.float64)
        self.merged = first_at_same_place(local) if self.merged is None else still_together(self.merged, local)
        # Column by column: a product of matrices may round equal rows differently.
        self._vertices.write((sum(local[:, k : k + 1] * world[:3, k] for k in range(3)) + world[:3, 3]).tobytes())

    def expect_unedited(self):
        """Marks on another mesh than the one that was sampled would be on wrong faces."""
        mesh = self.object.data
        if mesh.is_editmode or not np.array_equal(faces_of(mesh), self._own_faces):
            raise Problem(f"{self.object.name} was edited meanwhile: check again")

    def close(self):
        if self._vertices:
            self._vertices.close()
        if self.merged is not None:
            with self._archive.open("merged.npy", "w") as member:
                np.lib.format.write_array(member, self.merged)
        self._archive.close()

    def poses(self):
        """The positions that were written, pose by pose."""
        with zipfile.ZipFile(self.path) as archive, archive.open("vertices.npy") as member:
            np.lib.format.read_magic(member)
            (count, *shape), _, kind = np.lib.format.read_array_header_1_0(member)
            for _ in range(count):
                yield np.frombuffer(member.read(math.prod(shape) * kind.itemsize), kind).reshape(shape)


def _tell_parts_apart(sampled):
    """Of several objects, gives parts whose names do not say of which they are, which others have or which are no bones',
    its name, too."""
    for each in sampled:
        others = {name for other in sampled if other is not each for name in other.part_names}
        clear = bones_of(each.object) | {first_original(each.object).name}
        for name in each.part_names:
            if name in others or (len(sampled) > 1 and name not in clear):
                each.part_names[name] = f"{name} of {pathlib.Path(each.path).stem}"


def display_names(sampled):
    """What names in the program's answer stand for: files, without and with folder and extension, for the objects' own
    names, and parts that have the name of a file in theirs for those with the object's."""
    names = {}
    for each in sampled:
        for file in (pathlib.Path(each.path).stem, str(each.path)):
            names[file] = each.object.name
        for part, written in each.part_names.items():
            if written != part:
                names[written] = f"{part} of {each.object.name}"
    return names


def set_time(scene, time):
    frame = math.floor(time)
    scene.frame_set(frame, subframe=time - frame)


@contextlib.contextmanager
def returning(scene):
    """A context after which the scene is at the time where it was."""
    before = scene.frame_current + scene.frame_subframe
    try:
        yield
    finally:
        set_time(scene, before)


def refuse_instances(objects):
    """The viewport shows instances, but to_mesh() leaves them out."""
    instances = bpy.context.evaluated_depsgraph_get().object_instances
    parents = {instance.parent.original for instance in instances if instance.is_instance}
    for scene_object in objects:
        if scene_object in parents:
            raise Problem(f"{scene_object.name} shows instances, which are no faces of it: realize instances first")


def file_names(objects):
    """A valid file name for each object, which no other has, also where case does not count; the program's messages
    show it."""
    names, taken = [], set()
    for scene_object in objects:
        base = name = bpy.path.clean_name(scene_object.name)
        number = 1
        while name.casefold() in taken:
            number += 1
            name = f"{base}_{number}"
        taken.add(name.casefold())
        names.append(name)
    return names


def sample(scene, objects, times, folder):
    """Writes every object's poses at `times` into folder/NAME.npz. Yields Progress; returns a Sampled for each.

    Quads and larger polygons are triangulated in the scene's first frame, whatever `times` are, so that models of the
    mesh fit.
    """
    sampled = []
    with contextlib.ExitStack() as at_end:
        at_end.enter_context(returning(scene))
        at_end.enter_context(marks.paused())
        with numbered_polygons({o.data for o in objects}):
            set_time(scene, scene.frame_start)
            for scene_object, name in zip(objects, file_names(objects)):
                sampled.append(Sampled(scene_object, str(folder / f"{name}.npz")))
                at_end.callback(sampled[-1].close)
        _tell_parts_apart(sampled)
        for each in sampled:
            each.begin(len(times))
        for i, time in enumerate(times):
            yield Progress(i / len(times), f"Reading frame {time:g}", needs_scene=True)
            set_time(scene, time)
            refuse_instances(objects)
            for each in sampled:
                each.add(time)
    return sampled
