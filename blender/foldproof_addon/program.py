"""Finds and runs the program foldproof, and reads its answer."""

import json
import os
import shutil
import subprocess

import numpy as np

from .problem import Problem
from .progress import Progress


def find(path):
    """The program at `path`, or in PATH if that is empty."""
    if path:
        if os.path.isfile(path) and os.access(path, os.X_OK):
            return path
        raise Problem(f"'{path}' is not a program: correct it in Preferences > Add-ons > Foldproof")
    found = shutil.which("foldproof")
    if found:
        return found
    raise Problem(
        "The program foldproof was not found: install it, or say where it is in Preferences > Add-ons > Foldproof"
    )


def run(arguments, folder, text, fraction):
    """Runs the program and yields Progress; closing the generator ends the program. Returns its exit code, 0 or 1."""
    errors = folder / "errors.txt"
    with open(errors, "wb") as stream:
        try:
            process = subprocess.Popen(
                arguments, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=stream, cwd=folder
            )
        except OSError as error:
            raise Problem(f"{arguments[0]} cannot be started: {error.strerror}") from error
    try:
        while process.poll() is None:
            yield Progress(fraction, text, needs_scene=False)
    finally:
        if process.poll() is None:
            process.kill()  # it never leaves an incomplete report
        process.wait()
    if process.returncode not in (0, 1):
        lines = errors.read_text(errors="replace").strip().splitlines()
        raise Problem(lines[-1] if lines else f"{arguments[0]} ended with code {process.returncode} and no message")
    return process.returncode


class _Triangles:
    """Finds the triangles of an object that collide, including those around colliding vertices and edges."""

    def __init__(self, triangles, vertex_count):
        self._triangles = triangles
        self._count = vertex_count
        pairs = np.sort(np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2), axis=2).astype(np.int64)
        self._edges = pairs[..., 0] * vertex_count + pairs[..., 1]

    def around(self, faces, vertices, edges):
        marked = np.zeros(len(self._triangles), bool)
        marked[faces] = True
        hit = np.zeros(self._count, bool)
        hit[vertices] = True
        marked |= hit[self._triangles].any(axis=1)
        if edges:
            ends = np.array(edges, np.int64)
            marked |= np.isin(self._edges, ends[:, 0] * self._count + ends[:, 1]).any(axis=1)
        return np.flatnonzero(marked)


def read_answer(path, sampled):
    """Reads the crossings of the first frame, as (number of pairs, crossing triangles per object), the steps with
    collisions, as (step, number of collisions, earliest toi, colliding triangles per object), and the contacts, as they
    are in the report, and the number of frames of which it is not known what crosses."""
    try:
        report = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise Problem("The program gave no answer: see in Preferences > Add-ons > Foldproof that it is foldproof") from None
    if "contacts" not in report:
        raise Problem(
            "The program foldproof is too old for this add-on: install its version, or say where that is in"
            " Preferences > Add-ons > Foldproof"
        )
    objects = [_Triangles(each.triangles, each.vertex_count) for each in sampled]
    steps = []
    for number, step in enumerate(report["steps"]):
        count = sum(step["collisions"].values())
        if count == 0:
            continue
        faces, vertices, edges = ([[] for _ in objects] for _ in range(3))
        for vertex_object, vertex, face_object, face, _ in step["pairs"]["vf"]:
            vertices[vertex_object].append(vertex)
            faces[face_object].append(face)
        for a, a0, a1, b, b0, b1, _ in step["pairs"]["ee"]:
            edges[a].append((a0, a1))
            edges[b].append((b0, b1))
        for a, face_a, b, face_b in step["pairs"].get("tt", []):
            faces[a].append(face_a)
            faces[b].append(face_b)
        marked = [each.around(*found) for each, *found in zip(objects, faces, vertices, edges)]
        steps.append((number, count, step["earliest_toi"], marked))
    return _start_of(report, len(objects)), steps, report["contacts"], report["totals"]["contacts"]["unknown_frames"]


def _start_of(report, objects):
    faces = [set() for _ in range(objects)]
    start = report.get("start")  # none with --static
    for a, face_a, b, face_b in start["pairs"]["tt"] if start else ():
        faces[a].add(face_a)
        faces[b].add(face_b)
    return start["crossings"] if start else 0, [np.array(sorted(each), np.int64) for each in faces]
