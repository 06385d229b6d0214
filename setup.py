"""Builds the Python module with CMake when pip installs it; everything else is in pyproject.toml.

FOLDPROOF_BUILD in the environment names a build directory that CMake has configured already, with FOLDPROOF_PYTHON=ON for
this Python; then nothing is compiled that it has.
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

ROOT = pathlib.Path(__file__).resolve().parent
REMEDY = "install what docs/install.md (Python, from source) lists, then repeat the command"


class BuildWithCMake(build_ext):
    def build_extension(self, extension):
        module = pathlib.Path(self.get_ext_fullpath(extension.name)).resolve()
        build = pathlib.Path(os.environ.get("FOLDPROOF_BUILD") or self.build_temp).resolve()
        if not os.environ.get("FOLDPROOF_BUILD"):
            self.configure(build)
        jobs = os.environ.get("CMAKE_BUILD_PARALLEL_LEVEL", str(os.cpu_count()))
        subprocess.run(["cmake", "--build", build, "-j", jobs, "--target", "foldproof_python"], check=True)
        module.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(build / "python" / "foldproof" / module.name, module)

    def configure(self, build):
        options = [f"-DPython3_EXECUTABLE={sys.executable}", "-DCMAKE_BUILD_TYPE=Release", "-DFOLDPROOF_PYTHON=ON",
                   "-DFOLDPROOF_PROGRAM=OFF", "-DFOLDPROOF_TESTS=OFF", "-DFOLDPROOF_INSTALL=OFF", "-DCMAKE_UNITY_BUILD=ON",
                   f"-DFOLDPROOF_THREADS={threads()}"]
        if shutil.which("ninja"):
            options.append("-GNinja")
        if shutil.which("ccache"):
            options.append("-DCMAKE_CXX_COMPILER_LAUNCHER=ccache")
        try:
            subprocess.run(["cmake", "-S", ROOT, "-B", build, *options], check=True)
        except FileNotFoundError:
            sys.exit(f"foldproof: cmake was not found; {REMEDY}")
        except subprocess.CalledProcessError:
            sys.exit(f"foldproof: CMake lacks something, which it names above; {REMEDY}")


def threads():
    """oneTBB where it is installed, else the standard library's threads; answers are the same."""
    pkg_config = shutil.which("pkg-config")
    return "tbb" if pkg_config and subprocess.run([pkg_config, "--exists", "tbb"]).returncode == 0 else "std"


version = re.search(r"project\(foldproof VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text()).group(1)
setup(version=version, ext_modules=[Extension("foldproof._core", [])], cmdclass={"build_ext": BuildWithCMake})
