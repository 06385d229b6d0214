"""What the compiled classes have from Python: text, HTML, equality, copies, and motions from other libraries' meshes."""

from __future__ import annotations

import os
import tempfile
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _core
from ._core import (
    Candidates, CollisionMesh, ContactChecker, Hierarchy, Model, Motion, ReducedShape, StaticResult, StepResult, load,
)  # fmt: skip
from ._errors import Error
from ._text import html_table, many

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray


def _motion_from_arrays(vertices: ArrayLike, faces: ArrayLike, name: str = "array") -> Motion:
    """From vertices, F x V x 3 or V x 3 for one pose, mesh units, and faces, T x 3 vertex ids, or T x 4 of quads, which
    are cut into triangles.

    As Motion(triangles, frames), in the order of other libraries. Error: other shapes, ids beyond V, numbers that are not
    finite.
    """
    return Motion(_triangles_of(faces), vertices, name)


def _motion_from_meshes(meshes: Any, name: str = "meshes") -> Motion:
    """From a mesh of trimesh (vertices, faces) or meshio (points, cells), or from a list of them, one per frame.

    Error: what is no such mesh; meshes with other faces than the first.
    """
    poses = list(meshes) if isinstance(meshes, (list, tuple)) else [meshes]
    if not poses:
        raise Error("meshes", "are none", "give at least one")
    vertices, faces = zip(*map(_arrays_of, poses))
    for k, each in enumerate(faces):
        if not np.array_equal(each, faces[0]):
            raise Error(f"meshes[{k}]", "has other faces than the first", "give poses of one mesh")
    return Motion(faces[0], np.stack(vertices), name)


def _arrays_of(mesh: Any) -> tuple[NDArray[Any], NDArray[Any]]:
    """Vertices and triangles. By names, so that neither library has to be there."""
    if hasattr(mesh, "vertices") and hasattr(mesh, "faces"):
        return np.asarray(mesh.vertices), _triangles_of(mesh.faces)
    if hasattr(mesh, "points") and hasattr(mesh, "cells"):
        cells = [block for block in mesh.cells if not block.type.startswith(("vertex", "line"))]
        other = sorted({block.type for block in cells} - {"triangle", "quad"})
        if other:
            raise Error("mesh", f"has cells of type {', '.join(other)}", "give a surface of triangles and quads alone")
        flat = [_triangles_of(block.data) for block in cells]
        if not flat:
            raise Error("mesh", "has no cells of triangles or quads", "give a surface")
        return np.asarray(mesh.points), np.concatenate(flat)
    raise TypeError("expected a mesh with vertices and faces (trimesh) or points and cells (meshio), or a list of them")


def _triangles_of(faces: ArrayLike) -> NDArray[Any]:
    array = np.asanyarray(faces)  # keeps a mask, which is refused
    if array.ndim == 2 and array.shape[1] == 4:
        return array[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)
    return array


def _facts_of_motion(motion: Motion) -> dict[str, str]:
    counts = {"frames": len(motion), "vertices": motion.vertex_count, "triangles": len(motion.triangles)}
    if motion.parts is not None:
        counts["parts"] = len(np.unique(motion.parts))
    return {noun: f"{count:,}" for noun, count in counts.items()}


def _facts_of_model(model: Model) -> dict[str, str]:
    facts = {"poses": f"{len(model.poses):,}", "charts": f"{model.chart_count:,}", "proven": f"{100 * model.proven:.1f} %"}
    if model.learned:
        facts |= {"modes": f"{len(model.deviations):,}", "key points": f"{len(model.key_points):,}"}
    return facts | {"vertices": f"{model.hierarchy.vertex_count:,}", "triangles": f"{len(model.hierarchy.triangles):,}"}


def _line(kind: str, name: str, facts: dict[str, str]) -> str:
    return f"<foldproof.{kind}{f' {name!r}' if name else ''}: {', '.join(f'{v} {k}' for k, v in facts.items())}>"


def _table(kind: str, name: str, facts: dict[str, str]) -> str:
    return html_table([kind, name], list(facts.items()))


def _same_motion(a: Motion, b: object) -> Any:
    if not isinstance(b, Motion):
        return NotImplemented
    same_mesh = len(a) == len(b) and np.array_equal(a.triangles, b.triangles) and a.vertex_count == b.vertex_count
    return same_mesh and all(np.array_equal(x, y) for x, y in zip(a, b))


def _bytes_of(model: Model) -> bytes:
    with tempfile.TemporaryDirectory(prefix="foldproof-") as folder:
        path = os.path.join(folder, "model")
        model.save(path)
        with open(path, "rb") as file:
            return file.read()


