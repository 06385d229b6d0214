"""Settings, buttons and the panel in the sidebar."""

import re
import time

import bpy
from bpy.props import BoolProperty, CollectionProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty, StringProperty

from . import contacts, jobs, marks, program, repaired
from .compatibility import blend_path_options
from .problem import Problem

REDRAW = 0.2  # seconds of reading frames between two redraws, which may take longer than a frame
_running = None  # the status text of the running job


class FoldproofPreferences(bpy.types.AddonPreferences):
    bl_idname = __package__

    program: StringProperty(
        name="Program",
        description="The program foldproof; empty: the one in this add-on, or else in PATH",
        subtype="FILE_PATH",
    )

    def draw(self, _context):
        self.layout.prop(self, "program")


class FoldproofSettings(bpy.types.PropertyGroup):
    kind: EnumProperty(
        name="Look For",
        items=[
            ("MOTION", "Contacts in motion", "Faces that cross in the first frame, and all contacts from there on"),
            ("POSES", "Crossings in frames", "Faces that cross in each frame, ignoring the motion between frames"),
        ],
    )
    pairs: EnumProperty(
        name="Among",
        items=[
            ("ALL", "All", "Within each mesh and between meshes"),
            ("WITHIN", "Within each", "Each mesh with itself"),
            ("BETWEEN", "Between", "Different meshes with each other"),
        ],
    )
    ignore_a: PointerProperty(name="Ignore", description="Pairs of this object and the next are not tested", type=bpy.types.Object)
    ignore_b: PointerProperty(name="With", description="The same object twice: not with itself", type=bpy.types.Object)
    thickness: FloatProperty(
        name="Thickness", description="Anything closer than this counts as a collision", min=0, unit="LENGTH", precision=4
    )
    samples: IntProperty(
        name="Substeps",
        description="Poses sampled per frame; between them vertices move along straight lines",
        default=1,
        min=1,
        max=100,
    )
    use_models: BoolProperty(name="Use Models", description="Check faster with trained models; the answer is the same")
    folder: StringProperty(name="Models", description="The folder of models", subtype="DIR_PATH", default="//foldproof/", options=blend_path_options())
    message: StringProperty()
    contacts: CollectionProperty(type=contacts.FoldproofContact)
    contact: IntProperty(name="Contact", description="Shows the contact at its worst frame", update=contacts.show)


def executable_of(context):
    addon = context.preferences.addons.get(__package__)
    return program.find(bpy.path.abspath(addon.preferences.program) if addon else "")


