"""Repaired motions as objects of the scene: copies whose shape keys are the frames."""

import re

import bpy
import mathutils
import numpy as np

from . import marks, motion
from .compatibility import curves_of


def read(cache, vertex_count):
    """Positions of a PC2: frames x vertices x 3, single precision."""
    return np.fromfile(cache, "<f4", offset=32).reshape(-1, vertex_count, 3)


def moved(sampled, poses):
    """Whether the poses are others than those that were sampled."""
    return any(not np.array_equal(pose, before.astype("<f4")) for pose, before in zip(poses, sampled.poses()))


def add(sampled, times, poses):
    """Adds a copy of an object, as it is at the scene's current frame, with these poses, in world space. A shape key for
    each time; straight lines between them, as in the proof."""
    original = sampled.object
    depsgraph = bpy.context.evaluated_depsgraph_get()
    mesh = bpy.data.meshes.new_from_object(
        original.evaluated_get(depsgraph), preserve_all_data_layers=True, depsgraph=depsgraph
    )
    marks.clear(mesh)
    mesh.name = _name_of_copy(original.data, bpy.data.meshes)
    name = _name_of_copy(original, bpy.data.objects)
    made = original.copy()  # with its materials, its color, what sees it
    made.animation_data_clear()
    made.modifiers.clear()
    made.constraints.clear()
    made.parent = None
    made.matrix_world = mathutils.Matrix()
    made.data, made.name = mesh, name
    made.foldproof_original = original
    for group in [g for g in made.vertex_groups if g.name.startswith(marks.PREFIX)]:
        made.vertex_groups.remove(group)
    for collection in set(original.users_collection) - set(made.users_collection):
        collection.objects.link(made)
    if made.rigid_body:  # it is in the world of rigid bodies
        with bpy.context.temp_override(object=made, active_object=made):
            bpy.ops.rigidbody.object_remove()
    mesh.vertices.foreach_set("co", poses[0].ravel())
    if len(times) > 1:
        _key(made, times, poses)
    mesh.update()
    return made


def _name_of_copy(datablock, others):
    """A name that none of the others has; also for what is a copy already."""
    base = name = re.sub(r" repaired(\.\d+)?$", "", datablock.name) + " repaired"
    number = 0
    while name in others:
        number += 1
        name = f"{base}.{number:03}"
    return name


def _key(made, times, poses):
    for time, pose in zip(times, poses):
        made.shape_key_add(name=f"{time:g}", from_mix=False).data.foreach_set("co", pose.ravel())
    keys = made.data.shape_keys
    keys.use_relative = False
    for time, block in zip(times, keys.key_blocks):
        block.interpolation = "KEY_LINEAR"
        keys.eval_time = block.frame
        keys.keyframe_insert("eval_time", frame=time)
    for curve in curves_of(keys):
        for point in curve.keyframe_points:
            point.interpolation = "LINEAR"


def copies_of(view_layer):
    """The copies beside which there is their original, too."""
    return [o for o in view_layer.objects if o.foldproof_original and o.foldproof_original.name in view_layer.objects]


def are_shown(copies):
    return any(each.visible_get() for each in copies)


def show(context, copies, after):
    """Shows the copies and hides their originals, or the other way round, in renders, too. If something that it hides was
    selected, it selects all that it shows."""
    originals = [each.foldproof_original for each in copies]
    shown, hidden = (copies, originals) if after else (originals, copies)
    select = any(each.select_get() for each in hidden)
    for objects, hide in ((shown, False), (hidden, True)):  # last, for a copy's copy
        for each in objects:
            each.hide_render = hide
            each.hide_set(hide)
            each.select_set(not hide and select)
    for each in shown:
        if each.select_get():
            context.view_layer.objects.active = each
