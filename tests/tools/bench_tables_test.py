#!/usr/bin/env python3
"""tools/bench_tables makes its tables and its page of what foldproof-bench writes."""
import json
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
FACTS = ["date", "processor", "system", "compiler", "flags of foldproof", "flags of the peers that are headers",
         "foldproof", "Embree", "FCL"]
RUN = {"machine": {name: "one" for name in sorted(FACTS)}, "command": "foldproof-bench", "processor_time": False,
       "threads": 1, "rounds": 1, "warm_up": 40, "steps": 40, "all_steps": False, "peer_steps": 1}


def way(milliseconds, allocations=0):
    work = {name: 2 for name in ("node_tests", "certificate_tests", "certificate_passes", "leaf_pairs", "candidates_vf",
                                 "candidates_ee", "undecided")}
    return {"milliseconds": milliseconds, "searched": 1, "allocations": allocations, "work": work,
            "stages": {"update": 0.1, "traverse": 0.2, "narrow": 0.3}}


def step(milliseconds, collisions=0, peers=None):
    out = {"floor_milliseconds": 0.5, "collisions": {"vf": collisions, "ee": 0},
           "foldproof": {"certificates": way(milliseconds)}}
    if peers:
        out["foldproof"]["plain"] = way(8)
        out["peers"] = {name: {"milliseconds": ms, "candidates_vf": 1000, "candidates_ee": 234}
                        for name, ms in peers.items()}
    return out


def scene(name, kind, size, steps):
    return {"name": name, "kind": kind, "step": size, "triangles": 1000, "build_milliseconds": 12.34, "references": 0,
            "train_seconds": 0, "warm_up_milliseconds": [9.876], "peak_bytes": {"foldproof": 500_000}, "steps": steps}


def run(*arguments, **results):
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "results.json"
        path.write_text(json.dumps({**RUN, **results}))
        page = pathlib.Path(folder) / "page.html"
        arguments = [page if argument == "PAGE" else argument for argument in arguments]
        done = subprocess.run([sys.executable, str(ROOT / "tools/bench_tables"), str(path), *arguments],
                              capture_output=True, text=True, check=True)
        return page.read_text() if page in arguments else done.stdout


def cells(tables, first, header):
    """What stands below `header` in the row that begins with the words `first`, of the first table that has both."""
    for table in tables.split("\n\n"):
        rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in table.splitlines()]
        if header in rows[0]:
            for row in rows:
                if row[0] == first:
                    return row[rows[0].index(header)]
    raise AssertionError(f"there is no row {first} with a {header} in\n{tables}")


def check_main_tables():
    peers = {"Embree features SAH": 40.0, "Embree triangles SAH": 30.0, "FCL dynamic AABB tree": 60.0}
    scenes = [scene("walk", "motion", "tenth", [step(1, peers=peers), step(2, collisions=3)]),
              scene("run", "motion", "tenth", [step(6, peers=peers)]),
              scene("ball", "generated", "full", [step(0.1)])]
    tables = run(scenes=scenes)
    assert tables.startswith("* date: one\n* processor: one\n"), tables
    for first, header, expected in (("walk", "foldproof", "1.50"), ("walk", "x floor", "3.0"),
                                    ("walk", "colliding", "1"), ("walk", "slowest/mean", "1.3"),
                                    ("walk", "Embree", "30.0"), ("walk", "Embree/us", "20.00"),
                                    ("walk", "FCL/us", "40.00"), ("walk", "swept boxes", "1,234"),
                                    ("walk", "no certificates", "8.00"), ("walk", "KB/triangle", "0.50"),
                                    ("walk", "Embree features SAH", "40.0"), ("ball (generated)", "Embree", "-"),
                                    ("geometric mean of 2 motions", "Embree/us", "10.00"), ("run", "build ms", "12.3")):
        assert cells(tables, first, header) == expected, (first, header, cells(tables, first, header), tables)
    goal = "times faster than Embree, straight tenths of the motions"
    assert (cells(tables, goal, "target"), cells(tables, goal, "reached"), cells(tables, goal, "met")) == (
        ">= 37", "10.00", "no"), tables
    goal = "times the floor, tenth steps without a collision, 2 motions that have any"
    assert cells(tables, goal, "reached") == "4.90", tables  # of 2 and 12
    page = run("--page", "PAGE", scenes=scenes)
    assert "walk, Embree: 30.0 ms, 60.0 times the floor" in page, page


