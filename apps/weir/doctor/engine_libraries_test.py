#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Tests of engines whose module or library is missing or of another version: the error and its fix."""

import json
import os
import pathlib
import re
import shutil
import subprocess
import unittest

import tap_runner
from weir_case import MODEL, SOURCE, Case, weir

ENGINES = SOURCE / "src/modules/engines"
READMES = {"onnxruntime": "onnxruntime", "tensorflow-lite": "tensorflow-lite", "pytorch": "pytorch", "caffe": "opencv-dnn",
           "tensorflow": "opencv-dnn", "darknet": "opencv-dnn", "python3": "python3", "lua": "lua"}
LUA, PYTHON = ENGINES / "lua/halves.lua", ENGINES / "python3/passthrough.py"


def built(engine):
    return any((pathlib.Path(f) / f"libweir-engine-{engine}.so").exists() for f in os.environ["WEIR_MODULE_PATH"].split(":"))


def functions(header, table):
    """The names in a table X(result, name, arguments) of functions."""
    text = (SOURCE / header).read_text()
    part = text[text.index(f"#define {table}(X)"):]
    return re.findall(r"\bX\([^,]+, (\w+),", part[:part.index("\n\n")])


class EngineLibraries(Case):
    def error(self, *words, **variables):
        done = weir("inspect", "--json", *words, **variables)
        self.assertEqual(done.returncode, 1, done.stdout + done.stderr)
        return json.loads(done.stdout)["error"]

    def library(self, name, source):
        """Builds a library with this name in its own folder and returns the folder."""
        compiler = shutil.which("cc")
        if not compiler:
            self.skipTest("cc is not there")
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        subprocess.run([compiler, "-shared", "-fPIC", "-w", "-fno-builtin", f"-Wl,-soname,{path.name}", "-x", "c", "-", "-o", path],
                       input=source, text=True, check=True)
        return path.parent

    def doctor(self, engine, **variables):
        report = json.loads(self.good(weir("doctor", "--json", **variables)))
        return next(e for e in report["engines"] if e["name"] == engine)

    def test_a_module_that_is_not_there_comes_with_the_line_of_its_readme(self):
        for engine, folder in READMES.items():
            with self.subTest(engine=engine):
                error = self.error("-f", engine, MODEL, WEIR_MODULE_PATH=str(self.folder))
                self.assertEqual((error["id"], error["what"]), ("WEIR-3002", f"the engine {engine} is not installed"))
                command, build = error["fix"].split(" && ")
                self.assertEqual(build, "make build")
                self.assertIn(f"`{command}`", (ENGINES / folder / "README.md").read_text())

    @unittest.skipUnless(built("onnxruntime"), "the engine onnxruntime is not built")
    def test_an_onnx_runtime_that_is_too_old(self):
        self.library("onnxruntime/lib/libonnxruntime.so.1", """
            static const void* api(unsigned version) { static char table[4096]; return version <= 11 ? table : 0; }
            static const char* version(void) { return "1.11.1"; }
            static const struct { const void* (*api)(unsigned); const char* (*version)(void); } base = {api, version};
            const void* OrtGetApiBase(void) { return &base; }""")
        where = {"WEIR_ENGINES_DIR": str(self.folder)}
        error = self.error(MODEL, **where)
        self.assertEqual((error["id"], error["what"]), ("WEIR-3002", "the library of ONNX Runtime cannot be used"))
        self.assertEqual(error["offered"], f"{self.folder}/onnxruntime/lib/libonnxruntime.so.1: version 1.11.1 is too old")
        self.assertRegex(error["needed"], r"^ONNX Runtime with C API \d+$")
        self.assertEqual(error["fix"], "tools/setup --engine onnxruntime")
        engine = self.doctor("onnxruntime", **where)
        self.assertEqual(engine["state"], "not installed")
        self.assertIn("version 1.11.1 is too old", engine["problem"])

    @unittest.skipUnless(built("onnxruntime"), "the engine onnxruntime is not built")
    def test_an_onnx_runtime_of_the_system(self):
        path = pathlib.Path(self.doctor("onnxruntime")["library"])
        if path.parts[-3] == "onnxruntime":
            self.skipTest("the module was built for the fetched library")
        folder = self.library(path.name, "int nothing;")
        error = self.error(MODEL, LD_LIBRARY_PATH=str(folder))
        self.assertEqual((error["id"], error["offered"]), ("WEIR-3002", f"{folder}/{path.name}: no symbol OrtGetApiBase"))
        self.assertEqual(error["fix"], f"apt-get install --reinstall {path.name.replace('.so.', '')}")
        (folder / path.name).write_text("no library")
        self.assertIn("exists but cannot be loaded", self.error(MODEL, LD_LIBRARY_PATH=str(folder))["what"])
        self.library("onnxruntime/lib/libonnxruntime.so.1", "int nothing;")
        self.assertIn(f"{self.folder}/onnxruntime/lib/libonnxruntime.so.1: ", self.error(MODEL, WEIR_ENGINES_DIR=str(self.folder))["offered"])

    @unittest.skipUnless(built("onnxruntime"), "the engine onnxruntime is not built")
    def test_onnx_runtime_sends_no_telemetry(self):
        """From 1.29 on, it stores a machine number and reports opened models, unless a variable indicates a CI run."""
        kept = ("PATH", "LD_", "GST_", "WEIR_", "ASAN_", "LSAN_", "UBSAN_")
        environment = {name: value for name, value in os.environ.items() if name.startswith(kept)}
        done = subprocess.run([os.environ["WEIR_COMMAND"], "inspect", MODEL], text=True, capture_output=True, timeout=60, check=False,
                              env={**environment, "HOME": str(self.folder), "XDG_CACHE_HOME": str(self.folder / "cache")})
        self.assertIn("Engine  onnxruntime", self.good(done))
        self.assertEqual([path for path in self.folder.rglob("*") if "gstreamer" not in str(path)], [])

    @unittest.skipUnless(built("onnxruntime"), "the engine onnxruntime is not built")
    def test_a_library_that_is_another(self):
        self.library("onnxruntime/lib/libonnxruntime.so.1", "int nothing;")
        self.assertIn("no symbol OrtGetApiBase", self.error(MODEL, WEIR_ENGINES_DIR=str(self.folder))["offered"])

    @unittest.skipUnless(built("tensorflow-lite"), "the engine tensorflow-lite is not built")
    def test_a_tensorflow_lite_of_another_version(self):
        text = (ENGINES / "tensorflow-lite/tflite_api.cpp").read_text()
        names = set(re.findall(r'"(TfLite\w+)"\)', text)) - {"TfLiteVersion"}
        model = self.folder / "model.tflite"
        model.write_bytes(b"\x10\0\0\0TFL3")
        for version, good in (("2.8.4", False), ("1.15.0", False), ("3.0.0", False), ("nightly", False), ("2.9.0", True), ("2.18.1", True)):
            with self.subTest(version=version):
                self.library("tensorflow-lite/lib/libtensorflowlite_c.so", f'const char* TfLiteVersion(void) {{ return "{version}"; }}\n'
                             + "".join(f"long {name}(void) {{ return 0; }}\n" for name in names))
                where = {"WEIR_ENGINES_DIR": str(self.folder)}
                engine = self.doctor("tensorflow-lite", **where)
                self.assertEqual(engine["state"], "usable" if good else "not installed")
                if good:
                    self.assertEqual(engine["version"], version)
                    continue
                error = self.error(model, **where)
                self.assertEqual((error["id"], error["what"]), ("WEIR-3002", "the library of TensorFlow Lite cannot be used"))
                self.assertTrue(error["offered"].endswith(f"libtensorflowlite_c.so: version {version} is not supported"), error["offered"])
                self.assertIn("TensorFlow Lite 2.9 or a later 2.x", error["needed"])
                self.assertIn(f"version {version} is not supported", engine["problem"])

    def test_a_luajit_of_another_version(self):
        names = functions("src/modules/engines/lua/lua_api.hpp", "WEIR_LUA_FUNCTIONS")
        self.assertIn("luaL_newstate", names)
        own = {"luaL_newstate": "long luaL_newstate(void) { return 1; }",
               "lua_gettop": "int lua_gettop(void) { return 1; }",
               "lua_type": "int lua_type(void) { return 5; }",
               "lua_tonumber": "double lua_tonumber(void) { return 20004; }",
               "lua_tolstring": 'const char* lua_tolstring(void) { return "LuaJIT 2.0.4"; }'}
        stubs = [own.get(name, f"long {name}(void) {{ return 0; }}") for name in names]
        folder = self.library("libluajit-5.1.so.2", "\n".join(stubs))
        error = self.error(LUA, LD_LIBRARY_PATH=str(folder))
        self.assertEqual((error["id"], error["what"]), ("WEIR-3002", "the LuaJIT on this machine cannot be used"))
        self.assertEqual(error["offered"], f"{folder}/libluajit-5.1.so.2: LuaJIT 2.0.4 is too old")
        self.assertEqual(error["fix"], "apt-get install libluajit-5.1-2")
        self.assertIn("LuaJIT 2.0.4 is too old", self.doctor("lua", LD_LIBRARY_PATH=str(folder))["problem"])
        self.library("libluajit-5.1.so.2", "\n".join(stubs[1:]))
        self.assertEqual(self.error(LUA, LD_LIBRARY_PATH=str(folder))["offered"], f"no symbol {names[0]}")

    def test_luajit_reports_its_own_version(self):
        engine = self.doctor("lua")
        if engine["state"] != "usable":
            self.skipTest("LuaJIT is not installed")
        self.assertRegex(engine["version"], r"^LuaJIT 2\.1\.\S+$")

    def test_a_python_of_another_version(self):
        for version in ("2.7.18", "3.8.20", "4.0.0"):
            folder = self.library("libpython.so", f'const char* Py_GetVersion(void) {{ return "{version} (main, today)"; }}')
            error = self.error(PYTHON, WEIR_PYTHON_LIBRARY=f"{folder}/libpython.so")
            self.assertEqual((error["id"], error["what"]), ("WEIR-3002", "the Python on this machine cannot be used"))
            self.assertEqual(error["offered"], f"{folder}/libpython.so: Python {version} is not supported")
            self.assertEqual((error["needed"], error["fix"]),
                             ("libpython3, version 3.9 or later", "apt-get install libpython3-dev python3-numpy"))
        self.library("libpython.so", 'const char* Py_GetVersion(void) { return "3.11.2"; }')
        self.assertIn("a library without Py", self.error(PYTHON, WEIR_PYTHON_LIBRARY=f"{folder}/libpython.so")["offered"])

    def linked(self, engine, *libraries):
        """A module that links libraries, when others are found before them."""
        for name in libraries:
            self.library(name, "int nothing;")
        error = self.error("-f", engine, MODEL, LD_LIBRARY_PATH=str(self.folder))
        self.assertEqual((error["id"], error["what"]),
                         ("WEIR-3002", f"a library of the engine {engine} differs from the one the module was built with"))
        self.assertRegex(error["offered"], "undefined symbol|version `")
        self.assertIn("the version of the library that the module was built with", error["needed"])
        self.assertIn("apt-get install", error["fix"])

    @unittest.skipUnless(built("caffe"), "the engine caffe is not built")
    def test_an_opencv_of_another_version(self):
        module = next(f for f in os.environ["WEIR_MODULE_PATH"].split(":") if (pathlib.Path(f) / "libweir-engine-caffe.so").exists())
        needed = subprocess.run(["objdump", "-p", f"{module}/libweir-engine-caffe.so"], capture_output=True, text=True, check=True).stdout
        self.linked("caffe", *re.findall(r"NEEDED +(libopencv_dnn\S+)", needed))

    @unittest.skipUnless(built("pytorch"), "the engine pytorch is not built")
    def test_a_libtorch_of_another_version(self):
        module = next(f for f in os.environ["WEIR_MODULE_PATH"].split(":") if (pathlib.Path(f) / "libweir-engine-pytorch.so").exists())
        needed = subprocess.run(["objdump", "-p", f"{module}/libweir-engine-pytorch.so"], capture_output=True, text=True, check=True).stdout
        self.linked("pytorch", *re.findall(r"NEEDED +(libtorch\S+|libc10\S+)", needed))


if __name__ == "__main__":
    os.environ.pop("GST_DEBUG", None)
    tap_runner.main()
