"""Filters: what they ignore, in every checker that takes one."""
import numpy as np
import pytest

import foldproof


def sheet(n, z=0.0):
    """A sheet of n x n cells with unit sides: positions and triangles."""
    u, v = np.meshgrid(np.linspace(0, 1, n + 1), np.linspace(0, 1, n + 1), indexing="ij")
    corner = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).reshape(-1, 1)
    faces = np.concatenate([corner + [0, n + 1, n + 2], corner + [0, n + 2, 1]])
    return np.stack([u, v, np.full_like(u, z)], axis=-1).reshape(-1, 3), faces


def count(objects, x0, x1, filter=None, **settings):
    result = foldproof.StepChecker(objects, filter=filter).check(x0, x1, **settings)
    return result.vertex_face_count + result.edge_edge_count


def test_neighbors_within_a_thickness():
    x, faces = sheet(5)
    tree = foldproof.Hierarchy(faces, x)
    thick = {"thickness": 0.3}  # an edge is 0.2 long
    counts = [count(tree, x, x, foldproof.ignore_rings(tree, rings), **thick) for rings in (0, 1, 2)]
    assert count(tree, x, x, **thick) == counts[0] > counts[1] > counts[2] == 0
    counts = [count(tree, x, x, foldproof.ignore_length(tree, x, length), **thick) for length in (0, 0.2001, 0.4001)]
    assert counts[0] > counts[1] > counts[2] == 0


def test_sewn_fixed_and_touching():
    x, faces = sheet(4)
    y = x + [0, 0, 0]
    trees = [foldproof.Hierarchy(faces, x), foldproof.Hierarchy(faces, y)]
    poses = [x, y]
    assert count(trees, poses, poses) > 0
    seams = [[0, v, 1, v] for v in range(len(x))] + [[0, a, 1, b] for t in faces for a in t for b in t]
    few, all_of_them = foldproof.ignore_sewn(trees, seams[:1]), foldproof.ignore_sewn(trees, seams)
    assert count(trees, poses, poses) > count(trees, poses, poses, few) > count(trees, poses, poses, all_of_them) == 0
    yes, no = np.ones(len(x), bool), np.zeros(len(x), bool)
    assert count(trees, poses, poses, foldproof.ignore_fixed(trees, [yes, yes])) == 0
    assert count(trees, poses, poses, foldproof.ignore_fixed(trees, [yes, no])) == count(trees, poses, poses)
    touching = foldproof.ignore_touching(trees, poses)
    assert count(trees, poses, poses, touching) == 0
    assert count(trees, poses, [x, y + [0.6, 0.3, 0]], touching) > 0
    assert count(trees, poses, poses, foldproof.ignore_all(few, touching)) == 0


def test_contacts_and_solvers_take_them():
    x, faces = sheet(4)
    above = x + [0.013, 0.017, 0.3]
    below = x + [0.013, 0.017, -0.3]
    trees = [foldproof.Hierarchy(faces, x), foldproof.Hierarchy(faces, above)]
    frames = [[x, above], [x, below]]
    fixed = foldproof.ignore_fixed(trees, [np.ones(len(x), bool)] * 2)
    assert len(list(foldproof.find_contacts(trees, frames))) == 1
    assert len(list(foldproof.find_contacts(trees, frames, filter=fixed))) == 0
    mesh = foldproof.CollisionMesh(np.concatenate([x, above]), faces=np.concatenate([faces, faces + len(x)]))
    together = foldproof.ignore_fixed(mesh, np.ones(2 * len(x), bool))
    start, end = np.concatenate([x, above]), np.concatenate([x, below])
    assert foldproof.ContactChecker(mesh).collision_free_step_size(start, end) < 1
    assert foldproof.ContactChecker(mesh, filter=together).collision_free_step_size(start, end) == 1
    assert len(foldproof.ContactChecker(mesh, filter=together).candidates(start, end, inflation=1)) == 0


def test_refuses():
    x, faces = sheet(2)
    tree, other = foldproof.Hierarchy(faces, x), foldproof.Hierarchy(faces[:4], x)
    for bad in (lambda: foldproof.ignore_sewn(tree, [[0, 99]]), lambda: foldproof.ignore_sewn([tree, tree], [[0, 1]]),
                lambda: foldproof.ignore_rings(tree, -1), lambda: foldproof.ignore_length(tree, x, np.nan),
                lambda: foldproof.ignore_fixed(tree, np.arange(len(x))), lambda: foldproof.ignore_fixed(tree, [True]),
                lambda: foldproof.ignore_touching(tree, x[:3]), lambda: foldproof.ignore_all(),
                lambda: foldproof.StepChecker(other, filter=foldproof.ignore_rings(tree, 1))):
        with pytest.raises(foldproof.Error):
            bad()
    with pytest.raises(TypeError):
        foldproof.StepChecker(tree, filter=1)
    with pytest.raises(TypeError):
        foldproof.ignore_all(tree)
