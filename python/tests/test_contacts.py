"""Contacts: what Python gets is what the program writes, as tables and arrays, at once or frame by frame."""
import json
import pickle

import numpy as np
import pytest

import foldproof
from conftest import rolling

CUBE = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
FACES = np.array([[0, 1, 3], [0, 3, 2], [4, 7, 5], [4, 6, 7], [0, 5, 1], [0, 4, 5], [2, 3, 7], [2, 7, 6], [0, 2, 6],
                  [0, 6, 4], [1, 5, 7], [1, 7, 3]])
RINGS = [[x * t, y * t, t - 0.5] for t in (1, 0.8, 0.4) for x, y in ((-0.5, -0.4), (0.5, -0.4), (0.5, 0.4), (-0.5, 0.4))]
SPIKE = np.array([*RINGS, [0, 0, -0.5]])
SIDES = [f for a, b in ((0, 1), (1, 2), (2, 3), (3, 0)) for k in (0, 4) for f in ((a + k, a + k + 4, b + k + 4), (a + k, b + k + 4, b + k))]
SPIKE_FACES = np.array([[0, 1, 2], [0, 2, 3], *SIDES, [8, 12, 9], [9, 12, 10], [10, 12, 11], [11, 12, 8]])
HEIGHTS = [2.0, 1.6, 1.2, 0.9, 1.2, 1.6, 2.0]
BELOW = np.stack([CUBE * [1, 1.1, 1]] * len(HEIGHTS))
ABOVE = np.stack([SPIKE + [0.013, 0.017, height] for height in HEIGHTS])
PARTS = ["lid" if k in (10, 11) else "box" for k in range(12)]


@pytest.fixture(scope="module")
def dip():
    """A spike dips into the top of a cube, by 0.6 at frame 3."""
    return [foldproof.Motion(FACES, BELOW, "cube"), foldproof.Motion(SPIKE_FACES, ABOVE, "spike")]


@pytest.fixture(scope="module")
def found(dip):
    return foldproof.check(dip, unit="m")


def test_the_fields_of_a_contact(found):
    contact, = found.contacts
    assert (contact.number, contact.joined, contact.between) == (1, (), "cube - spike")
    assert (contact.from_start, contact.healed, contact.folded) == (False, True, False)
    assert 1 < contact.first_time < 2 and 4 < contact.last_time < 5
    assert contact.worst == 3 and contact.depth == pytest.approx(0.6)
    assert list(contact.frames["time"]) == [2, 3, 4] and contact.worst_frame["depth"] == contact.depth
    assert contact.frames["area"].shape == (3, 2) and contact.frames["closed"].all()
    assert contact.point.shape == (3,) and contact.box.shape == (2, 3) and np.linalg.norm(contact.normal) == pytest.approx(1)
    assert [(side.object, side.name) for side in contact.sides] == [(0, "cube"), (1, "spike")]
    assert len(contact.sides[1].inside) == 4 and set(contact.sides[1].inside) <= set(contact.sides[1].triangles)
    curve, = contact.curves
    assert np.array_equal(curve[0], curve[-1]) and np.allclose(curve[:, 2], 1)
    assert contact.pairs == found.collisions


def test_tables(found):
    assert str(found.contacts) == (
        "1 contact, the worst first:\n"
        "#  between       at                   frames  worst  triangles  depth (m)  curve (m)\n"
        "1  cube - spike  (0.013, 0.017, 0.4)     2-4      3         14        0.6       2.16")
    assert repr(found.contacts[0]) == "<foldproof.Contact 1: cube - spike, frames 2-4, worst 3, 0.6 deep>"
    html = found.contacts._repr_html_()
    assert html.count("<tr>") == 2 and "cube - spike" in html and "depth (m)" in html
    assert "1 contact;" in repr(found) and "cube - spike" in found._repr_html_()
    assert repr(foldproof.Contacts([])) == "no contacts"


