"""The contacts that a check found: a list in the scene, markers on the timeline and vertex groups, the worst first."""

import math

import bpy
import mathutils
import numpy as np
from bpy.props import BoolProperty, FloatProperty, FloatVectorProperty, IntProperty, StringProperty

from . import marks, motion
from .problem import Problem

PREFIX = marks.PREFIX

LISTED = 50  # contacts that get markers and vertex groups, the worst
CROSSING = 0.5  # weight of vertices of faces that cross; those of faces that are inside have 1


class FoldproofContact(bpy.types.PropertyGroup):
    """What two parts do, once or several times. Its name is that of both. Times are frames of the scene, with fractions
    between them; depth, place and the worst frame are those of the worst time."""

    object_a: StringProperty()
    part_a: StringProperty()  # the vertex group; empty: the object has no parts
    object_b: StringProperty()
    part_b: StringProperty()
    named: BoolProperty()  # else there may be several of the same object with itself
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
    normal: FloatVectorProperty(size=3)  # the direction out
    size: FloatProperty()  # of its box
    still_a: BoolProperty(name="May Not Move", description="Repair leaves this part as it is")
    still_b: BoolProperty(name="May Not Move", description="Repair leaves this part as it is")
    gone: BoolProperty()  # a repair took it out, in copies of its objects

    def parts(self):
        """Its sides that are vertex groups, each once, as the names of properties: that of the group and that it is still."""
        one = (self.object_a, self.part_a) == (self.object_b, self.part_b)
        return [(f"part_{side}", f"still_{side}") for side in ("a" if one else "ab") if getattr(self, f"part_{side}")]

    def frames(self):
        return f"{self.first:.4g}" if self.first == self.last else f"{self.first:.4g}-{self.last:.4g}"

    def size_text(self, units):
        length = self.depth if self.has_depth else self.curve_length
        return bpy.utils.units.to_string(units.system, "LENGTH", length * units.scale_length, precision=2)

    def how_bad(self, units):
        if not self.crosses:
            return "touches, may cross" if self.may_cross else "touches"
        text = f"{self.size_text(units)} {'deep' if self.has_depth else 'long'}"
        return f"at least {text}" if self.at_least else text

    def in_words(self, units):
        often = f", {self.often}" if self.often else ""
        where = "frame" if self.first == self.last else "frames"
        return f"{self.name}: {where} {self.frames()}{often}, {self.how_bad(units)}{', gone after repair' if self.gone else ''}"


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
    (made.object_a, made.part_a), (made.object_b, made.part_b) = (_side(sampled[s["object"]], s["name"]) for s in worst["sides"])
    made.named = worst["named"]
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
    made.point, made.normal = worst["point"], worst["normal"]
    made.size = float(np.ptp(worst["box"], axis=0).max())


def _side(each, name):
    """The names of the object and the vertex group, empty if it has no parts."""
    return each.object.name, next((part for part, written in each.part_names.items() if written == name), "")


def note_gone(scene, sampled, still):
    """Notes which contacts of the list are gone. `still`: those that are not, as in the report of a repair."""
    pairs = []
    for contact in still:
        sides = [(sampled[side["object"]], side["name"]) for side in contact["sides"]]
        pairs.append({name if each.part_names else str(each.path) for each, name in sides})
    for contact in scene.foldproof.contacts:
        try:
            contact.gone = set(names_in_files(contact, sampled)) not in pairs
        except Problem:
            pass  # of other objects


def names_in_files(contact, sampled):
    """The two names that the program knows the sides of a contact by."""
    names = []
    for scene_object, part in ((contact.object_a, contact.part_a), (contact.object_b, contact.part_b)):
        each = next((e for e in sampled if scene_object in (e.object.name, motion.first_original(e.object).name)), None)
        if each is None:
            raise Problem(f"{scene_object} is not selected: select it, or check what is selected")
        if part and part not in each.part_names:
            raise Problem(f"{scene_object} has no faces of {part} any more: check again")
        names.append(each.part_names[part] if part else str(each.path))
    return names


def active(settings):
    """The contact that is chosen in the list, or None."""
    return settings.contacts[settings.contact] if 0 <= settings.contact < len(settings.contacts) else None


def still_parts(settings, sampled):
    """Names in files of the parts of the active contact that may not move."""
    contact = active(settings)
    if not contact or not any(getattr(contact, still) for _, still in contact.parts()):
        return []
    names = dict(zip(("still_a", "still_b"), names_in_files(contact, sampled)))
    return [names[still] for _, still in contact.parts() if getattr(contact, still)]


def are_several(settings):
    """Whether the program repairs more contacts than the active one by its names: those of an object without parts with
    itself."""
    contact = active(settings)
    return bool(contact) and not contact.named and sum(each.name == contact.name for each in settings.contacts) > 1


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
    """Goes to the worst frame of the active contact, and aims the 3D views at it, with marks in color."""
    contact = active(settings)
    if not contact:
        return
    motion.set_time(context.scene, contact.worst)
    for area in context.screen.areas if context.screen else ():
        if area.type == "VIEW_3D":
            aim(area.spaces.active.region_3d, contact)
            marks.color(area.spaces.active.shading, True)


def aim(view, contact):
    if view.view_perspective == "CAMERA":
        view.view_perspective = "PERSP"
    out = mathutils.Vector(contact.normal)
    to_viewer = mathutils.Quaternion(view.view_rotation) @ mathutils.Vector((0, 0, 1))
    if out.dot(to_viewer) < 0.5:  # it is seen from behind, or from the side
        view.view_rotation = out.to_track_quat("Z", "Y")
    view.view_location = contact.point
    view.view_distance = max(4 * contact.size, 1e-3)
