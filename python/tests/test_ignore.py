"""Pairs that are ignored by name, and pairs of what stands still."""

import numpy as np
import pytest

import foldproof

FLOOR = np.array([[-9.0, -9, 0], [20, -9, 0], [-9, 20, 0]])
TIP = np.array([[0.1, 0.1, 0.0], [0.3, 0.1, 1], [0.1, 0.3, 1]])


def at(*heights):
    return [TIP + [0, 0, height] for height in heights]


def test_parts_are_ignored_by_name():
    triangles = [[0, 1, 2], [3, 4, 5]]
    frames = [np.concatenate([FLOOR, tip]) for tip in at(0.6, -0.4)]
    motion = foldproof.Motion(triangles, frames, parts=["floor", "tip"])
    assert not foldproof.check(motion).clean
    found = foldproof.check(motion, ignore=[("tip", "floor")])
    assert found.clean
    assert found.untested == ["pairs of tip and floor were ignored"]
    assert not foldproof.check(motion, ignore=[("tip", "tip"), ("floor", "floor")]).clean
    with pytest.raises(foldproof.Error, match="did you mean 'floor'"):
        foldproof.check(motion, ignore=[("tip", "flor")])
    for wrong in (["tip", "floor"], [("tip",)], [1]):
        with pytest.raises(TypeError, match="pairs of names"):
            foldproof.check(motion, ignore=wrong)


def test_what_stands_still_is_tested_at_the_start_only(tmp_path):
    faces = np.array([[0, 1, 2]])
    for name, frames in (("floor", [FLOOR]), ("nail", at(-0.4)), ("needle", at(3, 2.5))):
        np.savez(tmp_path / f"{name}.npz", vertices=np.array(frames), faces=faces)
    motions = foldproof.open_motions(*(str(tmp_path / f"{name}.npz") for name in ("floor", "nail", "needle")), still=True)
    found = foldproof.check(motions)
    assert found.clean and found.still_crossing == 1 and found.starts_crossing == 0
    assert "stand still and cross each other at 1 pair of triangles" in found.untested[0]
    counted = foldproof.check(motions, still_pairs=True)
    assert not counted.clean and counted.still_crossing is None and counted.starts_crossing == 1
