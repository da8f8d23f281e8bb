#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""The build folder: the commands of the guides work from it before anything is installed (`meson devenv`), and the demos are
built without what they do not run."""

import json
import os
import pathlib
import re
import subprocess
import tempfile
import unittest

import tap_runner

SOURCE = pathlib.Path(os.environ["WEIR_SOURCE"])
NAMES = ("GST_PLUGIN_PATH", "GST_REGISTRY", "PYTHONPATH", "WEIR_CARD_PATH", "WEIR_COMMAND", "WEIR_MODULE_PATH",
         "WEIR_NNSTREAMER_LIBRARY", "WEIR_WORKER")


class BuildFolder(unittest.TestCase):
    def run_there(self, *command):
        with tempfile.TemporaryDirectory() as home:
            env = {name: value for name, value in os.environ.items() if name not in NAMES}
            env |= {"GST_REGISTRY": home + "/registry.bin", "GST_TRACERS": "", "GST_DEBUG": ""}
            return subprocess.run(["meson", "devenv", "-C", os.environ["WEIR_BUILD"], "-w", str(SOURCE), *command], env=env,
                                  capture_output=True, text=True, timeout=200, check=False)

    def test_the_command_is_found_and_finds_the_plugin_and_the_modules(self):
        done = self.run_there("weir", "doctor")
        self.assertIn(str(pathlib.Path(os.environ["GST_PLUGIN_PATH"]) / "libgstweir.so"), done.stdout, done.stderr)
        self.assertIn("image_labeling", done.stdout, done.stderr)

    def test_the_catalogue_of_models_is_found(self):
        done = self.run_there("weir", "models", "info", "mnist")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertIn("mnist.onnx", done.stdout)

    def test_a_model_runs_in_a_process_of_its_own(self):
        done = self.run_there("weir", "run", "filesrc location=/dev/zero blocksize=192 num-buffers=3 ! application/octet-stream ! "
                              "tensor_converter input-dim=3:8:8:1 input-type=uint8 ! tensor_filter isolate=process "
                              "model=src/modules/engines/lua/halves.lua ! fakesink")
        if "apt-get install libluajit" in done.stderr:
            self.skipTest("LuaJIT is missing")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_a_custom_filter_that_calls_the_library_runs(self):
        custom = pathlib.Path(os.environ["WEIR_BUILD"]) / "tests/compat/filters/scaler.so"
        if not custom.exists():
            self.skipTest("built without compat")
        done = self.run_there("weir", "run", "videotestsrc num-buffers=2 ! video/x-raw,format=RGB,width=8,height=8 ! tensor_converter ! "
                              f"tensor_filter framework=custom model={custom} custom=4x4 ! "
                              "other/tensor,dimension=3:4:4:1,type=uint8 ! fakesink")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_programs_compile_and_run_with_each_package(self):
        sources = {"nnstreamer": ("c", "nnstreamer_plugin_api.h", "gst_tensor_get_type(\"uint8\") != _NNS_UINT8"),
                   "nnstreamer-single": ("c", "nnstreamer_plugin_api_util.h", "gst_tensor_get_type(\"uint8\") != _NNS_UINT8"),
                   "nnstreamer-internal": ("c", "nnstreamer/nnstreamer_internal.h", "gst_tensor_get_format(NULL) == 0"),
                   "nnstreamer-cpp": ("c++", "nnstreamer_cppplugin_api_filter.hh", "get_accl_hw_type(\"gpu\") != ACCL_GPU"),
                   "capi-nnstreamer": ("c", "nnstreamer.h", "ML_ERROR_NONE != 0 || ml_error() != NULL"),
                   "capi-ml-common": ("c", "ml-api-common.h", "!ml_strerror(ML_ERROR_IO_ERROR)"),
                   "capi-ml-inference-single": ("c", "nnstreamer-single.h", "ml_single_close(NULL) != ML_ERROR_INVALID_PARAMETER"),
                   "capi-ml-inference": ("c", "nnstreamer.h", "ml_pipeline_start(NULL) != ML_ERROR_INVALID_PARAMETER"),
                   "weir": ("c", "weir/model.h", "weir_model_input_count(0) != 0"),
                   "weir-module": ("c", "weir/abi.h", "!WEIR_ABI_MAJOR")}
        options = json.loads((pathlib.Path(os.environ["WEIR_BUILD"]) / "meson-info" / "intro-buildoptions.json").read_text())
        options = {option["name"]: option["value"] for option in options}
        if not options["compat"]:
            self.skipTest("built without compat")
        if options["b_sanitize"] != "none":
            self.skipTest("a program without a sanitizer cannot use a library built with one")
        for package, (language, header, failed) in sources.items():
            with self.subTest(package), tempfile.TemporaryDirectory() as folder:
                source = pathlib.Path(folder) / "program.txt"
                source.write_text(f"#include <{header}>\nint main(void) {{ return {failed}; }}\n")
                compiler = "g++ -std=c++17" if language == "c++" else "gcc"
                done = self.run_there(
                    "sh", "-c", f"cd {folder} && {compiler} -x {language} program.txt -x none -o program -Wl,--no-as-needed "
                    f"$(pkg-config --cflags --libs {package}) && "
                    f"LD_LIBRARY_PATH=$(pkg-config --libs-only-L {package} | sed 's/ *-L/:/g; s/ //g') ./program")
                self.assertEqual(done.returncode, 0, done.stdout + done.stderr)


class Demos(unittest.TestCase):
    def ninja(self, *options):
        done = subprocess.run(["ninja", "-C", os.environ["WEIR_BUILD"], *options], capture_output=True, text=True, timeout=60,
                              check=True)
        return done.stdout.split()

    def inputs(self, target):
        """Every file that `ninja TARGET` makes or reads; ninja counts neither order-only inputs nor those of the target itself."""
        return self.ninja("-t", "inputs", target) + self.ninja("-t", "query", target)

    def test_each_builds_what_it_runs(self):
        for target, files in {"demo": ["src/plugin/libgstweir.so"],
                              "demo-input": ["src/plugin/libgstweir.so", "apps/weir/weir"],
                              "demo-faces": ["src/plugin/libgstweir.so", "examples/mtcnn/mtcnn"]}.items():
            self.assertEqual([file for file in files if file not in self.inputs(target)], [], target)

    def test_none_builds_tests_benchmarks_or_what_is_for_programs_of_nnstreamer(self):
        for target in ("demo", "demo-input", "demo-faces"):
            needless = [file for file in self.inputs(target)
                        if re.search(r"_test\b|^(\.\./)?(tests|benchmarks)/|src/(compat|application)/", file)]
            self.assertEqual(needless, [], target)


if __name__ == "__main__":
    tap_runner.main()
