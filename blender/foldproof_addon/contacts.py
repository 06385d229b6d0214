"""The contacts that a check found: a list in the scene, markers on the timeline and vertex groups, the worst first."""

import math

import bpy
import numpy as np
from bpy.props import BoolProperty, FloatProperty, FloatVectorProperty, IntProperty

from . import motion

PREFIX = "Foldproof: "  # of markers and vertex groups
LISTED = 50  # contacts that get markers and vertex groups, the worst
CROSSING = 0.5  # weight of vertices of faces that cross; those of faces that are inside have 1


class FoldproofContact(bpy.types.PropertyGroup):
    """Its name is that of both objects. Times are frames of the scene, with fractions between them."""

    first: FloatProperty()
    last: FloatProperty()
    worst: FloatProperty()
    crosses: BoolProperty()  # else it only touches between frames
    may_cross: BoolProperty()  # it is not known
    has_depth: BoolProperty()
    depth: FloatProperty()
    curve_length: FloatProperty()
    point: FloatVectorProperty(size=3)
    size: FloatProperty()  # of its box

    def frames(self):
        return f"{self.first:.4g}" if self.first == self.last else f"{self.first:.4g}-{self.last:.4g}"

    def how_bad(self, units):
        if not self.crosses:
            return "touches, may cross" if self.may_cross else "touches"
        length = self.depth if self.has_depth else self.curve_length
        text = bpy.utils.units.to_string(units.system, "LENGTH", length * units.scale_length, precision=4)
        return f"{text} {'deep' if self.has_depth else 'long'}"


def store(scene, sampled, found, unknown_frames, times):
    """Replaces the contacts of an earlier check. `found`: as in the report; `unknown_frames`: how many there are of which it
    is not known what crosses; `times`: frame of the scene of each pose."""
    clear(scene)
    for number, contact in enumerate(found):
        made = scene.foldproof.contacts.add()
        objects = [sampled[side["object"]].object for side in contact["sides"]]
        made.name = f"{objects[0].name} - {objects[1].name}" if objects[0] != objects[1] else f"{objects[0].name} with itself"
        crossing = [frame["time"] for frame in contact["frames"]] or [contact["first_time"], contact["last_time"]]
        worst = contact["first_time"] if contact["worst"] is None else contact["worst"]
        made.first, made.last, made.worst = np.interp([crossing[0], crossing[-1], worst], range(len(times)), times)
        made.crosses = bool(contact["frames"])
        made.may_cross = not made.crosses and unknown_frames > 0
        made.has_depth = contact["depth"] is not None
        made.depth = contact["depth"] or 0
        made.curve_length = max((frame["curve_length"] for frame in contact["frames"]), default=0)
        made.point = contact["point"]
        made.size = float(np.ptp(contact["box"], axis=0).max())
        if number < LISTED:
            begin = float(np.interp(contact["first_time"], range(len(times)), times))
            _put_markers(scene, made, begin)
            _put_groups(sampled, contact, made.name)


def _put_markers(scene, contact, begin):
    first, worst = math.floor(begin), math.floor(contact.worst)
    if worst == first:
        scene.timeline_markers.new(f"{PREFIX}{contact.name}", frame=first)
    else:
        scene.timeline_markers.new(f"{PREFIX}{contact.name}, begins", frame=first)
        scene.timeline_markers.new(f"{PREFIX}{contact.name}, worst", frame=worst)


def _put_groups(sampled, contact, name):
    """A vertex group per side with what crosses and is inside in the worst frame."""
    for side in contact["sides"]:
        each = sampled[side["object"]]
        weights = {}
        for triangles, weight in ((side["triangles"], CROSSING), (side["inside"], 1.0)):
            for polygon in set(each.polygon_of[triangles].tolist()) - {-1}:
                weights.update(dict.fromkeys(each.object.data.polygons[polygon].vertices, weight))
        if weights:
            groups = each.object.vertex_groups
            active = groups.active_index
            group = groups.new(name=f"{PREFIX}{name}")
            for weight in (CROSSING, 1.0):
                group.add([v for v, w in weights.items() if w == weight], weight, "REPLACE")
            groups.active_index = max(active, 0)


def clear(scene):
    """Removes the list, the markers and the vertex groups."""
    scene.foldproof.contacts.clear()
    scene.foldproof["contact"] = -1  # not by the property, which would show a contact
    for marker in [m for m in scene.timeline_markers if m.name.startswith(PREFIX)]:
        scene.timeline_markers.remove(marker)
    for scene_object in bpy.data.objects:
        for group in [g for g in scene_object.vertex_groups if g.name.startswith(PREFIX)]:
            scene_object.vertex_groups.remove(group)


def show(settings, context):
    """Goes to the worst frame of the active contact, and aims the 3D views at it."""
    if not 0 <= settings.contact < len(settings.contacts):
        return
    contact = settings.contacts[settings.contact]
    motion.set_time(context.scene, contact.worst)
    for area in context.screen.areas if context.screen else ():
        if area.type == "VIEW_3D":
            aim(area.spaces.active.region_3d, contact)


def aim(view, contact):
    if view.view_perspective == "CAMERA":
        view.view_perspective = "PERSP"
    view.view_location = contact.point
    view.view_distance = max(3 * contact.size, 1e-3)
