"""Where Blender's Python API differs between 3.4 and 5.0. Everything else in this add-on is the same in all of them.

What needed no branch, because one way works everywhere: properties of bpy.props are set by their names only, as 5.0 keeps
them apart from custom properties (developer.blender.org/docs/release_notes/5.0/python_api, "Removal of (Unsupported) Access
to Runtime-Defined Properties Storage Data"); the add-on's own name is that of its package, as extensions of 4.2 are
bl_ext.REPOSITORY.ID (docs.blender.org/manual/en/4.2/advanced/extensions/addons.html, "Use __package__ for module names").
"""

import bpy


def curves_of(datablock, version=bpy.app.version):
    """The animation curves of a datablock.

    Since 4.4 they are in the channels that an action has for each slot; in 5.0 `Action.fcurves` is gone
    (developer.blender.org/docs/release_notes/4.4/upgrading/slotted_actions, "Accessing existing F-Curves";
    docs.blender.org/api/5.0/change_log.html, "bpy.types.Action").
    """
    animation = datablock.animation_data
    if not animation or not animation.action:
        return []
    if version < (4, 4, 0):
        return list(animation.action.fcurves)
    if not animation.action_slot:
        return []
    channels = [strip.channelbag(animation.action_slot) for layer in animation.action.layers for strip in layer.strips]
    return [curve for each in channels if each for curve in each.fcurves]


def blend_path_options(version=bpy.app.version):
    """Options of a path property that may begin with //, the folder of the .blend file.

    Since 4.5 Blender's file selector and its warnings expect paths without it, unless a property says so
    (docs.blender.org/api/4.5/bpy_types_enum_items/property_flag_items.html; change 137060 of projects.blender.org/blender/blender).
    """
    return {"PATH_SUPPORTS_BLEND_RELATIVE"} if version >= (4, 5, 0) else set()
