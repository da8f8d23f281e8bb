#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Compiles users' sources against an installed tree, only with the flags from pkg-config, and runs them.

The tree is in the build folder, below DESTDIR; the checkout's headers and libraries are not accessible.
"""

import os
import pathlib
import shlex
import shutil
import struct
import subprocess
import tempfile
import unittest

import tap_runner

SOURCE = pathlib.Path(os.environ["WEIR_SOURCE"])
BUILD = pathlib.Path(os.environ["WEIR_BUILD"])
DESTDIR = BUILD / "tests" / "compat" / "installed"
PREFIX = DESTDIR / os.environ["WEIR_PREFIX"].lstrip("/")
LIBRARIES = PREFIX / os.environ["WEIR_LIBDIR"]
FILTERS = SOURCE / "tests" / "compat" / "filters"


def run(*command, **more):
    return subprocess.run([str(c) for c in command], capture_output=True, text=True, timeout=300, check=False, **more)


def good(done):
    if done.returncode:
        raise AssertionError(done.stdout + done.stderr)
    return done.stdout


def pkg_config(*arguments):
    folders = {**os.environ, "PKG_CONFIG_PATH": str(LIBRARIES / "pkgconfig")}
    return shlex.split(good(run("pkg-config", *arguments, env=folders)))


def put_destdir_in_front():
    """Prepends DESTDIR to the paths in our .pc files; GStreamer's stay unchanged."""
    for package in (LIBRARIES / "pkgconfig").iterdir():
        package.write_text(package.read_text().replace(f"prefix={os.environ['WEIR_PREFIX']}\n", f"prefix={PREFIX}\n"))


