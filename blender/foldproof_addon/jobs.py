"""The jobs behind the buttons. Each is a generator of Progress that returns a sentence for the user; closing it cancels
the job and leaves nothing behind."""

import math
import pathlib
import re
import tempfile

import bpy
import numpy as np

from . import contacts, marks, motion, program, repaired
from .compatibility import curves_of
from .problem import Problem


WITHOUT_MESH = {"CURVE", "CURVES", "FONT", "GPENCIL", "META", "POINTCLOUD", "SURFACE", "VOLUME"}  # shown, and not checked


def meshes_to_check(context):
    """The selected mesh objects, sorted by name, so that the order of selection does not matter."""
    objects = sorted((o for o in context.selected_objects if o.type == "MESH"), key=lambda o: o.name)
    if not objects:
        raise Problem("No mesh is selected: select the objects to check")
    for scene_object in objects:
        if scene_object.mode == "EDIT":
            raise Problem(f"{scene_object.name} is in Edit Mode: leave it first")
        if scene_object.data.library or scene_object.data.override_library:
            raise Problem(f"The mesh of {scene_object.name} is linked from another file: make it local first")
        for name, cache in _simulations(context.scene, scene_object):
            if not cache.is_baked:  # it would be computed anew, from what frame and in what state it is now
                raise Problem(f"{name} of {scene_object.name} is not baked: bake it first (Physics or Scene > Cache > Bake)")
    return objects


def _simulations(scene, scene_object):
    """Names and caches of what moves it."""
    for modifier in scene_object.modifiers:
        if modifier.type in {"CLOTH", "SOFT_BODY"} and modifier.show_viewport:
            yield modifier.name, modifier.point_cache
    body, world = scene_object.rigid_body, scene.rigidbody_world
    if body and body.type == "ACTIVE" and not body.kinematic and world and world.enabled:
        yield "Rigid Body", world.point_cache


def frames_of(scene):
    start, end = scene.frame_start, scene.frame_end
    if scene.use_preview_range:
        start, end = scene.frame_preview_start, scene.frame_preview_end
    return list(range(start, end + 1, scene.frame_step))


def model_path(settings, name):
    folder = settings.folder
    if folder.startswith("//") and not bpy.data.filepath:
        raise Problem("Models go beside the .blend file, which has no name yet: save it, or choose another folder")
    return pathlib.Path(bpy.path.abspath(folder)) / f"{name}.model"


def _models(settings, objects):
    if not settings.use_models:
        return []
    paths = [model_path(settings, name) for name in motion.file_names(objects)]
    existing = [str(path) for path in paths if path.is_file()]
    if not existing or 1 < len(existing) < len(objects):
        missing = [o.name for o, path in zip(objects, paths) if not path.is_file()]
        raise Problem(f"There is no model of {', '.join(missing)}: train one, or turn models off")
    return existing


def _ignored(settings, objects):
    """The two objects whose pairs are ignored; none if none are."""
    pair = [each for each in (settings.ignore_a, settings.ignore_b) if each]
    if len(pair) == 1:
        raise Problem("Ignore names one object of a pair: choose the other one, or empty it")
    missing = [each.name for each in pair if each not in objects]
    if missing:
        raise Problem(f"{missing[0]} is to be ignored and not selected: select it, or empty Ignore")
    return pair


def _ignored_paths(pair, sampled):
    path_of = {each.object: str(each.path) for each in sampled}
    return ["--ignore", *(path_of[each] for each in pair)] if pair else []


def _times(scene, frames, parts):
    return [frames[0] + k * scene.frame_step / parts for k in range((len(frames) - 1) * parts + 1)]