class Job:
    """An operator that runs in small steps; Esc cancels it. From scripts and without a window it runs to its end."""

    bl_options = {"UNDO"}

    @classmethod
    def poll(cls, context):
        if _running is not None:
            cls.poll_message_set("Foldproof is running; Esc cancels")
            return False
        if not any(o.type == "MESH" for o in context.selected_objects):
            cls.poll_message_set("Select meshes first")
            return False
        return True

    def execute(self, context):
        try:
            steps = self.start(context, executable_of(context))
            while True:
                progress = next(steps)
                if not progress.needs_scene:
                    time.sleep(0.01)
        except StopIteration as done:
            return self.finish(context, "INFO", done.value)
        except Problem as problem:
            return self.finish(context, "ERROR", str(problem))

    def invoke(self, context, _event):
        if bpy.app.background:
            return self.execute(context)
        try:
            self.steps = self.start(context, executable_of(context))
        except Problem as problem:
            return self.finish(context, "ERROR", str(problem))
        self.needs_scene = True
        set_status("Starting")
        context.window_manager.progress_begin(0, 100)
        self.timer = context.window_manager.event_timer_add(0.02, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type == "ESC":
            self.steps.close()
            return self.end(context, "WARNING", "Cancelled: nothing was changed")
        if event.type != "TIMER":
            return {"RUNNING_MODAL"} if self.needs_scene else {"PASS_THROUGH"}
        try:
            begin = time.monotonic()
            progress = next(self.steps)
            while progress.needs_scene and time.monotonic() - begin < REDRAW:
                progress = next(self.steps)
        except StopIteration as done:
            return self.end(context, "INFO", done.value)
        except Problem as problem:
            return self.end(context, "ERROR", str(problem))
        except ReferenceError:
            return self.end(context, "ERROR", "An object was removed meanwhile: start again")
        except BaseException:
            self.end(context, "ERROR", "Foldproof failed: see the console")
            raise
        self.needs_scene = progress.needs_scene
        set_status(progress.text)
        context.window_manager.progress_update(100 * progress.fraction)
        redraw(context)
        return {"RUNNING_MODAL"}

    def cancel(self, _context):
        """The window was closed."""
        self.steps.close()
        set_status(None)

    def end(self, context, level, text):
        set_status(None)
        context.window_manager.event_timer_remove(self.timer)
        context.window_manager.progress_end()
        return self.finish(context, level, text)

    def finish(self, context, level, text):
        context.scene.foldproof.message = text
        self.report({level}, text)
        redraw(context)
        return {"FINISHED"} if level == "INFO" else {"CANCELLED"}


def set_status(text):
    global _running
    _running = text


def redraw(context):
    for area in context.screen.areas if context.screen else ():
        if area.type == "VIEW_3D":
            area.tag_redraw()


class FOLDPROOF_OT_check(Job, bpy.types.Operator):
    """Find every collision of the selected meshes over the frame range"""

    bl_idname = "foldproof.check"
    bl_label = "Check Frame Range"

    def start(self, context, executable):
        return jobs.check(context, executable)


class FOLDPROOF_OT_repair(Job, bpy.types.Operator):
    """Make copies of the selected meshes that touch nothing over the frame range, near what they were"""

    bl_idname = "foldproof.repair"
    bl_label = "Repair All"

    def start(self, context, executable):
        return jobs.repair(context, executable)


class FOLDPROOF_OT_repair_contact(Job, bpy.types.Operator):
    """Make copies of the selected meshes in which this contact is gone over the frame range, and all others are left"""

    bl_idname = "foldproof.repair_contact"
    bl_label = "Repair Only This"

    @classmethod
    def poll(cls, context):
        contact = contacts.active(context.scene.foldproof)
        if not contact:
            cls.poll_message_set("Choose a contact in the list first")
            return False
        if contact.gone:
            cls.poll_message_set("It is gone; check again to see what the copies do")
            return False
        return super().poll(context)

    def start(self, context, executable):
        return jobs.repair(context, executable, contacts.active(context.scene.foldproof))


class FOLDPROOF_OT_before_after(bpy.types.Operator):
    """Show the originals of all repaired copies in their place, or the copies again"""

    bl_idname = "foldproof.before_after"
    bl_label = "Before or After Repair"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return _running is None and context.mode == "OBJECT" and bool(repaired.copies_of(context.view_layer))

    def execute(self, context):
        copies = repaired.copies_of(context.view_layer)
        repaired.show(context, copies, not repaired.are_shown(copies))
        return {"FINISHED"}


class FOLDPROOF_OT_train(Job, bpy.types.Operator):
    """Train models that speed up checks, from the keyed poses of the selected meshes"""

    bl_idname = "foldproof.train"
    bl_label = "Train from Keyed Poses"

    def start(self, context, executable):
        return jobs.train(context, executable)


class FOLDPROOF_OT_select(bpy.types.Operator):
    """Select the faces that are inside something at this frame or cross it, or meet something before the next"""

    bl_idname = "foldproof.select"
    bl_label = "Select Colliding Faces"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return context.mode == "OBJECT"

    def execute(self, context):
        for mesh in {o.data for o in context.selected_objects if o.type == "MESH"}:
            for part in (mesh.vertices, mesh.edges, mesh.polygons):
                part.foreach_set("select", [False] * len(part))
            for found in (marks.inside(mesh, context.scene.frame_current), marks.meeting(mesh, context.scene.frame_current)):
                for polygon in found:
                    mesh.polygons[polygon].select = True
            mesh.update()
        context.tool_settings.mesh_select_mode = (False, False, True)
        return {"FINISHED"}


class FOLDPROOF_OT_clear(bpy.types.Operator):
    """Remove Foldproof's data from this file: contacts, their markers and vertex groups, marks on faces and colors"""

    bl_idname = "foldproof.clear"
    bl_label = "Clear Marks"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return _running is None and context.mode == "OBJECT"

    def execute(self, context):
        for mesh in bpy.data.meshes:
            if marks.RESULTS in mesh:
                marks.clear(mesh)
        contacts.clear(context.scene)
        context.scene.foldproof.message = ""
        for area in context.screen.areas if context.screen else ():
            if area.type == "VIEW_3D":
                marks.color(area.spaces.active.shading, False)
        return {"FINISHED"}


class FOLDPROOF_UL_contacts(bpy.types.UIList):
    def draw_item(self, context, layout, _data, contact, _icon, _active_data, _active_property, _index=0, _flag=0):
        row = layout.split(factor=0.66)
        row.label(text=shortened(contact.name, int(0.7 * letters_of(context))))
        size = contact.size_text(context.scene.unit_settings) if contact.crosses else "touches"
        row.label(text="gone" if contact.gone else size)


class FOLDPROOF_PT_panel(bpy.types.Panel):
    bl_label = "Foldproof"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Foldproof"

    def draw(self, context):
        layout, settings = self.layout, context.scene.foldproof
        layout.use_property_split = True
        layout.use_property_decorate = False
        layout.prop(settings, "kind", text="")
        layout.prop(settings, "pairs")
        layout.prop(settings, "ignore_a")
        layout.prop(settings, "ignore_b")
        if settings.kind == "MOTION":
            layout.prop(settings, "thickness")
            layout.prop(settings, "samples")
        layout.operator("foldproof.check", icon="PLAY")
        try:
            executable_of(context)
        except Problem as problem:
            wrapped(layout, str(problem), "ERROR", context)
        if _running is not None:
            wrapped(layout, f"{_running}. Esc cancels", "TIME", context)
        elif settings.message:
            wrapped(layout, settings.message, "INFO", context)
        if settings.contacts:
            rows = min(max(len(settings.contacts), 2), 6)
            layout.template_list("FOLDPROOF_UL_contacts", "", settings, "contacts", settings, "contact", rows=rows)
        contact = contacts.active(settings)
        if contact:
            wrapped(layout, contact.in_words(context.scene.unit_settings), "NONE", context)
        column = layout.column(align=True)
        column.operator("foldproof.repair", icon="MODIFIER")
        only = "Repair Only These" if contacts.are_several(settings) else "Repair Only This"
        column.operator("foldproof.repair_contact", text=only, icon="MODIFIER")
        if copies := repaired.copies_of(context.view_layer):
            text = "Show Before" if repaired.are_shown(copies) else "Show After"
            layout.operator("foldproof.before_after", text=text, icon="HIDE_OFF")


class Below:
    """Where a panel is that can be folded away."""

    bl_parent_id = "FOLDPROOF_PT_panel"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"


class FOLDPROOF_PT_still(Below, bpy.types.Panel):
    bl_label = "May Not Move"

    def draw(self, context):
        layout = self.layout
        for each in sorted((o for o in context.selected_objects if o.type == "MESH"), key=lambda o: o.name):
            column = layout.column(align=True)
            column.prop(each, "foldproof_collider", text=each.name)
            if each.vertex_groups and not each.foldproof_collider:
                column.prop_search(each, "foldproof_still", each, "vertex_groups", text="")
        contact = contacts.active(context.scene.foldproof)
        for part, still in contact.parts() if contact else ():
            layout.prop(contact, still, text=getattr(contact, part))


class FOLDPROOF_PT_marks(Below, bpy.types.Panel):
    bl_label = "Marks"

    def draw(self, _context):
        layout = self.layout
        row = layout.row(align=True)
        row.operator("screen.marker_jump", text="Previous", icon="PREV_KEYFRAME").next = False
        row.operator("screen.marker_jump", text="Next", icon="NEXT_KEYFRAME").next = True
        layout.operator("foldproof.select", icon="RESTRICT_SELECT_OFF")
        layout.operator("foldproof.clear", icon="TRASH")


class FOLDPROOF_PT_models(Below, bpy.types.Panel):
    bl_label = "Models"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout, settings = self.layout, context.scene.foldproof
        layout.use_property_split = True
        layout.use_property_decorate = False
        layout.prop(settings, "use_models")
        layout.prop(settings, "folder")
        layout.operator("foldproof.train", icon="ARMATURE_DATA")


def letters_of(context):
    """How many fit into a line of the panel, beside an icon, the margins and the tabs."""
    width = context.region.width / (context.preferences.system.ui_scale or 1)  # 0 without a window
    return max(16, int((width - 70) / 6.5))


def shortened(names, letters):
    """Two names, "A - B", of which each keeps its beginning and its end; or another text."""
    sides = names.split(" - ", 1) if len(names) <= letters else re.split(r" - | with (?=itself$)", names, 1)
    room = letters - 3 * (len(sides) - 1)
    lengths = [min(len(side), max(room // len(sides), room - sum(map(len, sides)) + len(side))) for side in sides]
    middle = lambda text, n: text if len(text) <= n else f"{text[: n - 1 - n // 2]}\N{HORIZONTAL ELLIPSIS}{text[len(text) - n // 2 :]}"
    return " - ".join(map(middle, sides, lengths))


def wrapped(layout, text, icon, context):
    """A label with line breaks; Blender truncates long labels."""
    letters = letters_of(context)
    lines = [""]
    for word in re.findall(rf"\S{{1,{letters}}}", text):
        if len(lines[-1]) + len(word) > letters:
            lines.append("")
        lines[-1] += word + " "
    column = layout.column(align=True)
    for i, line in enumerate(lines):
        column.label(text=line, icon=icon if i == 0 or icon == "NONE" else "BLANK1")


_classes = (
    FoldproofPreferences,
    contacts.FoldproofContact,
    FoldproofSettings,
    FOLDPROOF_OT_check,
    FOLDPROOF_OT_repair,
    FOLDPROOF_OT_repair_contact,
    FOLDPROOF_OT_before_after,
    FOLDPROOF_OT_train,
    FOLDPROOF_OT_select,
    FOLDPROOF_OT_clear,
    FOLDPROOF_UL_contacts,
    FOLDPROOF_PT_panel,
    FOLDPROOF_PT_still,
    FOLDPROOF_PT_marks,
    FOLDPROOF_PT_models,
)


def register():
    for each in _classes:
        bpy.utils.register_class(each)
    bpy.types.Scene.foldproof = PointerProperty(type=FoldproofSettings)
    bpy.types.Object.foldproof_still = StringProperty(
        name="Vertex Group", description="Repair leaves vertices of this group as they are whose weight is above 0.5"
    )
    bpy.types.Object.foldproof_original = PointerProperty(type=bpy.types.Object)
    bpy.types.Object.foldproof_collider = BoolProperty(
        name="May Not Move", description="Repair moves others away from this object, and leaves it as it is"
    )


def unregister():
    del bpy.types.Object.foldproof_collider
    del bpy.types.Object.foldproof_original
    del bpy.types.Object.foldproof_still
    del bpy.types.Scene.foldproof
    for each in reversed(_classes):
        bpy.utils.unregister_class(each)
