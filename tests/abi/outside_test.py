#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Tests of third-party modules, built only with the installed headers and pkg-config, with each of their parts."""

import os
import pathlib
import re
import shutil
import struct
import subprocess
import tempfile
import unittest

import tap_runner

SOURCE = pathlib.Path(os.environ["WEIR_SOURCE"])
MODULES = {"threshold": "threshold.cpp", "outside-cpp": "every_part.cpp", "outside-c": "every_part.c",
           "outside-two-classes": "two_classes.cpp"}
HEADER = 128  # bytes before each tensor of a flexible stream


def run(command, **more):
    return subprocess.run(command, capture_output=True, text=True, timeout=120, check=False, **more)


class Outside(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp())
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        root = cls.folder / "root"
        installed = run(["meson", "install", "-C", os.environ["WEIR_BUILD"], "--destdir", root, "--tags", "devel", "--no-rebuild"])
        if installed.returncode:
            raise RuntimeError(installed.stdout + installed.stderr)
        config = next(root.rglob("weir-module.pc")).parent
        cls.pkg_config = {"PKG_CONFIG_LIBDIR": str(config), "PKG_CONFIG_SYSROOT_DIR": str(root)}
        found = run(["pkg-config", "--cflags", "weir-module"], env={**os.environ, **cls.pkg_config})
        if found.returncode:
            raise RuntimeError(found.stderr)
        flags = found.stdout.split()
        for name, source in MODULES.items():
            cls.build(name, source, flags)
        found = run(["pkg-config", "--cflags", "--libs", "gstreamer-1.0"])
        built = run(["cc", "-std=c11", "-Wall", "-Wextra", "-Werror", SOURCE / "tests/abi/outside/edited.c", "-o", cls.folder / "edited"] +
                    found.stdout.split())
        if built.returncode:
            raise RuntimeError(found.stderr + built.stderr)
        cls.env = {**os.environ, "WEIR_MODULE_PATH": str(cls.folder), "GST_TRACERS": "", "GST_DEBUG": ""}

    @classmethod
    def build(cls, name, source, flags):
        compiler = ["cc", "-std=c11"] if source.endswith(".c") else ["c++", "-std=c++20"]
        built = run(compiler + ["-shared", "-fPIC", "-fvisibility=hidden", "-Wall", "-Wextra", "-Werror"] + flags +
                    [SOURCE / "tests/abi/outside" / source, "-o", cls.folder / f"libweir-engine-{name}.so", "-pthread"])
        if built.returncode:
            raise RuntimeError(built.stderr)

    def play(self, frames, filter_text, element="float32"):
        """Sends frames of equal length through one filter; returns the output bytes and the messages."""
        length = len(frames[0])
        size = length * (4 if element == "float32" else 1)
        data = b"".join(struct.pack(f"<{length}{'f' if element == 'float32' else 'B'}", *frame) for frame in frames)
        (self.folder / "in.bin").write_bytes(data)
        (self.folder / "out.bin").unlink(missing_ok=True)
        line = (f"filesrc location={self.folder}/in.bin blocksize={size} ! application/octet-stream ! tensor_converter "
                f"input-dim={length} input-type={element} ! tensor_filter {filter_text} ! filesink location={self.folder}/out.bin")
        done = run([os.environ["WEIR_COMMAND"], "run", line], env=self.env)  # gst-launch-1.0 sometimes hangs after an error
        out = self.folder / "out.bin"
        return (out.read_bytes() if out.exists() else b""), done.stdout + done.stderr, done.returncode

    def flexible(self, data, sizes):
        """The payloads, given the expected number of float32 in each."""
        out = []
        for count in sizes:
            self.assertGreaterEqual(len(data), HEADER + 4 * count)
            out.append(list(struct.unpack(f"<{count}f", data[HEADER:HEADER + 4 * count])))
            data = data[HEADER + 4 * count:]
        self.assertEqual(data, b"", "there is more than was expected")
        return out

    def test_a_filter_in_under_thirty_lines(self):
        """The guide's listing is the source that is built here, and its commands are run unchanged."""
        guide = (SOURCE / "docs/guide/write-a-filter.md").read_text(encoding="utf-8")
        listing = re.search(r"```cpp\n(.*?)```", guide, re.DOTALL).group(1)
        comment, license_line, source = (SOURCE / "tests/abi/outside/threshold.cpp").read_text(encoding="utf-8").split("\n", 2)
        self.assertTrue(comment.startswith("//") and license_line.startswith("// SPDX"))
        self.assertEqual(listing, source)
        self.assertLess(len(listing.splitlines()), 30)
        folder = self.folder / "guide"
        folder.mkdir()
        (folder / "threshold.cpp").write_text(listing, encoding="utf-8")
        commands = re.search(r"```text\n(.*?)```", guide, re.DOTALL).group(1)
        self.assertIn("$(pkg-config --cflags weir-module)", commands)
        self.assertIn("framework=threshold custom=limit:99", commands)
        weir = pathlib.Path(os.environ["WEIR_COMMAND"]).parent
        done = run(["bash", "-eu", "-c", commands], cwd=folder, env={**self.env, **self.pkg_config, "PATH": f"{weir}:{os.environ['PATH']}"})
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertRegex(done.stdout, r"limit +integer +127 +above it is 1")
        self.assertIn("EOS", done.stdout)
        out, output, code = self.play([[1, 99, 100, 255]], "framework=threshold custom=limit:99", "uint8")
        self.assertEqual(code, 0, output)
        self.assertEqual(list(out), [0, 0, 1, 1])

    def test_dynamic_shapes_and_memory_of_their_own(self):
        for name in ("outside-c", "outside-cpp"):
            with self.subTest(name):
                out, output, code = self.play([[1, -2, 3], [-1, 4, -1]], f"framework={name} custom=factor:2")
                self.assertEqual(code, 0, output)
                self.assertEqual(self.flexible(out, [3, 2, 3, 1]), [[2, -4, 6], [1, 3], [-2, 8, -2], [4]])

    def test_an_engine_of_two_classes(self):
        model = self.folder / "x.doubled"
        model.touch()
        out, output, code = self.play([[1, -2, 3, 4]], f"framework=outside-two-classes model={model}")
        self.assertEqual(code, 0, output)
        self.assertEqual(struct.unpack("<4f", out), (2, -4, 6, 8))
        _, output, code = self.play([[1, 2, 3, 4]], f"framework=outside-two-classes model={model},{model}")
        self.assertNotEqual(code, 0)
        for words in ("WEIR-", "the engine needs one file", "model=FILE.doubled"):
            self.assertIn(words, output)
        _, output, code = self.play([[1, 2, 3]], f"framework=outside-two-classes model={model}")
        self.assertNotEqual(code, 0, "three values into a model of four")

    def test_a_frame_that_they_drop(self):
        for name in ("outside-c", "outside-cpp"):
            with self.subTest(name):
                out, output, code = self.play([[5], [6]], f"framework={name}")
                self.assertEqual((out, code), (b"", 0), output)

    def test_any_number_of_outputs_asynchronously(self):
        for name in ("outside-c", "outside-cpp"):
            with self.subTest(name):
                out, output, code = self.play([[1, 2], [3, 4]], f"framework={name} invoke-async=true custom=repeat:2")
                self.assertEqual(code, 0, output)
                self.assertEqual(self.flexible(out, [2] * 8),
                                 [[1, 2], [1, 2], [2, 4], [1, 2], [3, 4], [3, 4], [6, 8], [3, 4]])

    def test_error_texts(self):
        for name in ("outside-c", "outside-cpp"):
            with self.subTest(name):
                for more in ("", " invoke-async=true"):
                    _, output, code = self.play([[1, float("nan")]], f"framework={name}{more}")
                    self.assertNotEqual(code, 0)
                    for words in ("WEIR-3006: a value is not a number", "offered: NaN", "needed: numbers",
                                  "first difference: the first NaN", "fix: clean the input"):
                        self.assertIn(words, output)
                _, output, code = self.play([[1, 2]], f"framework={name} custom=factor:two")
                self.assertNotEqual(code, 0)
                self.assertIn(f"WEIR-1004: the engine {name} does not accept this value for factor", output)
                self.assertIn("fix: custom=factor:1", output)

    def edit(self, name, command):
        """Sends the command while a frame with an hour of work is processed; returns stderr and stdout."""
        line = f"tensor_filter name=f framework={name} invoke-async=true async-timeout=0 custom=rest:3600 ! fakesink async=false"
        with subprocess.Popen([self.folder / "edited", line], env=self.env, text=True, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE) as program:
            output = ""
            try:
                program.stdin.write("frame\n")
                program.stdin.flush()
                while "a request rests" not in output:
                    more = program.stderr.readline()
                    self.assertTrue(more, output)
                    output += more
                answered, rest = program.communicate(command, timeout=120)  # far less than an hour, far more than needed
            finally:
                program.kill()
            self.assertEqual(program.returncode, 0, output + rest)
            return output + rest, answered

    def test_a_request_that_a_flush_or_a_stop_cancels(self):
        for name in ("outside-c", "outside-cpp"):
            with self.subTest(name):
                output, answered = self.edit(name, "stop\n")
                self.assertEqual(output.count(f"{name}: cancel() was called"), 1, output)
                self.assertIn("stopped: held 0, pushed 0\n", answered)
                # The second frame replaces the first, which was cancelled.
                output, answered = self.edit(name, "flush\nframe\nstop\n")
                self.assertEqual(output.count(f"{name}: cancel() was called"), 2, output)
                self.assertEqual(output.count(f"{name}: a request rests"), 2, output)
                self.assertIn("flushed: held 0, pushed 0\n", answered)
                self.assertIn("stopped: held 0, pushed 0\n", answered)

    def test_a_request_that_is_cancelled_at_its_time_out(self):
        for name in ("outside-c", "outside-cpp"):
            with self.subTest(name):
                _, output, code = self.play([[1, 2]], f"framework={name} invoke-async=true async-timeout=100 custom=rest:3600")
                self.assertNotEqual(code, 0)
                self.assertIn("WEIR-3015: the engine did not answer in time", output)
                self.assertIn(f"{name}: cancel() was called", output)

    def test_options_with_types_and_help(self):
        for name in ("threshold", "outside-cpp", "outside-c"):
            with self.subTest(name):
                done = run([os.environ["WEIR_COMMAND"], "inspect", "--engine", name], env=self.env)
                self.assertEqual(done.returncode, 0, done.stderr)
                option, kind, text = ("limit", "integer", "above it is 1") if name == "threshold" else \
                    ("factor", "number", "what the input is multiplied with")
                self.assertTrue(re.search(rf"{option} +{kind} +\S+ +{text}", done.stdout), done.stdout)
                # The suggested command has no model, because there is none, and it runs.
                line = re.search(rf"gst-launch-1.0 (.*tensor_filter framework={name} ! fakesink)", done.stdout)
                self.assertTrue(line, done.stdout)
                done = run(["sh", "-c", f"{os.environ['WEIR_COMMAND']} run {line.group(1)}"], env=self.env)
                self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_a_module_for_another_major_version_is_refused(self):
        include = self.folder / "other"
        shutil.copytree(SOURCE / "include", include)
        header = include / "weir/abi.h"
        text = header.read_text(encoding="utf-8")
        major = int(re.search(r"define WEIR_ABI_MAJOR (\d+)", text).group(1))
        header.write_text(text.replace(f"WEIR_ABI_MAJOR {major}", f"WEIR_ABI_MAJOR {major + 1}"), encoding="utf-8")
        built = run(["c++", "-std=c++20", "-shared", "-fPIC", f"-I{include}", SOURCE / "tests/abi/outside/threshold.cpp",
                     "-o", self.folder / "libweir-engine-tomorrow.so"])
        self.assertEqual(built.returncode, 0, built.stderr)
        _, output, code = self.play([[1]], "framework=tomorrow", "uint8")
        self.assertNotEqual(code, 0)
        self.assertIn("WEIR-3007", output)
        self.assertIn("the module was built for another major version of Weir's ABI: build it again", output)

    def test_a_module_of_a_later_minor_version_runs(self):
        """Every table and struct that may grow has grown; the frozen ones have not."""
        include = self.folder / "later"
        shutil.copytree(SOURCE / "include", include)
        header = include / "weir/abi.h"
        text = re.sub(r"define WEIR_ABI_MINOR (\d+)", lambda found: f"define WEIR_ABI_MINOR {int(found.group(1)) + 1}",
                      header.read_text(encoding="utf-8"))
        text, grown = re.subn(r"\n\} (weir_frame|weir_host|weir_open|weir_model_info|weir_engine|weir_module);",
                              r"\n  void* of_tomorrow[4];\n} \1;", text)
        self.assertEqual(grown, 6)
        header.write_text(text, encoding="utf-8")
        self.expect_to_run("later", include)

    def test_a_module_built_with_the_headers_of_the_baseline_runs(self):
        """Parts that these headers do not have stand in `#if WEIR_ABI_MINOR >= N` in every_part.c and every_part.cpp."""
        self.expect_to_run("baseline", SOURCE / "tests/abi/baseline/include")

    def expect_to_run(self, prefix, include):
        for name, source in ((f"{prefix}-c", "every_part.c"), (f"{prefix}-cpp", "every_part.cpp")):
            with self.subTest(name):
                self.build(name, source, [f"-I{include}", "-Wno-error"])
                out, output, code = self.play([[1, -2, 3]], f"framework={name} custom=factor:2")
                self.assertEqual(code, 0, output)
                self.assertEqual(self.flexible(out, [3, 2]), [[2, -4, 6], [1, 3]])


if __name__ == "__main__":
    tap_runner.main()
