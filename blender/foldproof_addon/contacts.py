"""The contacts that a check found: a list in the scene, markers on the timeline and vertex groups, the worst first."""

import math

import bpy
import numpy as np
from bpy.props import BoolProperty, FloatProperty, FloatVectorProperty, IntProperty, StringProperty

from . import marks, motion

PREFIX = marks.PREFIX

LISTED = 50  # contacts that get markers and vertex groups, the worst
CROSSING = 0.5  # weight of vertices of faces that cross; those of faces that are inside have 1


class FoldproofContact(bpy.types.PropertyGroup):
    """What two parts do, once or several times. Its name is that of both. Times are frames of the scene, with fractions
    between them; depth, place and the worst frame are those of the worst time."""

    first: FloatProperty()
    last: FloatProperty()
    worst: FloatProperty()
    often: StringProperty()  # "4 times"; empty: once
    crosses: BoolProperty()  # else it only touches between frames
    may_cross: BoolProperty()  # it is not known
    has_depth: BoolProperty()
    depth: FloatProperty()
    at_least: BoolProperty()  # it is a lower bound
    curve_length: FloatProperty()
    point: FloatVectorProperty(size=3)
    size: FloatProperty()  # of its box

    def frames(self):
        return f"{self.first:.4g}" if self.first == self.last else f"{self.first:.4g}-{self.last:.4g}"

    def how_bad(self, units):
        if not self.crosses:
            return "touches, may cross" if self.may_cross else "touches"
        length = self.depth if self.has_depth else self.curve_length
        text = bpy.utils.units.to_string(units.system, "LENGTH", length * units.scale_length, precision=2)
        text = f"{text} {'deep' if self.has_depth else 'long'}"
        return f"at least {text}" if self.at_least else text


def store(scene, sampled, found, unknown_frames, times):
    """Replaces the contacts of an earlier check. `found`: as in the report; `unknown_frames`: how many there are of which it
    is not known what crosses; `times`: frame of the scene of each pose."""
    clear(scene)
    groups = {}
    for contact in found:  # the worst first
        groups.setdefault(contact["group"], []).append(contact)
    frame = lambda time: float(np.interp(time, range(len(times)), times))
    for number, each in enumerate(groups.values()):
        made = scene.foldproof.contacts.add()
        _describe(made, sampled, each, unknown_frames, frame)
        if number < LISTED:
            for contact in each[:LISTED]:
                _put_markers(scene, made.name, frame(contact["first_time"]), frame(_worst_time(contact)))
            _put_groups(sampled, each[0], made.name)


def _worst_time(contact):
    return contact["first_time"] if contact["worst"] is None else contact["worst"]


def _describe(made, sampled, group, unknown_frames, frame):
    worst = group[0]
    made.name = _name_of(worst, sampled)
    ends = []
    for contact in group:
        ends += [f["time"] for f in contact["frames"]] or [contact["first_time"], contact["last_time"]]
    made.first, made.last, made.worst = frame(min(ends)), frame(max(ends)), frame(_worst_time(worst))
    made.often = worst["often"]
    made.crosses = not worst["touching"]
    made.may_cross = not worst["frames"] and unknown_frames > 0
    made.has_depth = worst["depth"] is not None
    made.depth = worst["depth"] or 0
    made.at_least = worst["at_least"]
    made.curve_length = max((f["curve_length"] for f in worst["frames"]), default=0)
    made.point = worst["point"]
    made.size = float(np.ptp(worst["box"], axis=0).max())


def _name_of(contact, sampled):
    """The two vertex groups or objects."""
    names = motion.display_names(sampled)
    a, b = (names.get(side["name"], side["name"]) for side in contact["sides"])
    if a != b:
        return f"{a} - {b}"
    one = contact["sides"][0]["object"] == contact["sides"][1]["object"]
    return f"{a} with {'itself' if one else 'another'}"


def _put_markers(scene, name, begin, worst):
    first, worst = math.floor(begin), math.floor(worst)
    if worst == first:
        scene.timeline_markers.new(f"{PREFIX}{name}", frame=first)
    else:
        scene.timeline_markers.new(f"{PREFIX}{name}, begins", frame=first)
        scene.timeline_markers.new(f"{PREFIX}{name}, worst", frame=worst)


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
    scene.foldproof.contact = -1
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