def _model_of(content: bytes) -> Model:
    with tempfile.TemporaryDirectory(prefix="foldproof-") as folder:
        path = os.path.join(folder, "model")
        with open(path, "wb") as file:
            file.write(content)
        return load(path)


def _refuse_copy(thing: object, _protocol: int) -> None:
    raise TypeError(f"cannot pickle or copy a foldproof.{type(thing).__name__}")


def _same_model(a: Model, b: object) -> Any:
    return _bytes_of(a) == _bytes_of(b) if isinstance(b, Model) else NotImplemented


def _text_of_step(step: StepResult) -> str:
    label = "STATISTICAL: " if step.statistical else ""
    if step.clean:
        return f"<foldproof.StepResult: {label}nothing {'found' if label else 'collides'}>"
    found = f"{step.vertex_face_count:,} vertex-face and {step.edge_edge_count:,} edge-edge pairs"
    return f"<foldproof.StepResult: {label}{found}, the earliest at {step.earliest_toi:.4g}>"


def _text_of_pose(pose: StaticResult) -> str:
    label = "STATISTICAL: " if pose.statistical else ""
    return f"<foldproof.StaticResult: {label}{many(pose.crossing_count, 'crossing pair')}{' found' if label else ''}>"


def _text_of_hierarchy(hierarchy: Hierarchy) -> str:
    triangles, leaves = len(hierarchy.triangles), hierarchy.leaf_count
    return _line("Hierarchy", "", {"vertices": f"{hierarchy.vertex_count:,}", "triangles": f"{triangles:,}", "leaves": f"{leaves:,}"})


def _text_of_mesh(mesh: CollisionMesh) -> str:
    counts = {"vertices": mesh.vertex_count, "edges": len(mesh.edges), "faces": len(mesh.faces)}
    return _line("CollisionMesh", "", {noun: f"{count:,}" for noun, count in counts.items()})


def _text_of_candidates(found: Candidates) -> str:
    kinds = ("vertex_face", "edge_edge", "edge_vertex", "vertex_vertex")
    counts = {kind.replace("_", "-"): len(getattr(found, kind)) for kind in kinds}
    text = ", ".join(f"{count:,} {kind}" for kind, count in counts.items() if count)
    return f"<foldproof.Candidates: {text or 'no'} pairs>"


def _text_of_solver(checker: ContactChecker) -> str:
    mesh = checker.mesh
    return f"<foldproof.ContactChecker of {mesh.vertex_count:,} vertices and {len(mesh.faces):,} faces>"


def _text_of_shape(shape: ReducedShape) -> str:
    radius = f"radius {shape.radius():.4g} around the first of {many(len(shape.centers), 'center')}"
    return f"<foldproof.ReducedShape: {many(shape.modes, 'mode')}, clearance {shape.clearance:.3g}, {radius}>"


def _set(made: type, **members: Any) -> None:
    for name, member in members.items():
        setattr(made, name, member)


def complete_classes() -> None:
    """Called once, when the package is imported."""
    for made in vars(_core).values():
        if isinstance(made, type):
            _set(made, __reduce_ex__=_refuse_copy)
    _set(
        Motion,
        from_arrays=staticmethod(_motion_from_arrays),
        from_meshes=staticmethod(_motion_from_meshes),
        __repr__=lambda self: _line("Motion", self.name, _facts_of_motion(self)),
        _repr_html_=lambda self: _table("Motion", self.name, _facts_of_motion(self)),
        __eq__=_same_motion,
        __hash__=None,
        # Older protocols would make a Motion of nothing.
        __reduce_ex__=lambda self, protocol: object.__reduce_ex__(self, max(protocol, 2)),
    )
    _set(
        Model,
        __repr__=lambda self: _line("Model", self.name, _facts_of_model(self)),
        _repr_html_=lambda self: _table("Model", self.name, _facts_of_model(self)),
        __eq__=_same_model,
        __hash__=None,
        __reduce_ex__=lambda self, _protocol: (_model_of, (_bytes_of(self),)),
    )
    _set(Hierarchy, __repr__=_text_of_hierarchy)
    _set(CollisionMesh, __repr__=_text_of_mesh)
    _set(Candidates, __repr__=_text_of_candidates)
    _set(ContactChecker, __repr__=_text_of_solver)
    _set(ReducedShape, __repr__=_text_of_shape)
    _set(StepResult, __repr__=_text_of_step)
    _set(StaticResult, __repr__=_text_of_pose)
