#!/usr/bin/env python3
"""tools/bench_tables makes its tables of what foldproof-bench writes."""
import json
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
FACTS = ["date", "processor", "system", "compiler", "flags of foldproof", "flags of the peers that are headers",
         "foldproof", "Embree", "FCL"]
RUN = {"machine": {name: "one" for name in sorted(FACTS)}, "command": "foldproof-bench", "processor_time": False,
       "threads": 1, "rounds": 1, "warm_up": 40, "steps": 40, "all_steps": False, "peer_steps": 1, "scenes": []}


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


def run(**results):
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "results.json"
        path.write_text(json.dumps({**RUN, **results}))
        return subprocess.run([sys.executable, str(ROOT / "tools/bench_tables"), str(path)], capture_output=True, text=True,
                              check=True).stdout


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
    assert "* processor: one\n" in tables, tables
    for first, header, expected in (("walk", "foldproof", "1.50"), ("walk", "x floor", "3.00"),
                                    ("walk", "colliding", "1"), ("walk", "slowest", "2"), ("walk", "Embree", "30.0"),
                                    ("walk", "Embree/us", "20.0"), ("walk", "FCL/us", "40.0"),
                                    ("walk", "no certificates", "8.00"), ("walk", "KB/triangle", "0.500"),
                                    ("ball (generated)", "Embree", "-"), ("run", "build ms", "12.3"),
                                    ("2 of kind 'motion'", "Embree/us", "10.00")):
        assert cells(tables, first, header) == expected, (first, header, cells(tables, first, header), tables)


def check_other_tables():
    """They have what was measured, under the names that it was written with."""
    tables = run(growth=[scene("cloth-large", "growth", "tenth", [step(300)])],
                 thread_scaling=[{"name": "lion", "teams": [{"threads": 1, "milliseconds": 3.0}, {"threads": 2, "milliseconds": 2.0}]}],
                 candidates=[{"name": "walk", "pairs": 1234.4, "peers": {"Embree triangles SAH": 20.0}}])
    for first, header, expected in (("cloth-large", "foldproof", "300"), ("lion", "teams 1 milliseconds", "2.00"),
                                    ("walk", "pairs", "1234"), ("walk", "peers Embree triangles SAH", "20.0")):
        assert cells(tables, first, header) == expected, (first, header, cells(tables, first, header), tables)


if __name__ == "__main__":
    check_main_tables()
    check_other_tables()
