#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Tests of unreadable weir.ini and nnstreamer.ini files with `weir doctor` and a running pipeline."""

import json
import os

import tap_runner
from weir_case import Case, weir

# Only the engines of the tests: `weir doctor` opens all.
os.environ["WEIR_MODULE_PATH"] = os.environ["WEIR_MODULE_PATH"].split(":")[0]
# A zero byte, invalid UTF-8, a terminal control sequence.
BINARY = b"\x7fELF\x00\xff\xfe[filter\n\xff\xc3\x28=\x1b[2J\n[filter]\npriority_onnx=\xff\x00\n"
PIPELINE = ("videotestsrc num-buffers=3 ! video/x-raw,format=GRAY8,width=4,height=4 ! tensor_converter"
            " ! tensor_transform mode=typecast option=float32 ! tensor_filter framework=scaling custom=any:1 model={model} ! tensor_sink")


class UnreadableConfiguration(Case):
    def file(self, kind, name):
        """A file of that kind, and the expected text about it."""
        path = self.folder / name
        if kind == "folder":
            path.mkdir()
            return path, f"{path} (it is a folder)"
        if kind == "pipe":
            os.mkfifo(path)
            return path, f"{path} (it is not a regular file)"
        if kind == "loop":
            path.symlink_to(path)
            return path, f"{path} (Too many levels of symbolic links)"
        if kind == "binary":
            path.write_bytes(BINARY)
            return path, f"{path}:1: the line is not text: ?ELF"
        path.write_bytes(b"[filter]\npriority_onnx=a\n" + b"#" * (1 << 20))
        return path, f"{path}: the file is too long"

    def model(self):
        path = self.folder / "model"
        path.write_text("x")
        return path

    def test_doctor_names_a_weir_ini_that_it_cannot_read(self):
        for kind in ("folder", "pipe", "loop", "binary", "long"):
            with self.subTest(kind):
                path, words = self.file(kind, kind + ".ini")
                report = json.loads(self.good(weir("doctor", "--json", WEIR_CONFIG=str(path))))["configuration"]
                state = "read" if kind in ("binary", "long") else "cannot be read"
                self.assertEqual(report["files"], [{"path": str(path), "state": state}])
                self.assertIn(words, "\n".join(report["problems"]))
                self.assertEqual({s["origin"] for s in report["settings"]}, {"WEIR_MODULE_PATH", "WEIR_NNSTREAMER_ENABLE"})

    def test_doctor_names_a_weir_ini_of_a_users_folder_too(self):
        (self.folder / "weir").mkdir()
        path, words = self.file("folder", "weir/weir.ini")
        without = {"HOME": str(self.folder), "XDG_CONFIG_HOME": str(self.folder)}
        old = os.environ.pop("WEIR_CONFIG")
        self.addCleanup(os.environ.__setitem__, "WEIR_CONFIG", old)
        output = self.good(weir("doctor", "--all", **without))
        self.assertIn(f"  {path}: cannot be read\n", output)
        self.assertIn(f"    reason: the configuration file cannot be read: {words}\n", output)

    def test_doctor_shows_no_bytes_that_are_no_text(self):
        path, words = self.file("binary", "weir.ini")
        output = self.good(weir("doctor", "--all", WEIR_CONFIG=str(path)))
        self.assertIn(f"    reason: {words}???[filter\n", output)
        self.assertIn(f"    reason: {path}:4: the line is not text: priority_onnx=??\n", output)

    def test_doctor_names_an_nnstreamer_ini_that_it_cannot_read(self):
        for kind in ("folder", "pipe", "loop", "binary", "long"):
            with self.subTest(kind):
                path, words = self.file(kind, kind + ".ini")
                if kind == "loop":  # a link that cannot be followed may represent a file
                    words = f"the configuration file cannot be read: {path} (Too many levels of symbolic links)"
                elif kind not in ("binary", "long"):
                    words = f"NNSTREAMER_CONF does not name a regular file and is ignored: {path}"
                variables = {"NNSTREAMER_CONF": str(path), "WEIR_NNSTREAMER_ENABLE": "yes"}
                report = json.loads(self.good(weir("doctor", "--json", **variables)))["nnstreamer"]
                self.assertIn(words, "\n".join(report["problems"]))
                self.assertIn(f"NNSTREAMER_CONF): {path}\n", self.good(weir("check", **variables)))

    def test_doctor_names_an_additional_file_that_it_cannot_read(self):
        path, words = self.file("folder", "extra.ini")
        ini = self.folder / "nns.ini"
        ini.write_text(f"[common]\nextra_config_path={path}\n")
        output = self.good(weir("doctor", "--all", NNSTREAMER_CONF=str(ini), WEIR_NNSTREAMER_ENABLE="yes"))
        self.assertIn(f"  {path} (extra_config_path): not a regular file\n", output)
        self.assertIn(f"reason: {ini}:2: extra_config_path does not name a regular file: {path}\n", output)

    def test_a_pipeline_logs_it_and_runs(self):
        pipeline = PIPELINE.format(model=self.model())
        for kind in ("folder", "binary", "long"):
            for variable in ("WEIR_CONFIG", "NNSTREAMER_CONF"):
                with self.subTest(kind=kind, variable=variable):
                    path, _ = self.file(kind, f"{kind}-{variable}.ini")
                    done = weir("run", pipeline, **{variable: str(path)}, WEIR_NNSTREAMER_ENABLE="yes", GST_DEBUG="2",
                                GST_DEBUG_NO_COLOR="1")
                    self.assertIn("3 frames", self.good(done))
                    code = {"folder": "WEIR-4001", "binary": "WEIR-1001", "long": "WEIR-1001"}[kind]
                    self.assertEqual(done.stderr.count(f"{code}: "), 1 if kind != "binary" else 3, done.stderr)
                    self.assertIn(str(path), done.stderr)

    def test_a_pipeline_with_a_missing_element_is_refused_by_name(self):
        path, _ = self.file("folder", "nns.ini")
        done = weir("run", f"videotestsrc num-buffers=3 ! tensor_converter ! tensor_filter framework=mine model={self.model()}"
                           " ! tensor_sink", NNSTREAMER_CONF=str(path), WEIR_NNSTREAMER_ENABLE="yes", GST_DEBUG="2",
                    GST_DEBUG_NO_COLOR="1")
        self.refused(done, 1, "WEIR-3001: no engine has this name", "framework=mine",
                     "WEIR-4001: NNSTREAMER_CONF does not name a regular file", str(path))


if __name__ == "__main__":
    tap_runner.main()