def test_many_contacts_are_cut_and_what_touches_says_so(found):
    touching, = foldproof.check([foldproof.Motion(FACES, BELOW[:2]), foldproof.Motion(SPIKE_FACES, ABOVE[:2] + [0, 0, 0.05])],
                                thickness=0.2, within=False).contacts
    assert touching.worst is None and touching.depth is None and touching.worst_frame is None
    many = foldproof.Contacts([*found.contacts, touching] * 15, "", 2)
    assert str(many).endswith("and 10 more") and "touches; not known whether it crosses: " in str(many)
    assert "  touches: " in str(foldproof.Contacts([touching])) and "touches" not in repr(touching)
    assert str(many).startswith("30 contacts, the worst first; of 2 frames it is not known which triangles cross:\n")
    assert "and 10 more" in many._repr_html_() and many._repr_html_().count("<tr>") == 21
    assert np.isnan(many.table["depth"][1]) and len(many[::2].frames) == 15 * 3
    with pytest.raises(IndexError):
        many[30]


def test_arrays(found):
    table, contact = found.contacts.table, found.contacts[0]
    assert len(table) == 1 and table["depth"][0] == contact.depth and table["name_b"][0] == "spike"
    assert np.array_equal(table["point"][0], contact.point)
    frames = found.contacts.frames
    assert list(frames["number"]) == [1, 1, 1] and np.array_equal(frames["area"], contact.frames["area"])
    assert len(foldproof.Contacts([]).frames) == len(foldproof.Contacts([]).table) == 0


def test_pandas(found):
    pytest.importorskip("pandas")
    data = found.contacts.to_pandas()
    assert data.loc[1, "depth"] == found.contacts[0].depth and data.loc[1, "point_z"] == found.contacts[0].point[2]


def test_copies_are_equal(found):
    copy = pickle.loads(pickle.dumps(found))
    assert copy == found and copy.contacts == found.contacts and copy.contacts[0] == found.contacts[0]
    assert found.contacts != foldproof.Contacts([]) and found != foldproof.check(foldproof.Motion(FACES, BELOW))


@pytest.mark.parametrize("settings, options", [({}, []), ({"static": True}, ["--static"]), ({"steps_only": True}, ["--steps-only"])])
def test_contacts_are_the_programs(triangles, program, tmp_path, settings, options):
    motion = foldproof.Motion(triangles, rolling(np.linspace(2, 12, 12)))
    foldproof.write_motion(tmp_path / "roll.npz", motion)
    assert program("check", "roll.npz", "--json", "roll.json", "--pairs", "--quiet", *options).returncode == 1
    theirs = json.loads((tmp_path / "roll.json").read_text())["contacts"]
    ours = foldproof.check(motion, **settings).contacts
    assert len(ours) == len(theirs) > 0
    for mine, its in zip(ours, theirs):
        for name in ("number", "folded", "from_start", "healed", "first_time", "last_time", "pairs", "depth", "worst"):
            assert getattr(mine, name) == its[name], name
        assert list(mine.joined) == its["joined"] and mine.point.tolist() == its["point"]
        assert [side.triangles.tolist() for side in mine.sides] == [side["triangles"] for side in its["sides"]]
        assert [curve.tolist() for curve in mine.curves] == its["curves"]
        assert [row["curve_length"] for row in mine.frames] == [row["curve_length"] for row in its["frames"]]


def test_parts_name_the_sides(dip):
    contact, = foldproof.check(dip, parts=[PARTS, None]).contacts
    assert [side.name for side in contact.sides] == ["lid", "spike"]
    alone = foldproof.Motion(np.concatenate([FACES, SPIKE_FACES + 8]), np.concatenate([BELOW, ABOVE], axis=1))
    contact, = foldproof.check(alone, parts=np.array(PARTS + ["spike"] * 22)).contacts
    assert {side.name for side in contact.sides} == {"lid", "spike"}
    for parts in ([PARTS], [PARTS, PARTS[:-1]]):
        with pytest.raises(foldproof.Error, match="parts"):
            foldproof.check(dip, parts=parts)


