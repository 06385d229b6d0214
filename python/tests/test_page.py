"""foldproof.view: the page of the program, which ends with its Page."""
import os
import signal
import subprocess
import sys
import time
import urllib.request

import pytest

import foldproof


@pytest.fixture
def where():
    path = os.environ.get("FOLDPROOF_PROGRAM")
    if not path or not os.path.exists(path):
        pytest.skip("FOLDPROOF_PROGRAM does not name the program")
    return path


def test_the_page_is_served_until_it_is_closed(motion, where, tmp_path):
    foldproof.write_motion(tmp_path / "file.npz", motion)
    try:
        page = foldproof.view(motion, tmp_path / "file.npz", program=where, options=("--no-browser",))
    except foldproof.Error as error:
        pytest.skip(f"the program has no page: {error}")
    with page:
        assert page.url.startswith("http://127.0.0.1:") and page.url in repr(page)
        assert f'<iframe src="{page.url}"' in page._repr_html_()
        assert b"<html" in urllib.request.urlopen(page.url).read()
    assert repr(page) == "<foldproof.Page closed>" and page._repr_html_() == "&lt;foldproof.Page closed>"
    with pytest.raises(OSError):
        urllib.request.urlopen(page.url)


def stand_in(path, script):
    path.write_text(f"#!/bin/sh\n{script}\n")
    path.chmod(0o755)
    return path


def test_a_page_ends_with_python_or_its_program(tmp_path, motion):
    program = stand_in(tmp_path / "serves", f'echo $$ > {tmp_path}/pid; ls "$2" > {tmp_path}/file\n'
                                            'echo "http://127.0.0.1:7/ (Ctrl-C ends it)"; exec sleep 60')
    page = foldproof.view(motion, program=program)
    assert repr(page) == "<foldproof.Page http://127.0.0.1:7/>"
    written = (tmp_path / "file").read_text().strip()
    assert os.path.exists(written)
    del page
    with pytest.raises(ProcessLookupError):
        os.kill(int((tmp_path / "pid").read_text()), 0)
    assert not os.path.exists(os.path.dirname(written))


CTRL_C = """
import os, signal, sys, time
import foldproof
page = foldproof.view("walk.glb", program=sys.argv[1])
try:
    os.killpg(0, signal.SIGINT)  # as a terminal does
    time.sleep(60)
except KeyboardInterrupt:
    pass
time.sleep(0.2)
print(page, flush=True)
print("waits", flush=True)
page.wait()
print(page)
"""


def test_ctrl_c_is_for_other_work_until_wait(tmp_path):
    program = stand_in(tmp_path / "serves", f'echo $$ > {tmp_path}/pid\n'
                                            'echo "http://127.0.0.1:7/ (Ctrl-C ends it)"; exec sleep 60')
    python = subprocess.Popen([sys.executable, "-c", CTRL_C, program], stdout=subprocess.PIPE, text=True, start_new_session=True)
    try:
        assert [python.stdout.readline() for _ in range(2)] == ["<foldproof.Page http://127.0.0.1:7/>\n", "waits\n"]
        time.sleep(0.5)  # until it waits
        os.killpg(python.pid, signal.SIGINT)
        assert python.communicate(timeout=30) == ("<foldproof.Page closed>\n", None) and python.returncode == 0
        with pytest.raises(ProcessLookupError):
            os.kill(int((tmp_path / "pid").read_text()), 0)
    finally:
        python.kill()
        python.wait()


def test_a_page_whose_program_ended_is_closed(tmp_path):
    with foldproof.view("walk.glb", program=stand_in(tmp_path / "ends", 'echo "http://127.0.0.1:7/ (Ctrl-C ends it)"')) as page:
        page.wait()
        assert repr(page) == "<foldproof.Page closed>" and "iframe" not in page._repr_html_()


def test_a_notebook_shows_the_page_itself(tmp_path, motion, monkeypatch):
    monkeypatch.setitem(sys.modules, "ipykernel", sys)
    program = stand_in(tmp_path / "serves", f'echo "$@" > {tmp_path}/arguments; echo "http://127.0.0.1:7/ (Ctrl-C ends it)"')
    with foldproof.view("walk.glb", program=program, options=("--frames", "2:9")):
        assert (tmp_path / "arguments").read_text() == "view walk.glb --frames 2:9 --no-browser\n"


def test_what_the_program_refuses_is_an_error(tmp_path):
    refuses = stand_in(tmp_path / "refuses", 'echo "foldproof: $2: cannot be read; check the path" >&2; exit 2')
    with pytest.raises(foldproof.Error) as refused:
        foldproof.view("nowhere.npz", program=refuses)
    assert (refused.value.where, refused.value.problem, refused.value.remedy) == (
        "nowhere.npz", "cannot be read", "check the path")
    assert isinstance(refused.value, foldproof.FileMissingError)
    (tmp_path / "there.npz").touch()
    for arguments, where in (((tmp_path / "there.npz",), ""), ((), "--no-browser")):
        with pytest.raises(foldproof.Error, match=where) as refused:
            foldproof.view(*arguments, program=refuses, options=("--no-browser",))
        assert type(refused.value) is foldproof.Error
    with pytest.raises(foldproof.Error, match="view: ended without a message"):
        foldproof.view("a.npz", program=stand_in(tmp_path / "silent", "exit 1"))
    with pytest.raises(FileNotFoundError, match="no-such-program: is not a program in PATH; install foldproof"):
        foldproof.view(tmp_path, program="no-such-program")
