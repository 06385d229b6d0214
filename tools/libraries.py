"""What tools/wheel and tools/standalone know about shared libraries: which ones a file needs, and their licenses."""

import pathlib
import re
import shutil
import subprocess
import sys

# Packages whose headers are compiled into the library.
HEADERS = {
    "libboost-dev", "libeigen3-dev", "libexpected-dev", "libflatbuffers-dev", "libnanoflann-dev", "libspectra-dev",
    "nlohmann-json3-dev",
}  # fmt: skip


def run(*command):
    return subprocess.run([str(part) for part in command], check=True, capture_output=True, text=True).stdout


def libraries_of(file):
    """Paths of the libraries that a program or library needs, directly or not, with the loader of a program."""
    listed = run("ldd", file)
    found = re.findall(r"^\s*(\S+) => (\S+)", listed, re.MULTILINE)
    if missing := [name for name, path in found if path == "not"]:
        sys.exit(f"{file}: needs {', '.join(missing)}, which is not there; install it")
    return [pathlib.Path(path) for path in [path for _, path in found] + re.findall(r"^\s*(/\S+) \(", listed, re.MULTILINE)]


def package_of(library):
    """Debian's package of a library; where /lib is a link, dpkg may know either path."""
    for path in (library, library.resolve(), pathlib.Path("/usr", *library.parts[1:])):
        found = subprocess.run(["dpkg-query", "-S", path], capture_output=True, text=True)
        if found.returncode == 0:
            return found.stdout.split(":")[0]
    sys.exit(f"{library}: is of no package, so its license is not known; use Debian's")


def copy_licenses(packages, folder):
    folder.mkdir(exist_ok=True)
    for package in packages:
        shutil.copy(f"/usr/share/doc/{package}/copyright", folder / f"{package}.copyright")
