#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Tests that each header of include/nnstreamer compiles alone as C99 and as C++11 without warnings."""

import os
import pathlib
import shlex
import subprocess
import unittest

import tap_runner

HEADERS = pathlib.Path(os.environ["WEIR_SOURCE"]) / "include" / "nnstreamer"
STRICT = ["-Wall", "-Wextra", "-Wpedantic", "-Werror", "-fsyntax-only"]
WANTED = """nnstreamer_cppplugin_api_filter.hh nnstreamer_internal.h nnstreamer_plugin_api.h nnstreamer_plugin_api_converter.h
nnstreamer_plugin_api_decoder.h nnstreamer_plugin_api_filter.h nnstreamer_plugin_api_trainer.h
nnstreamer_plugin_api_util.h nnstreamer_util.h nnstreamer_version.h tensor_converter_custom.h tensor_decoder_custom.h
tensor_filter_cpp.hh tensor_filter_custom.h tensor_filter_custom_easy.h tensor_filter_single.h tensor_if.h tensor_typedef.h""".split()
NEED_NO_GLIB = {"tensor_typedef.h", "tensor_filter_custom.h", "tensor_filter_custom_easy.h", "tensor_if.h",
                "nnstreamer_util.h", "nnstreamer_version.h"}


def gstreamer():
    output = subprocess.run(["pkg-config", "--cflags", "gstreamer-1.0"], capture_output=True, text=True, check=True)
    return [word.replace("-I", "-isystem", 1) for word in shlex.split(output.stdout)]


def compile_alone(language, standard, compiler, name, how):
    source = how.format(name=name) + "\nint main(void) { return 0; }\n"
    flags = [] if name in NEED_NO_GLIB else gstreamer()
    return subprocess.run([*shlex.split(compiler), "-x", language, f"-std={standard}", *STRICT, "-I", HEADERS, "-I",
                           HEADERS.parent, *flags, "-"], input=source, capture_output=True, text=True, check=False)


class Headers(unittest.TestCase):
    def test_all_names_are_there(self):
        there = {path.name for path in HEADERS.iterdir()}
        self.assertEqual(set(WANTED) - there, set())

    def test_compile_alone_as_c99(self):
        for name in sorted(path.name for path in HEADERS.glob("*.h")):
            done = compile_alone("c", "c99", os.environ["WEIR_CC"], name, '#include "{name}"')
            self.assertEqual(done.returncode, 0, f"{name}\n{done.stderr}")

    def test_compile_alone_as_cpp11_with_the_folder_in_front(self):
        for name in sorted(path.name for path in HEADERS.glob("*.h*")):
            done = compile_alone("c++", "c++11", os.environ["WEIR_CXX"], name, "#include <nnstreamer/{name}>")
            self.assertEqual(done.returncode, 0, f"{name}\n{done.stderr}")

    def test_name_the_versions_of_a_descriptor_on_request(self):
        how = "#define NO_ANONYMOUS_NESTED_STRUCT\n#include <nnstreamer/{name}>\n"
        how += "int reads(GstTensorFilterFramework f) {{ return f.v0.invoke_NN && f.v1.invoke; }}"
        for language, standard, compiler in ("c", "c99", "WEIR_CC"), ("c++", "c++11", "WEIR_CXX"):
            done = compile_alone(language, standard, os.environ[compiler], "nnstreamer_plugin_api_filter.h",
                                 how.replace("int reads", "int reads(GstTensorFilterFramework f);\nint reads"))
            self.assertEqual(done.returncode, 0, done.stderr)


if __name__ == "__main__":
    tap_runner.main()
