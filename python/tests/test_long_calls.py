"""Python goes on while the library works, and Ctrl-C ends it soon."""
import os
import pathlib
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import foldproof
from conftest import rolling, strip

LARGE = {"length": 400, "width": 40}


@pytest.fixture(scope="module")
def large():
    return foldproof.Motion(strip(**LARGE), rolling(np.linspace(0.5, 9, 40), **LARGE))


@pytest.mark.parametrize("name", ["check", "step"])
def test_other_threads_go_on(large, name):
    if name == "check":
        work = lambda: foldproof.check(large, frames=slice(0, 6), certificates=False)  # noqa: E731
    else:
        checker = foldproof.StepChecker(foldproof.Hierarchy(large.triangles, large[0]))
        x0, x1 = large[30], large[39]
        work = lambda: checker.check(x0, x1)  # noqa: E731
    ticks, stop = [0], threading.Event()

    def count():
        while not stop.is_set():
            ticks[0] += 1
            time.sleep(0.001)

    thread = threading.Thread(target=count)
    thread.start()
    begin, before = time.monotonic(), ticks[0]
    work()
    took, counted = time.monotonic() - begin, ticks[0] - before
    stop.set()
    thread.join()
    assert took > 0.02, "too little work to tell"
    assert counted > 3


def test_threads_may_share_checkers_and_motions(triangles, frames, motion):
    checker = foldproof.StepChecker(foldproof.Hierarchy(triangles, frames[0]))
    expected = [len(checker.check(frames[k], frames[k + 1]).edge_edge) for k in range(len(frames) - 1)]
    found, failures = [], []

    def go():
        try:
            found.append([len(checker.check(motion[k], motion[k + 1]).edge_edge) for k in range(len(frames) - 1)])
        except BaseException as error:  # noqa: B902
            failures.append(error)

    threads = [threading.Thread(target=go) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not failures and found == [expected] * 4


SCRIPT = """
import sys
sys.path.insert(0, {tests!r})
import numpy as np
import foldproof
from conftest import rolling, strip
size = dict(length=400, width=40)
frames = rolling(np.linspace(0.2, 3, 300), **size)
motion = foldproof.Motion(strip(**size), frames)
begun = []
def progress(part):
    if not begun:
        print("begun", flush=True)
    begun.append(part)
try:
    {call}
except KeyboardInterrupt:
    print("interrupted", flush=True)
    sys.exit(7)
"""


@pytest.mark.parametrize("call", [
    "foldproof.train(motion, progress=progress).save('left.model')",
    "foldproof.check(motion, progress=progress, substeps=50, certificates=False, reports='left.json')",
    "model = foldproof.train(motion, frames='::60')\n"
    "    foldproof.ReducedShape(model, np.zeros((40, len(model.deviations))), progress=progress)",
])
def test_ctrl_c(tmp_path, call):
    script = SCRIPT.format(tests=str(pathlib.Path(__file__).parent), call=call)
    process = subprocess.Popen([sys.executable, "-c", script], cwd=tmp_path, stdout=subprocess.PIPE, text=True)
    try:
        assert process.stdout.readline() == "begun\n"
        time.sleep(0.2)
        process.send_signal(signal.SIGINT)
        begin = time.monotonic()
        rest, _ = process.communicate(timeout=60)
        assert (rest, process.returncode) == ("interrupted\n", 7)
        assert time.monotonic() - begin < 10  # a second or so on an idle machine
    finally:
        process.kill()
        process.wait()
    assert os.listdir(tmp_path) == []


def test_progress_rises_to_one_and_its_exceptions_come_out(large, motion, model):
    seen = []
    foldproof.check(large, frames="0:6", substeps=4, progress=seen.append)
    assert seen == sorted(seen) and all(0 < part <= 1 for part in seen) and seen.count(1) == 1
    for short in (lambda call: foldproof.check(motion, frames="0:2", progress=call),
                  lambda call: foldproof.train(motion, frames="0:3", progress=call),
                  lambda call: model.predict(model.mean[model.key_points], progress=call),
                  lambda call: foldproof.ReducedShape(model, progress=call)):
        seen.clear()
        short(seen.append)
        assert seen[-1] == 1
        with pytest.raises(ZeroDivisionError):
            short(lambda part: 1 / (part - 1))

    def stop(part):
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        foldproof.check(large, substeps=100, progress=stop)


def test_progress_cannot_undo_what_is_done(motion, tmp_path):
    def stop(part):
        if part == 1:
            raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        foldproof.check(motion, progress=stop, reports=tmp_path / "a.json")
    assert os.listdir(tmp_path) == []


EXIT = """
import sys, threading, time
sys.path.insert(0, {tests!r})
import numpy as np
import foldproof
from conftest import rolled, strip
x, triangles = rolled(2, 2, 2), strip(2, 2)  # small, so that threads mostly wait for Python's lock
motion = foldproof.Motion(triangles, np.stack([x, x]))
called = threading.Event()
def steps():
    checker = foldproof.StepChecker(foldproof.Hierarchy(triangles, x))
    while True:
        checker.check(x, x)
def progress(part):
    called.set()
    while True:
        pass
for work in (steps, steps, lambda: foldproof.check(motion, substeps=200000, progress=progress)):
    threading.Thread(target=work, daemon=True).start()
print(called.wait(30))
time.sleep(2)  # until the check waits for progress to return
"""


def test_python_can_end_while_threads_check():
    script = EXIT.format(tests=str(pathlib.Path(__file__).parent))
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stdout, done.stderr) == (0, "True\n", "")


def test_threads_can_be_limited(large):
    expected = foldproof.check(large, frames="30:33")
    try:
        foldproof.set_threads(1)
        alone = foldproof.check(large, frames="30:33")
    finally:
        foldproof.set_threads(0)
    assert np.array_equal(alone.edge_edge, expected.edge_edge)
