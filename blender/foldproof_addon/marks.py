"""Results of checks, stored in the file with each mesh and shown at the scene's current frame."""

import contextlib

import bpy
import numpy as np
from bpy.app.handlers import persistent

PREFIX = "Foldproof: "  # of markers and vertex groups
# A property of a mesh: its number of polygons, and by frame those that are inside something or cross it at the frame, and
# those that meet something before the next.
RESULTS = "foldproof"
COLLIDES = "foldproof_collides"  # face attribute, boolean: inside now
MEETS = "foldproof_meets"  # face attribute, boolean: meets something before the next frame
COLOR = "foldproof_color"  # color attribute
_RED, _PINK, _GREY = (0.8, 0.05, 0.02, 1.0), (0.6, 0.19, 0.39, 1.0), (0.6, 0.6, 0.6, 1.0)
_pauses = 0


@contextlib.contextmanager
def paused():
    """A context in which frame changes do not show marks."""
    global _pauses
    _pauses += 1
    try:
        yield
    finally:
        _pauses -= 1


def store(mesh, inside, meeting):
    """Stores the polygons by frame: that are inside or cross, and that meet others before the next one."""
    mesh[RESULTS] = {
        "polygons": len(mesh.polygons),
        "inside": {str(frame): sorted(polygons) for frame, polygons in inside.items() if polygons},
        "meeting": {str(frame): sorted(polygons) for frame, polygons in meeting.items() if polygons},
    }


def _stored(mesh, name, frame):
    """Indices of polygons; none if the mesh has changed since the check."""
    results = mesh.get(RESULTS)
    if not results or results["polygons"] != len(mesh.polygons) or name not in results:  # as in files of older versions
        return np.empty(0, np.int64)
    return np.array(list(results[name].get(str(frame), [])), np.int64)


def inside(mesh, frame):
    return _stored(mesh, "inside", frame)


def meeting(mesh, frame):
    return _stored(mesh, "meeting", frame)


def _set(mesh, name, polygons):
    marked = np.zeros(len(mesh.polygons), bool)
    marked[polygons] = True
    attribute = mesh.attributes.get(name) or mesh.attributes.new(name, "BOOLEAN", "FACE")
    attribute.data.foreach_set("value", marked)
    return marked


def _show(mesh, frame):
    meets = _set(mesh, MEETS, meeting(mesh, frame))
    marked = _set(mesh, COLLIDES, inside(mesh, frame))
    if COLOR not in mesh.color_attributes:
        mesh.color_attributes.new(COLOR, "BYTE_COLOR", "CORNER")
        mesh.color_attributes.active_color = mesh.color_attributes[COLOR]
    corners = np.empty(len(mesh.polygons), np.int32)
    mesh.polygons.foreach_get("loop_total", corners)
    # Corners are in the order of the polygons.
    by_polygon = np.where(meets[:, None], np.float32(_PINK), np.float32(_GREY))
    by_polygon[marked] = _RED
    colors = np.repeat(by_polygon, corners, axis=0)
    mesh.color_attributes[COLOR].data.foreach_set("color", np.ascontiguousarray(colors, np.float32).ravel())
    mesh.update()


# Runs before the frame's evaluation, so that the viewport and renders have the marks of this frame.
@persistent
def show(scene, _depsgraph=None):
    if _pauses:
        return
    for mesh in bpy.data.meshes:
        if RESULTS in mesh and not mesh.is_editmode:
            _show(mesh, scene.frame_current)


def color(shading, marks):
    """Colors of marks in a viewport in place of materials', or these again; leaves other colors that the user chose."""
    if shading.type == "SOLID" and shading.color_type == ("MATERIAL" if marks else "VERTEX"):
        shading.color_type = "VERTEX" if marks else "MATERIAL"


def clear(mesh):
    if RESULTS in mesh:
        del mesh[RESULTS]
    for name in (COLLIDES, MEETS, COLOR):
        if name in mesh.attributes:
            mesh.attributes.remove(mesh.attributes[name])
    mesh.update()


def register():
    bpy.app.handlers.frame_change_pre.append(show)


def unregister():
    bpy.app.handlers.frame_change_pre.remove(show)