def check(context, executable):
    """Checks the selected meshes over the scene's frames, and marks faces and frames."""
    scene, settings = context.scene, context.scene.foldproof
    objects, frames = meshes_to_check(context), frames_of(scene)
    left_out = _left_out(context)
    poses = settings.kind == "POSES"
    parts = 1 if poses else settings.samples
    if settings.pairs == "BETWEEN" and len(objects) < 2:
        raise Problem("One mesh is selected, so there is nothing between meshes: select two, or check all")
    ignored = _ignored(settings, objects)
    models = _models(settings, objects)
    times = _times(scene, frames, parts)
    with tempfile.TemporaryDirectory(prefix="foldproof-") as name:
        folder = pathlib.Path(name)
        sampled = yield from motion.sample(scene, objects, times, folder)
        answer = folder / "answer.json"
        arguments = [executable, "check", *(each.path for each in sampled), "--pairs", "--json", str(answer)]
        for model in models:
            arguments += ["--model", model]
        if poses:
            arguments.append("--static")
        elif settings.thickness > 0:
            arguments += ["--thickness", repr(settings.thickness)]
        if settings.pairs != "ALL":
            arguments.append("--within" if settings.pairs == "WITHIN" else "--between")
        arguments += _ignored_paths(ignored, sampled) + _unit(scene)
        yield from _run(sampled, arguments, folder, "Looking for collisions")
        found = program.read_answer(answer, sampled)
    for each in sampled:
        each.expect_unedited()
    contacts.store(scene, sampled, found.contacts, found.unknown_frames, times)
    unknown = _mark(scene, sampled, found, [frames[k // parts] for k in range(len(times))])
    text = _sentence(found.verdict, sampled, times)
    return text + left_out + ("; some of it on faces that a modifier made by itself" if unknown else "")


def _unit(scene):
    """The unit of lengths, where Blender's has a name."""
    units = scene.unit_settings
    names = {1: "m", 0.01: "cm", 0.001: "mm", 1000: "km"}
    name = next((name for scale, name in names.items() if math.isclose(units.scale_length, scale, rel_tol=1e-5)), None)
    return ["--unit", name] if units.system == "METRIC" and name else []


def _run(sampled, arguments, folder, text):
    """Runs the program; its errors name objects and settings as Blender does."""
    try:
        yield from program.run(arguments, folder, text)
    except Problem as problem:
        said = str(problem).removeprefix("foldproof: ")
        raise Problem(_with_names(re.sub("^--thickness", "Thickness", said), sampled)) from None


def _sentence(parts, sampled, times):
    """The program's verdict with the scene's frames and the objects' names."""
    frame = lambda pose: f"{np.interp(pose, range(len(times)), times):.4g}"
    text = "".join(part if isinstance(part, str) else frame(part) for part in parts).removesuffix(".")
    return _with_names(text, sampled)


def _with_names(text, sampled):
    names = motion.display_names(sampled)
    longest_first = sorted(map(re.escape, names), key=len, reverse=True)
    # All at once: the name of one object may be that of another's file.
    return re.sub(rf"(?<!\w)({'|'.join(longest_first)})(?!\w)", lambda found: names[found[0]], text)


def _mark(scene, sampled, found, frame_of):
    """Returns whether there is something on faces that are none of the mesh."""
    inside = {each.object.data: {} for each in sampled}  # objects may share a mesh
    meeting = {each.object.data: {} for each in sampled}
    unknown = False

    def add(to, frame, marked):
        nonlocal unknown
        for each, triangles in zip(sampled, marked):
            polygons = set(each.polygon_of[np.array(triangles, np.int64)].tolist())
            unknown |= -1 in polygons
            to[each.object.data].setdefault(frame, set()).update(polygons - {-1})

    for pose, marked in enumerate(found.inside[: len(frame_of)]):
        # Of the poses between two frames none is shown.
        if marked and (pose == 0 or frame_of[pose] != frame_of[pose - 1]):
            add(inside, frame_of[pose], marked)
    for step, marked in found.meeting:
        add(meeting, frame_of[step], marked)
    for mesh in inside:
        marks.store(mesh, inside[mesh], meeting[mesh])
    marks.show(scene)
    return unknown


def _left_out(context):
    """Frames and selected objects that are not checked."""
    text, step = "", context.scene.frame_step
    if step > 1:
        ending = "th" if step // 10 % 10 == 1 else {1: "st", 2: "nd", 3: "rd"}.get(step % 10, "th")
        text = f"; only every {step}{ending} frame was checked"
    others = sum(o.type in WITHOUT_MESH for o in context.selected_objects)
    if others:
        one = others == 1
        text += f"; {others:,} selected {'object that is no mesh was' if one else 'objects that are no meshes were'} not checked"
    return text


def repair(context, executable, contact=None):
    """Makes copies of the selected meshes that touch nothing over the scene's frames, or in which only a contact of the
    list is gone. Colliders stay as they are, as do the parts that are ticked in the active contact and the vertices of chosen
    groups; what was not moved gets no copy."""
    scene, settings = context.scene, context.scene.foldproof
    objects, frames = meshes_to_check(context), frames_of(scene)
    movable = [each for each in objects if not each.foldproof_collider]
    if not movable:
        raise Problem("All selected meshes are colliders, so nothing may move: untick one")
    left_out = _left_out(context)
    ignored = _ignored(settings, objects)
    models = _models(settings, objects)
    thickness, parts = (0, 1) if settings.kind == "POSES" else (settings.thickness, settings.samples)
    times = _times(scene, frames, parts)
    with tempfile.TemporaryDirectory(prefix="foldproof-") as name:
        folder = pathlib.Path(name)
        # A point cache, which holds what Blender does, single precision, has two frames or more.
        sampled = yield from motion.sample(scene, objects, times if len(times) > 1 else times * 2, folder)
        answer, caches = folder / "answer.json", {}
        arguments = [executable, "repair", *(each.path for each in sampled), "--json", str(answer)]
        still = contacts.still_parts(settings, sampled)
        for each in sampled:
            all_parts = each.part_names and set(each.part_names.values()) <= set(still)
            if each.object in movable and not all_parts and (each.still is None or not each.still.all()):
                made = folder / f"repaired-{len(caches)}.obj"
                caches[each] = made.with_suffix(".pc2")
                arguments += ["-o", str(made)]
            else:
                arguments += ["--fixed", each.path]
        if not caches:
            raise Problem("Nothing may move: untick a part, or choose other vertex groups")
        for model in models:
            arguments += ["--model", model]
        if thickness > 0:
            arguments += ["--thickness", repr(thickness)]
        if contact is not None:
            arguments += ["--contact", *contacts.names_in_files(contact, sampled)]
        for part in still:
            arguments += ["--fixed", part]
        arguments += _still_vertices(sampled, folder)
        arguments += _ignored_paths(ignored, sampled) + _unit(scene)
        yield from _run(sampled, arguments, folder, "Repairing")
        report = program.read_report(answer)
        copies = []
        if report["written"] and not report["unchanged"]:
            for each in sampled:
                each.expect_unedited()
            with marks.paused(), motion.returning(scene):
                motion.set_time(scene, frames[0])
                for each, path in caches.items():
                    poses = repaired.read(path, each.vertex_count)[: len(times)]
                    if repaired.moved(each, poses):
                        copies.append(repaired.add(each, times, poses))
            repaired.show(context, copies, True)
            contacts.note_gone(scene, sampled, report["remaining"] + report["left"] + report["among_fixed"])
    text = _sentence(report["verdict"]["parts"], sampled, times) + left_out
    if not copies:
        return text
    made = _count(copies, "copy", "copies") if len(copies) > 3 else ", ".join(each.name for each in copies)
    return f"{text}. Made {made}, and hid {'the original' if len(copies) == 1 else 'the originals'}"


def _still_vertices(sampled, folder):
    """The option for vertices that may not move; none if all may."""
    if all(each.still is None for each in sampled):
        return []
    arguments = []
    for number, each in enumerate(sampled):
        path = folder / f"still-{number}.csv"
        np.savetxt(path, np.zeros(each.vertex_count) if each.still is None else each.still, fmt="%d")
        arguments += ["--fixed-vertices", str(path)]
    return arguments


def _count(things, one, many):
    return f"{len(things):,} {one if len(things) == 1 else many}"


def keyed_frames(objects):
    """Frames with a key of an object, its shape keys, its parents, or armatures and other objects of its modifiers."""
    frames = set()
    seen = set()

    def visit(datablock):
        if datablock is None or datablock in seen:
            return
        seen.add(datablock)
        for curve in curves_of(datablock):
            frames.update(round(point.co[0]) for point in curve.keyframe_points)
        if isinstance(datablock, bpy.types.Object):
            visit(datablock.parent)
            visit(getattr(datablock.data, "shape_keys", None))
            for modifier in datablock.modifiers:
                visit(getattr(modifier, "object", None))

    for scene_object in objects:
        visit(scene_object)
    return sorted(frames)


def train(context, executable):
    """Trains a model of every selected mesh from the frames that have keys."""
    scene, settings = context.scene, context.scene.foldproof
    objects = meshes_to_check(context)
    frames = keyed_frames(objects)
    if not frames:
        raise Problem("Nothing that moves these meshes has keyframes: key the poses to train from, or bake the motion")
    paths = [model_path(settings, name) for name in motion.file_names(objects)]
    try:
        paths[0].parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise Problem(f"{paths[0].parent} cannot be made: {error.strerror}") from error
    with tempfile.TemporaryDirectory(prefix="foldproof-") as name:
        folder = pathlib.Path(name)
        sampled = yield from motion.sample(scene, objects, frames, folder)
        for each, path in zip(sampled, paths):
            arguments = [executable, "train", each.path, "-o", str(path)]
            yield from _run(sampled, arguments, folder, f"Learning {each.object.name}")
    settings.use_models = True
    return f"Learned {_count(objects, 'mesh', 'meshes')} from {_count(frames, 'pose', 'poses')}"
