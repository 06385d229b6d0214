"""Repair of motions."""

import numpy as np
import pytest

import foldproof


def sheets(gaps, n=9):
    """Two square sheets above each other, by the height of the second's middle in each frame."""
    x, y = (c.ravel() for c in np.meshgrid(np.linspace(-1, 1, n), np.linspace(-1, 1, n)))
    quads = [i * n + k for i in range(n - 1) for k in range(n - 1)]
    one = np.array([[q, q + 1, q + n] for q in quads] + [[q + 1, q + n + 1, q + n] for q in quads])
    flat = np.stack([x, y, 0 * x], axis=1)
    bump = np.exp(-4 * (x**2 + y**2))
    frames = [np.concatenate([flat, flat * 0.9 + np.stack([0 * x + 0.013, 0 * x, 0.3 + (gap - 0.3) * bump], axis=1)]) for gap in gaps]
    return foldproof.Motion(np.concatenate([one, one + n * n]), frames, parts=["low"] * len(one) + ["high"] * len(one))


def test_what_comes_out_is_free():
    motion = sheets([0.3, 0.1, -0.1, 0.1, 0.3])
    assert not foldproof.check(motion).clean
    done = foldproof.repair(motion)
    assert done.free and not done.unchanged and len(done.before) == 1 and len(done.remaining) == 0
    assert foldproof.check(done.motions[0]).clean
    assert list(done.frames["time"]) == [0, 1, 2, 3, 4]
    assert 0.05 < done.frames["correction"][2] < 0.1
    assert repr(done).startswith("<foldproof.RepairResult: free; 1 contact before")
    assert done.verdict.startswith("Proven: nothing touches") and len(done.left) == 0
    again = foldproof.repair(done.motions[0])
    assert again.unchanged and again.free
    assert all(np.array_equal(again.motions[0][k], done.motions[0][k]) for k in range(5))


def test_what_may_move_and_what_is_ignored():
    motion = sheets([0.3, -0.1, 0.3])
    n = 81
    for fixed, moves in (("low", slice(n, None)), ("high", slice(0, n))):
        done = foldproof.repair(motion, fixed=[fixed])
        assert done.free
        change = np.asarray(done.motions[0][1]) - np.asarray(motion[1])
        assert np.abs(change[moves]).max() > 0.08
        change[moves] = 0
        assert not change.any()
    assert foldproof.repair(motion, ignore=[("low", "high")]).unchanged
    kept = foldproof.repair(motion, thickness=0.03)
    assert foldproof.check(kept.motions[0], thickness=0.03).clean


def test_vertices_that_stay():
    motion = sheets([0.3, -0.1, 0.3])
    still = np.arange(81)  # the lower sheet
    done = foldproof.repair(motion, fixed_vertices=[still])
    assert done.free
    change = np.abs(np.asarray(done.motions[0][1]) - np.asarray(motion[1])).max(axis=1)
    assert not change[still].any() and change[81:].max() > 0.08
    with pytest.raises(foldproof.Error, match="fixed_vertices: names vertex 162 of array, which has 162; count them from 0"):
        foldproof.repair(motion, fixed_vertices=[[162]])
    with pytest.raises(foldproof.Error, match="fixed_vertices: has 2 lists for 1 objects; give one for each object"):
        foldproof.repair(motion, fixed_vertices=[[0], [1]])


def test_only_what_is_chosen():
    n = 81
    two = sheets([0.3, -0.1, 0.3])
    third = np.array([[0, 0, 0.2], [0.1, 0, 0.2], [0, 0.1, 0.2], [0.02, 0.02, 0.1], [0.03, 0.02, 0.3], [0.02, 0.03, 0.3]]) + [5, 0, 0]
    frames = [np.concatenate([two[k], third]) for k in range(3)]
    faces = np.concatenate([two.triangles, [[2 * n, 2 * n + 1, 2 * n + 2], [2 * n + 3, 2 * n + 4, 2 * n + 5]]])
    motion = foldproof.Motion(faces, frames, parts=["low"] * 128 + ["high"] * 128 + ["knot"] * 2)
    done = foldproof.repair(motion, contacts=[("high", "low")])
    assert done.free and [c.between for c in done.before] == ["low - high"] and len(done.remaining) == 0
    assert [c.between for c in done.left] == ["knot with itself"]
    assert done.verdict.startswith("Proven: what was chosen is gone") and "; left: knot goes through itself" in done.verdict
    assert repr(done).startswith("<foldproof.RepairResult: free of those chosen, 1 contact left; 1 contact before, ")
    assert np.array_equal(np.asarray(done.motions[0][1])[2 * n :], third)
    assert len(foldproof.check(done.motions[0]).contacts) == 1
    with pytest.raises(foldproof.Error, match="did you mean 'knot'"):
        foldproof.repair(motion, contacts=[("high", "nkot")])


def test_a_model_knows_where_to_start():
    model = foldproof.train(sheets([0.3, 0.2, 0.1, 0.15]))
    crossing = sheets([-0.1, -0.12])
    done = foldproof.repair(crossing, models=model)
    assert done.free
    assert not np.array_equal(done.motions[0][0], foldproof.repair(crossing).motions[0][0])
    with pytest.raises(foldproof.Error, match="give one per motion"):
        foldproof.repair(crossing, models=[model, None])
    huge = np.array(crossing[0])
    huge[7, 1] = 1e200  # no pose can be laid over it
    with pytest.raises(foldproof.Error, match="frame 0, vertex 7: has the coordinate"):
        foldproof.repair(foldproof.Motion(crossing.triangles, [huge]), models=model)


def test_errors_are_said():
    motion = sheets([0.3, -0.1])
    with pytest.raises(foldproof.Error, match="more than the gaps of array itself: in frame 1 .* give at most 0.159"):
        foldproof.repair(motion, thickness=1)
    with pytest.raises(foldproof.Error, match="did you mean 'high'"):
        foldproof.repair(motion, fixed=["hihg"])
    with pytest.raises(foldproof.Error, match="nothing may move"):
        foldproof.repair(motion, fixed=["low", "high"])
    with pytest.raises(foldproof.Error, match="touches itself"):
        foldproof.repair(motion, start=motion[1])
    with pytest.raises(foldproof.Error, match="frames"):
        foldproof.repair(sheets([0.3, -0.1, 0.3]), frames="0:3:2")
