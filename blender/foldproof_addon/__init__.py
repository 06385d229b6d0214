"""Blender add-on: finds every collision of the selected meshes over the frame range, with the program foldproof.

They communicate by files (NPZ and JSON), so nothing has to be built for Blender's Python. Docs: docs/studios.md.
"""

bl_info = {
    "name": "Foldproof",
    "author": "The Foldproof authors",
    "version": (0, 2, 0),
    "blender": (3, 4, 0),
    "location": "3D View > Sidebar > Foldproof",
    "description": "Finds every collision of moving meshes, between frames too",
    "category": "Animation",
}

from . import interface, marks


def register():
    interface.register()
    marks.register()


def unregister():
    marks.unregister()
    interface.unregister()