def check_growth():
    scenes = [scene("cloth-small", "growth", "tenth", [step(1)]), scene("cloth-large", "growth", "tenth", [step(300)])]
    scenes[0]["triangles"], scenes[1]["triangles"] = 20_000, 2_000_000
    tables = run(growth=scenes)
    assert cells(tables, "cloth", "foldproof") == "50.0", tables
    goal = "times as long per triangle at 2,000,000 triangles as at 20,000, cloth"
    assert cells(tables, goal, "reached") == "3.00", tables


def check_single_tables():
    certified = {"name": "walk", "kind": "motion", "step": "full", "training": "every 10th frame",
                 "triangles": 100, "references": 2, "train_seconds": 3, "model_bytes": 4000, "steps": 10,
                 "milliseconds_with": 20, "milliseconds_without": 80, "leaf_pairs_with": 60,
                 "leaf_pairs_without": 210, "colliding": 10, "certificate_tests": 50}
    tables = run(
        trained_before=10,
        thread_scaling=[{"name": "lion-9996", "step": "tenth", "triangles": 9996, "steps": 40,
                         "teams": [{"threads": 1, "milliseconds": 3, "processors": 1},
                                   {"threads": 2, "milliseconds": 2, "processors": 1.8},
                                   {"threads": 4, "milliseconds": 1, "processors": 3.5}]}],
        training=[{"name": "hand-train", "triangles": 70, "poses": 4, "references": 2, "wall_seconds": 6,
                   "processor_seconds": 4, "proven": 0.5}],
        certificates=[certified, {**certified, "leaf_pairs_with": 210}],
        candidates=[{"name": "walk", "stride": "Newton iteration", "inflation": 0.05, "pairs": 1234.4,
                     "milliseconds": 2, "slowest_milliseconds": 3, "first_milliseconds": 4,
                     "peers": {"Embree features SAH": 30, "Embree triangles SAH": 20}}],
        contacts=[{"name": "wave", "steps": 9, "pairs": 70, "contacts": 3, "check_milliseconds": 400,
                   "contact_milliseconds": 100}],
        simulation=[{"name": "rod", "triangles": 10, "question": "step size", "contact": "since", "questions": 4,
                     "milliseconds": 8, "slowest_milliseconds": 6,
                     "sampled": {"questions": 2, "certificates": 5, "plain": 10, "peers": {"Embree features SAH": 30}}}],
        reduced=[{"triangles": 9968, "build_seconds": 1.44, "radius": 4.391, "distance": 1, "step_microseconds": 0.27,
                  "proven_free_microseconds": 0.026, "node_pairs": 1, "leaf_pairs": 0}])
    for first, header, expected in (("lion", "speed-up with 2", "1.50"), ("lion", "speed-up with 4", "3.00"),
                                    ("hand-train", "proven %", "50.0"),
                                    ("walk", "removed %", "75.0"), ("walk", "without/with", "4.00"),
                                    ("walk", "s/reference", "1.50"), ("walk", "B/triangle", "20"),
                                    ("mean of 2 motions, geometric of ratios", "removed %", "37.5"),
                                    ("walk", "its name", "Embree triangles SAH"), ("walk", "peer/foldproof", "10.0"),
                                    ("wave", "share %", "25"),
                                    ("rod, 10 triangles", "slowest/mean", "3.0"),
                                    ("rod, 10 triangles", "no/foldproof", "2.0"),
                                    ("rod, 10 triangles", "peer/foldproof", "6.0"),
                                    ("9968", "us proven_free", "0.026"),
                                    ("of the time that training on hand-train took before", "reached", "0.40")):
        assert cells(tables, first, header) == expected, (first, header, cells(tables, first, header), tables)


def main():
    check_main_tables()
    check_growth()
    check_single_tables()


if __name__ == "__main__":
    main()
