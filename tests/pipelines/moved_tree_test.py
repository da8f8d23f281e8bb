#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""An installed tree that was moved: the plug-in, the command and the worker find their modules beside themselves."""

import os
import pathlib
import shutil
import subprocess
import tempfile
import unittest

import tap_runner

BUILD = pathlib.Path(os.environ["WEIR_BUILD"])
LIBRARIES = os.environ["WEIR_LIBDIR"]  # relative to the prefix
# Built files and their places below a prefix.
FILES = {"src/plugin/libgstweir.so": f"{LIBRARIES}/gstreamer-1.0", "apps/weir/weir": "bin", "src/weir-worker": "libexec/weir",
         "src/pipeline/libweir-pipeline.so.0": LIBRARIES, "tests/support/libweir-engine-fake.so": f"{LIBRARIES}/weir/modules"}


class MovedTree(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp())
        self.addCleanup(shutil.rmtree, self.folder)
        self.tree = self.folder / "a place of its own"
        for file, place in FILES.items():
            (self.tree / place).mkdir(parents=True, exist_ok=True)
            shutil.copy(BUILD / file, self.tree / place)
        # Of the rpath of the installed plug-in, $ORIGIN/.., and of that of the build.
        for place in (LIBRARIES, f"{LIBRARIES}/library"):
            (self.tree / place).mkdir(exist_ok=True)
            shutil.copy(BUILD / "src/library/libweir.so.0", self.tree / place)
        self.model = self.folder / "model"
        self.model.write_text("any")
        self.line = ("videotestsrc num-buffers=3 ! video/x-raw,format=RGBA,width=4,height=1 ! tensor_converter ! tensor_transform mode=typecast "
                     f"option=float32 ! tensor_filter framework=fake model={self.model} ! fakesink")
        keep = {name: value for name, value in os.environ.items() if not name.startswith("WEIR_") and name != "LD_LIBRARY_PATH"}
        self.env = {**keep, "GST_PLUGIN_PATH": str(self.tree / LIBRARIES / "gstreamer-1.0"), "GST_REGISTRY": str(self.folder / "registry"),
                    "WEIR_CONFIG": "", "LD_LIBRARY_PATH": str(self.tree / LIBRARIES)}

    def run_line(self, *words):
        return subprocess.run(list(map(str, words)), env=self.env, capture_output=True, text=True, timeout=120)

    def good(self, done):
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done.stdout

    def test_the_plug_in_finds_its_modules(self):
        self.good(self.run_line("gst-launch-1.0", *self.line.split()))

    def test_the_command_and_the_worker_do_too(self):
        self.assertIn("3 frames", self.good(self.run_line(self.tree / "bin/weir", "run", self.line)))
        isolated = self.line.replace("framework=fake", "framework=fake isolate=process")
        self.assertIn("3 frames", self.good(self.run_line(self.tree / "bin/weir", "run", isolated)))

    def test_it_moves_again(self):
        other = self.folder / "other"
        self.tree.rename(other)
        self.env = {name: value.replace(str(self.tree), str(other)) for name, value in self.env.items()}
        self.assertIn("3 frames", self.good(self.run_line(other / "bin/weir", "run", self.line)))

    @unittest.skipUnless(os.environ["WEIR_DOC_FOLDER"], "the documents have an address")
    def test_the_documents_are_those_of_this_tree(self):
        folder = f"file://{self.tree}/{os.environ['WEIR_DOC_FOLDER']}".replace(" ", "%20")
        inspected = {name: self.good(self.run_line("gst-inspect-1.0", "--no-colors", name)) for name in ("tensor_sink", "weir")}
        self.assertIn(f"{folder}/src/elements/tensor_sink/README.md\n", inspected["tensor_sink"])
        self.assertIn(f"{folder}/README.md\n", inspected["weir"])

    def test_files_of_the_usual_prefix_are_those_of_this_tree(self):
        folder = self.tree / "share/weir/models"
        folder.mkdir(parents=True)
        for name in ("net.onnx", "net.card.json"):
            (folder / name).write_text("any")
        other = "/usr/none/share/weir/models/net"
        done = self.run_line(self.tree / "bin/weir", "run", self.line.replace(str(self.model), f"{other}.onnx"))
        self.assertIn(f"""fix: model='"{folder}/net.onnx"'\n""", done.stderr)  # a line for a shell
        done = self.run_line(self.tree / "bin/weir", "run", f"videotestsrc ! tensor_preprocess card={other}.card.json ! fakesink")
        self.assertIn(f"""fix: card='"{folder}/net.card.json"'\n""", done.stderr)

    def test_without_its_modules_the_engine_is_missing(self):
        shutil.rmtree(self.tree / LIBRARIES / "weir")
        done = self.run_line(self.tree / "bin/weir", "run", self.line)
        self.assertEqual(done.returncode, 1)
        self.assertIn("WEIR-3001: no engine has this name\n  offered: framework=fake", done.stderr)


if __name__ == "__main__":
    tap_runner.main()
