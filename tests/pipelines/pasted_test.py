#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Runs every command of README.md and of the guides for new users as pasted, with an installed tree, and compares what they print.

The ```sh blocks of a page run in their order, in one folder that holds the reader's own files (photo.jpg and others). A ```text block
after them is what they print: numbers may differ a little, `...` stands for anything. Only /usr/share becomes the folder of the tree, and
the port 8001 a free one.
"""

import json
import os
import pathlib
import re
import shutil
import socket
import subprocess
import tempfile
import unittest

import tap_runner
from built_modules import has_engine
from documents_test import SHARED, documents, models_of_readers
from page_blocks import blocks, difference

SOURCE = pathlib.Path(os.environ["WEIR_SOURCE"])
BUILD = pathlib.Path(os.environ["WEIR_BUILD"])
DESTDIR = BUILD / "tests" / "pipelines" / "installed"
PREFIX = DESTDIR / os.environ["WEIR_PREFIX"].lstrip("/")
# The reader's files, as the pages name them.
FILES = {"photo.jpg": "media/image/bus.jpg", "faces.jpg": "media/face/three_people.jpg", "clip.mp4": "media/video/street_1080p25.mp4",
         "sound.wav": "media/audio/speech.wav"}
SECONDS = 120


def installed_environment(home):
    """Of a user who has Weir installed below PREFIX, and no setting of this build."""
    library = next(PREFIX.rglob("libweir.so")).parent
    path = f"{PREFIX / 'bin'}:{os.environ['PATH']}"
    return {"PATH": path, "HOME": str(home), "LD_LIBRARY_PATH": str(library), "GST_PLUGIN_PATH": str(library / "gstreamer-1.0"),
            "GST_REGISTRY": str(home / "registry.bin"), "GST_REGISTRY_FORK": "no", "G_DEBUG": "fatal-criticals", "WEIR_CONFIG": "",
            "WEIR_MODULE_PATH": str(library / "weir" / "modules"), "WEIR_CARD_PATH": str(PREFIX / "share/weir/cards"),
            "WEIR_WORKER": str(PREFIX / "libexec/weir/weir-worker"), "LC_ALL": "C.UTF-8"}


def broken_links(pages, root):
    """The relative links of pages that lead to no file, as `PAGE: LINK`."""
    broken = []
    for page in pages:
        text = re.sub(r"(?ms)^```.*?^```", "", page.read_text())
        broken += [f"{page.relative_to(root)}: {target}" for target in re.findall(r"\]\(([^)#\s]+)[^)]*\)", text)
                   if "://" not in target and not (page.parent / target).exists()]
    return broken


class Blocks(unittest.TestCase):
    def test_commands_and_what_they_print(self):
        page = ("```sh\na\n```\ntext\n```sh\nb \\\n  c\n```\n\n```text\nd\ne\n```\n```text\nf\n```\n```sh server\ng\n```\n\nIt prints\nthis:\n\n"
                "```text\nh\n```\n```sh\ni\n```\n\nNot this.\n\n```text\nj\n```\n")
        self.assertEqual(list(blocks(page)), [("a\n", None, False), ("b \\\n  c\n", "d\ne\n", False), ("g\n", "h\n", True),
                                              ("i\n", None, False)])

    def test_output_that_fits(self):
        for expected, printed in (("a 0.98\n", "a 0.9812\n"), ("box 22 to 799\n", "box 22.4 to 799.4\n"), ("a\n...\nd\n", "a\nb\nc\nd\n"),
                                  ("at 0x...: eb\n", "at 0x55d0: eb   \n"), ("...\nd\n", "d\n"), ("-1 %\n", "-1 %\n")):
            self.assertIsNone(difference(expected, printed), expected)

    def test_output_that_does_not_fit(self):
        for expected, printed in (("a 0.98\n", "a 0.9\n"), ("box 22\n", "box 25\n"), ("a\n...\nd\n", "a\nb\n"), ("a\n", "a\nb\n"),
                                  ("a\nb\n", "a\n"), ("label 0\n", "label x\n"), ("-1\n", "1\n"), ("", "a\n")):
            self.assertIsNotNone(difference(expected, printed), expected)


@unittest.skipUnless(SHARED.is_dir() and has_engine("onnxruntime"), "needs the test data and ONNX Runtime")
class Pasted(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        shutil.rmtree(DESTDIR, ignore_errors=True)
        done = subprocess.run([SOURCE / "tools/install", BUILD, os.environ["WEIR_PREFIX"]], capture_output=True, text=True,
                              env={**os.environ, "DESTDIR": str(DESTDIR)}, check=False)
        if done.returncode:
            raise AssertionError(done.stdout + done.stderr)

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        home = self.folder / "home"
        for name, copy in models_of_readers():
            if "/" in name and copy.exists():
                fetched = home / ".local/share/weir/models" / name
                fetched.parent.mkdir(parents=True, exist_ok=True)
                fetched.symlink_to(copy)
        for name, file in FILES.items():
            shutil.copy(SHARED / file, self.folder / name)
        self.environment = installed_environment(home)
        with socket.create_server(("127.0.0.1", 0)) as free:
            self.port = free.getsockname()[1]

    def run_page(self, page):
        count = 0
        for command, expected, goes_on in blocks((SOURCE / page).read_text()):
            count += 1
            with self.subTest(page=page, command=command):
                pasted = command.replace("/usr/share/", f"{PREFIX}/share/").replace(":8001", f":{self.port}")
                if command == "make install\n":
                    self.assert_make_installs()
                elif goes_on:
                    self.start_server(pasted.replace("weir serve", f"exec weir serve --listen 127.0.0.1:{self.port}"), expected)
                else:
                    self.run_command(pasted, expected and expected.replace("/usr/share/", f"{PREFIX}/share/"))
        self.assertGreater(count, 0, f"{page} has commands")

    def run_command(self, command, expected):
        done = subprocess.run(["bash", "-c", command], cwd=self.folder, env=self.environment, timeout=SECONDS, text=True,
                              capture_output=True, stdin=subprocess.DEVNULL, check=False)
        output = done.stdout + done.stderr
        fails = expected is not None and "WEIR-" in expected
        self.assertEqual(done.returncode != 0, fails, output)
        for word in ("CRITICAL", "WARNING", "ERROR"):
            self.assertNotIn(word, output)
        if expected is not None:
            self.assertIsNone(difference(expected, done.stderr if fails else done.stdout), output)

    def start_server(self, command, expected):
        server = subprocess.Popen(["bash", "-c", command], cwd=self.folder, env=self.environment, text=True, stdout=subprocess.PIPE,
                                  stdin=subprocess.DEVNULL)
        self.addCleanup(server.communicate, timeout=SECONDS)
        self.addCleanup(server.terminate)
        self.assertIsNone(difference(expected.replace(":8001", f":{self.port}"), server.stdout.readline()))

    def assert_make_installs(self):
        """It installs packages too, so it is not run: its last step is what made the tree."""
        steps = subprocess.run(["make", "--no-print-directory", "-n", "install"], cwd=SOURCE, capture_output=True, text=True, check=True).stdout
        self.assertIn("tools/install", steps.splitlines()[-1])

    def test_documents_are_installed_with_links_that_work(self):
        documents = PREFIX / "share/doc/weir"
        pages = list(documents.rglob("*.md"))
        self.assertGreater(len(pages), 100)
        # A link to the source code needs the source code.
        code = re.compile(r": (?:\.\./)*(?:tests|tools|apps|benchmarks|packages|include|src/.*[ch]pp$)")
        self.assertEqual([link for link in broken_links(pages, documents) if not code.search(link)], [])
        for page in ("docs/README.md", "docs/guide/first-pipeline.md", "docs/pictures/a-buffers-way.svg", "examples/model_once.c"):
            self.assertTrue((documents / page).is_file(), page)

    def test_each_element_has_a_man_page(self):
        names = sorted(page.stem for page in (SOURCE / "docs/elements").glob("*.md"))
        self.assertEqual(sorted(page.name for page in (PREFIX / "share/man/man7").iterdir()), [f"{name}.7" for name in names])
        page = (PREFIX / "share/man/man7/tensor_rate.7").read_text()
        for text in (".SH NAME\ntensor_rate \\- ", "\\fBframerate\\fR", "videotestsrc"):
            self.assertIn(text, page)

    @unittest.skipUnless(shutil.which("groff"), "needs groff")
    def test_man_pages_are_valid(self):
        for page in sorted((PREFIX / "share/man").rglob("*.[17]")):
            done = subprocess.run(["groff", "-man", "-Tutf8", "-ww", "-z", page], capture_output=True, text=True, check=False)
            self.assertEqual((done.returncode, done.stderr), (0, ""), page.name)

    def test_readme(self):
        self.run_page("README.md")
        self.assertTrue((self.folder / "found.jpg").read_bytes().startswith(b"\xff\xd8"))

    def test_first_pipeline(self):
        self.run_page("docs/guide/first-pipeline.md")
        self.assertTrue((self.folder / "drawn.jpg").read_bytes().startswith(b"\xff\xd8"))

    def frames(self, name):
        return [json.loads(line) for line in (self.folder / name).read_text().splitlines()]

    def test_detect_objects(self):
        self.run_page("docs/guide/detect-objects.md")
        found, counted = self.frames("found.jsonl"), self.frames("counted.jsonl")
        self.assertEqual(len(found), len(counted))
        labels = {row["label"] for frame in found for row in frame["detections"]}
        self.assertTrue(labels and labels <= {"person", "car"}, labels)
        self.assertEqual([zone["name"] for zone in counted[0]["zones"]], ["left half", "middle line"])
        self.assertTrue((self.folder / "drawn.avi").read_bytes().startswith(b"RIFF"))

    def test_classify_sound(self):
        self.run_page("docs/guide/classify-sound.md")
        sounds = self.frames("sounds.jsonl")
        self.assertEqual([round(frame["time"], 3) for frame in sounds[:3]], [0, 0.195, 0.39])
        self.assertEqual({frame["labels"][0]["label"] for frame in sounds}, {"Speech"})

    def test_use_a_sensor(self):
        self.run_page("docs/guide/use-a-sensor.md")

    def test_a_buffers_way(self):
        self.run_page("docs/guide/a-buffers-way.md")

    @unittest.skipUnless(has_engine("oip"), "needs gRPC")
    def test_offload(self):
        self.run_page("docs/guide/offload.md")

    def test_from_dlstreamer(self):
        self.run_page("docs/guide/from-dlstreamer.md")
        tracks = {row.get("track") for frame in self.frames("found.jsonl") for row in frame["detections"]}
        self.assertGreater(len(tracks), 1)

    def test_from_mediapipe(self):
        self.run_page("docs/guide/from-mediapipe.md")
        faces, = self.frames("faces.jsonl")
        self.assertEqual(len(faces["detections"]), 3)


class Links(unittest.TestCase):
    def test_every_link_of_a_document_leads_to_a_file(self):
        self.assertEqual(broken_links(documents(), SOURCE), [])

    def test_a_broken_link_is_found(self):
        with tempfile.TemporaryDirectory() as folder:
            page = pathlib.Path(folder) / "page.md"
            page.write_text("[a](page.md) [b](page.md#there) [c](https://a.example/) [d](gone.md#x)\n```c\n[](const x)\n```\n")
            self.assertEqual(broken_links([page], page.parent), ["page.md: gone.md"])


if __name__ == "__main__":
    tap_runner.main()