def test_parts_of_files_name_the_sides(tmp_path):
    def faces(triangles, first):
        return "\n".join(f"f {a} {b} {c}" for a, b, c in np.asarray(triangles) + first + 1)

    points = np.concatenate([BELOW[3], ABOVE[3]])
    vertices = "\n".join(f"v {x} {y} {z}" for x, y, z in points)
    (tmp_path / "a.obj").write_text(f"{vertices}\ng torso\n{faces(FACES, 0)}\ng arm\n{faces(SPIKE_FACES, 8)}\n")
    motion = foldproof.open_motion(tmp_path / "a.obj")
    assert motion.parts.tolist() == ["torso"] * 12 + ["arm"] * 22 and motion.unit == ""
    assert repr(motion).endswith("21 vertices, 34 triangles, 2 parts>")
    for each in (motion[::1], pickle.loads(pickle.dumps(motion))):
        contact, = foldproof.check(each).contacts
        assert {side.name for side in contact.sides} == {"torso", "arm"}


def test_parts_of_a_motion():
    motion = foldproof.Motion(FACES, BELOW, parts=PARTS)
    assert motion.parts.tolist() == PARTS and foldproof.Motion(FACES, BELOW).parts is None
    with pytest.raises(foldproof.Error, match="parts: are 3 names for 12 triangles; give one name per triangle"):
        foldproof.Motion(FACES, BELOW, parts=PARTS[:3])


def test_contacts_that_were_not_looked_for(motion):
    for settings in ({"contacts": False}, {"earliest_only": True}):
        found = foldproof.check(motion, **settings)
        with pytest.raises(foldproof.Error, match="contacts: were not looked for; check with contacts=True"):
            found.contacts
        assert "contact" not in repr(found) and "contact" not in found._repr_html_()


def test_frame_by_frame_is_the_whole_check(dip, found):
    objects = [foldproof.Hierarchy(FACES, BELOW[0]), foldproof.Hierarchy(SPIKE_FACES, ABOVE[0])]
    streamed = list(foldproof.find_contacts(objects, zip_frames(), parts=[["cube"] * 12, ["spike"] * 22]))
    assert streamed == list(found.contacts)
    unnamed, = foldproof.find_contacts(objects, zip_frames())
    assert unnamed.between == "object 0 - object 1" and unnamed.depth == found.contacts[0].depth
    cut = foldproof.ContactFinder(objects, max_listed=1)
    of_listed = [contact for x in zip_frames() for contact in cut.add(x)]
    assert of_listed == list(foldproof.find_contacts(objects, zip_frames(), max_listed=1))
    assert 0 < of_listed[0].pairs < unnamed.pairs and cut.unknown_frames == 3  # frames 2 to 4
    assert cut.unlisted_pairs == unnamed.pairs - of_listed[0].pairs


def zip_frames():
    """As a simulation has them: always in the same arrays."""
    below, above = np.empty((8, 3)), np.empty((13, 3))
    for below[:], above[:] in zip(BELOW, ABOVE):
        yield [below, above]


def test_contacts_come_when_they_end(dip, found):
    objects = [foldproof.Hierarchy(FACES, BELOW[0]), foldproof.Hierarchy(SPIKE_FACES, ABOVE[0])]
    finder = foldproof.ContactFinder(objects)
    counts = [(len(finder.add([b, a], time=0.5 * k)), finder.open_count) for k, (b, a) in enumerate(zip(BELOW, ABOVE))]
    assert counts == [(0, 0), (0, 0), (0, 1), (0, 1), (0, 1), (0, 1), (1, 0)]
    with pytest.raises(foldproof.Error, match="time: .* is not after the last"):
        finder.add([BELOW[0], ABOVE[0]], time=3.0)
    for time in (np.nan, np.inf):
        with pytest.raises(foldproof.Error, match="time: is not finite"):
            foldproof.ContactFinder(objects).add([BELOW[0], ABOVE[0]], time=time)
    assert finder.finish() == []
    assert finder.unknown_frames == finder.unlisted_pairs == 0
    for call in (finder.finish, lambda: finder.add([BELOW[0], ABOVE[0]])):
        with pytest.raises(foldproof.Error, match="has finished"):
            call()
    for bad in ({"earliest_only": True}, {"mode": "paper"}):
        with pytest.raises(foldproof.Error, match="do not ask for all"):
            foldproof.ContactFinder(objects, **bad)
    with pytest.raises(TypeError):
        foldproof.ContactFinder(dip)
