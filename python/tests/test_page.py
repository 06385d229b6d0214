"""foldproof.view: the page of the program, which ends with its Page."""
import os
import sys
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
    with pytest.raises(foldproof.Error, match="view: ended without a message"):
        foldproof.view("a.npz", program=stand_in(tmp_path / "silent", "exit 1"))
    with pytest.raises(FileNotFoundError, match="no-such-program: is not a program in PATH; install foldproof"):
        foldproof.view(tmp_path, program="no-such-program")