class Installed(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        shutil.rmtree(DESTDIR, ignore_errors=True)
        (PREFIX / "bin").mkdir(parents=True)
        (PREFIX / "bin" / "weir").touch()  # as from another package, which the commands' links point to
        good(run("meson", "install", "-C", BUILD, "--no-rebuild", "--quiet", "--destdir", DESTDIR, "--tags", "compat,devel"))
        put_destdir_in_front()
        cls.folder = tempfile.TemporaryDirectory()

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def build(self, source, package, *more):
        out = pathlib.Path(self.folder.name) / source.stem
        cxx = source.suffix == ".cpp"
        compiler = shlex.split(os.environ["WEIR_CXX" if cxx else "WEIR_CC"])
        good(run(*compiler, "-std=c++11" if cxx else "-std=c99", "-Wall", "-Wextra", "-Werror", *more, source, "-o", out,
                 *pkg_config("--cflags", "--libs", package)))
        return out

    def play(self, line, **more):
        environment = {**os.environ, "LD_LIBRARY_PATH": f"{LIBRARIES}:{os.environ.get('LD_LIBRARY_PATH', '')}", **more}
        return good(run("gst-launch-1.0", "-q", *shlex.split(line), env=environment))

    def test_a_program_with_a_filter_of_its_own(self):
        program = self.build(SOURCE / "tests" / "compat" / "outside" / "easy_program.c", "nnstreamer")
        environment = {**os.environ, "LD_LIBRARY_PATH": f"{LIBRARIES}:{os.environ.get('LD_LIBRARY_PATH', '')}"}
        self.assertEqual(good(run(program, env=environment)), f"NNStreamer 2.7.0\n{235 * 235}\n{235 * 235}\n")

    def test_a_program_that_calls_every_function(self):
        environment = {**os.environ, "LD_LIBRARY_PATH": f"{LIBRARIES}:{os.environ.get('LD_LIBRARY_PATH', '')}"}
        for package in ("nnstreamer", "nnstreamer-internal"):
            program = self.build(SOURCE / "tests" / "compat" / "outside" / "every_function.c", package)
            self.assertEqual(good(run(program, env=environment)), "as wanted\n")

    def test_custom_filters_and_sub_plugins(self):
        shared = ["-shared", "-fPIC", "-fvisibility=hidden", "-D_GNU_SOURCE"]
        out = pathlib.Path(self.folder.name) / "out"
        source = "videotestsrc pattern=white num-buffers=1 ! video/x-raw,format=GRAY8,width=4,height=2 ! tensor_converter ! "
        average = self.build(FILTERS / "average.c", "nnstreamer", *shared)
        self.play(f"{source} tensor_filter framework=custom model={average} ! filesink location={out}")
        self.assertEqual(out.read_bytes(), bytes.fromhex("00006b43"))  # 235 as float32
        adder = self.build(FILTERS / "classes.cpp", "nnstreamer-cpp", *shared)
        adder.rename(adder.with_name("libnnstreamer_filter_classes.so"))
        numbers = pathlib.Path(self.folder.name) / "numbers"
        numbers.write_bytes(struct.pack("2f", 1, 2))
        self.play(f"filesrc location={numbers} ! application/octet-stream,framerate=30/1 ! tensor_converter input-dim=2 "
                  f"input-type=float32 ! tensor_filter framework=classes custom=0.5 ! filesink location={out}",
                  NNSTREAMER_FILTERS=self.folder.name)
        self.assertEqual(struct.unpack("2f", out.read_bytes()), (1.5, 2.5))
        scaler = self.build(FILTERS / "scaler.c", "nnstreamer-single", *shared, "-Wl,--no-as-needed")
        self.play(f"{source} tensor_filter framework=custom model={scaler} custom=2x1 ! filesink location={out}")
        self.assertEqual(out.read_bytes(), b"\xeb\xeb")
        out.unlink()
        self.play(f"{source} tensor_filter framework=custom model={scaler} custom=1x1 ! filesink location={out}",
                  LD_LIBRARY_PATH="", WEIR_NNSTREAMER_LIBRARY=str(LIBRARIES / "libnnstreamer.so"))
        self.assertEqual(out.read_bytes(), b"\xeb", "libnnstreamer-single.so is found beside the library")

    def test_what_the_generator_writes_compiles_and_runs(self):
        out = pathlib.Path(self.folder.name) / "generated"
        environment = {**os.environ, "PKG_CONFIG_PATH": str(LIBRARIES / "pkgconfig"), "CC": os.environ["WEIR_CC"],
                       "CFLAGS": "-std=c99 -Wall -Wextra -Werror"}
        source = "videotestsrc num-buffers=1 ! video/x-raw,format=RGB,width=224,height=224 ! tensor_converter ! "
        self.play(f"{source} filesink location={out}")
        frame = out.read_bytes()
        for words in ([], ["--any-size"], ["--allocate"], ["--any-size", "--allocate"]):
            with self.subTest(words):
                base = "b" + "".join(words)
                good(run(os.environ["WEIR_COMMAND"], "new", "nnstreamer-filter", *words, "--base", base, "mine",
                         cwd=self.folder.name))
                good(run("make", "-e", "-f", f"nnstreamer_customfilter_{base}.mk", cwd=self.folder.name, env=environment))
                filter_file = pathlib.Path(self.folder.name) / f"nnstreamer_customfilter_{base}.so"
                self.play(f"{source} tensor_filter framework=custom model={filter_file} ! filesink location={out}")
                self.assertEqual(out.read_bytes(), frame)

    def test_each_package_is_there(self):
        for package in ("nnstreamer", "nnstreamer-cpp", "nnstreamer-single", "nnstreamer-internal"):
            self.assertIn("-lnnstreamer", pkg_config("--libs", package), package)
            self.assertEqual(pkg_config("--modversion", package), ["2.7.0"])

    def test_the_library_of_the_package_for_cpp_is_the_same_file(self):
        self.assertIn("-lnnstreamer_filter_cpp", pkg_config("--libs", "nnstreamer-cpp"))
        # CMake searches each library in the folders that its own package names.
        self.assertIn("Libs: -L${libdir} -lnnstreamer_filter_cpp", (LIBRARIES / "pkgconfig/nnstreamer-cpp.pc").read_text())
        self.assertTrue((LIBRARIES / "libnnstreamer_filter_cpp.so").samefile(LIBRARIES / "libnnstreamer.so"))


if __name__ == "__main__":
    tap_runner.main()
