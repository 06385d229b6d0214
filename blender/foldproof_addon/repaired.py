"""Repaired motions as objects of the scene: copies whose shape keys are the frames."""

import bpy
import numpy as np

from . import marks, motion
from .compatibility import curves_of


def add(sampled, times, cache):
    """Adds a copy of an object, as it is at the scene's current frame, that moves as the point cache says. A shape key for
    each time, in world space; straight lines between them, as in the proof."""
    original = sampled.object
    depsgraph = bpy.context.evaluated_depsgraph_get()
    mesh = bpy.data.meshes.new_from_object(
        original.evaluated_get(depsgraph), preserve_all_data_layers=True, depsgraph=depsgraph
    )
    marks.clear(mesh)
    mesh.name = f"{original.data.name} repaired"
    made = bpy.data.objects.new(f"{original.name} repaired", mesh)
    for group in [g for g in made.vertex_groups if g.name.startswith(marks.PREFIX)]:
        made.vertex_groups.remove(group)
    for collection in original.users_collection:
        collection.objects.link(made)
    poses = _read(cache, sampled.vertex_count)[: len(times)]
    mesh.vertices.foreach_set("co", poses[0].ravel())
    if len(times) > 1:
        _key(made, times, poses)
    mesh.update()
    return made


def _read(cache, vertex_count):
    """Positions of a PC2: frames x vertices x 3, single precision."""
    return np.fromfile(cache, "<f4", offset=32).reshape(-1, vertex_count, 3)


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


def show_instead(context, sampled, copies, colliders):
    """Hides the objects that were repaired, and selects their copies and the colliders, for the next check."""
    for each in sampled:
        each.object.select_set(False)
        each.object.hide_set(True)
        each.object.hide_render = True
    for each in copies + colliders:
        each.select_set(True)
    context.view_layer.objects.active = copies[0]
