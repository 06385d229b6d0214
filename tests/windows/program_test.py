#!/usr/bin/env python3
"""foldproof.exe answers what the program of this machine answers, and knows names as Windows has them.
program_test.py FOLDPROOF COMMAND...: COMMAND runs foldproof.exe."""
import hashlib
import json
import pathlib
import subprocess
import sys
import tempfile
import urllib.request

HERE, EXE = sys.argv[1], sys.argv[2:]


def run(program, *arguments, folder, **more):
    return subprocess.run([*program, *arguments], cwd=folder, capture_output=True, text=True, encoding="utf-8", **more)


def without_times(value):
    if isinstance(value, dict):
        return {k: without_times(v) for k, v in value.items() if "milliseconds" not in k and k not in ("foldproof", "threads")}
    return [without_times(v) for v in value] if isinstance(value, list) else value


def answer(program, arguments, folder):
    """The exit code, and a hash of the JSON with every pair."""
    done = run(program, "check", *arguments, "--pairs", "--json", "answer.json", "-q", folder=folder)
    assert done.returncode in (0, 1), (arguments, done)
    text = json.dumps(without_times(json.loads((folder / "answer.json").read_text(encoding="utf-8"))), sort_keys=True)
    (folder / "answer.json").unlink()
    return done.returncode, len(text), hashlib.sha256(text.encode()).hexdigest()


def check_same_answers(folder):
    crlf = folder / "crlf"
    crlf.mkdir()
    for name in sorted((folder / "poses").glob("*.obj")):
        (crlf / name.name).write_bytes(name.read_bytes().replace(b"\n", b"\r\n"))
    umlaut = folder / "Größe 中"
    umlaut.mkdir()
    (umlaut / "Läufer.glb").write_bytes((folder / "walk.glb").read_bytes())
    deep = folder
    for letter in "abcdefg":
        deep = deep / (letter * 50)
    deep.mkdir(parents=True)
    (deep / "walk.glb").write_bytes((folder / "walk.glb").read_bytes())
    cases = [["walk.glb"], ["run.glb", "--substeps", "3"], ["body.npz", "shirt.npz"], ["walk.glb", "--thickness", "0.01"],
             ["walk.glb", "--model", "body.model"], ["--reduced", "body.model", "p.csv"], ["poses", "--static"],
             ["crlf", "--static"], ["crlf/*.obj", "--static"], ["cloth", "--sequence"], ["Größe 中/Läufer.glb"],
             [str(deep.relative_to(folder) / "walk.glb")]]
    for case in cases:
        here, there = answer([HERE], case, folder), answer(EXE, case, folder)
        print("same" if here == there else "DIFFERENT", case, here, there)
        assert here == there
    for case in (["Größe 中\\Läufer.glb"], [".\\walk.glb"], ["poses\\*.obj", "--static"], [f"{folder}/walk.glb"]):
        assert run(EXE, "check", *case, "-q", folder=folder).returncode in (0, 1), case


def check_outputs(folder):
    """Files appear whole, with the bytes that Linux writes, and only under names that Windows has."""
    for name in ("contacts.csv", "Größe 中/Ergebnis.csv"):
        for program in ([HERE], EXE):
            assert run(program, "check", "walk.glb", "--contacts-csv", name, "-q", folder=folder).returncode in (0, 1)
            (folder / name).rename(folder / ("here.csv" if program == [HERE] else "there.csv"))
        assert (folder / "here.csv").read_bytes() == (folder / "there.csv").read_bytes()
    before = sorted(folder.iterdir())
    for name in ("NUL", "con.json", "a.json ", "b.json.", "what?.json", "x:y.json", "Lpt1.json", "no/such.json"):
        refused = run(EXE, "check", "walk.glb", "-q", "--json", name, folder=folder)
        print(refused.stderr.strip())
        assert refused.returncode == 2 and refused.stderr.count("\n") == 1 and name in refused.stderr, (name, refused)
    assert sorted(folder.iterdir()) == before
    shown = run(EXE, "check", "walk.glb", "--json", "-", "-q", folder=folder)
    assert "\r" not in shown.stdout and json.loads(shown.stdout)["objects"]
    missing = run(EXE, "check", "wlak.glb", folder=folder)
    assert missing.returncode == 2 and "did you mean 'walk.glb'" in missing.stderr, missing


def check_repair_and_sweep(folder):
    for arguments in (["repair", "walk.glb", "-o", "repaired.glb", "-q"], ["sweep", "library", "-o", "sweep.jsonl", "-q"],
                      ["sweep", "library", "-o", "sweep.jsonl", "-q"], ["train", "body.npz", "-o", "exe.model", "-q"],
                      ["info", "body.model"], ["demo", "-q", "another"], ["render", "walk.glb", "-o", "picture.png", "-q"]):
        done = run(EXE, *arguments, folder=folder)
        print(arguments, done.returncode, done.stderr.strip())
        assert done.returncode in (0, 1), (arguments, done)


def check_page(folder):
    with subprocess.Popen([*EXE, "view", "walk.glb", "--no-browser"], cwd=folder, stdout=subprocess.PIPE,
                          stderr=subprocess.DEVNULL, text=True) as view:
        try:
            address = view.stdout.readline().split()[0]
            with urllib.request.urlopen(address + "api/scene") as answered:
                assert answered.status == 200
        finally:
            view.terminate()


def main():
    with tempfile.TemporaryDirectory(prefix="foldproof-windows-") as scratch:
        folder = pathlib.Path(scratch) / "demo"
        assert run([HERE], "demo", "-q", str(folder), folder=scratch).returncode == 0
        for check in (check_same_answers, check_outputs, check_repair_and_sweep, check_page):
            check(folder)


if __name__ == "__main__":
    main()
