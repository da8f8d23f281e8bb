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

import numpy

import onnx_writer
import tap_runner
from built_modules import has_engine
from documents_test import SHARED, documents, models_of_readers
from fix_lines import mended, run
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
                if made := re.match("make (install|deb)\n", command):
                    self.assert_make_ends_with(made[1])
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

    def assert_make_ends_with(self, tool):
        """It changes the machine, so it is not run. Its last step is what made the tree here; tools/checks-deb runs the other."""
        steps = subprocess.run(["make", "--no-print-directory", "-n", tool], cwd=SOURCE, capture_output=True, text=True, check=True).stdout
        self.assertIn(f"tools/{tool}", steps.splitlines()[-1])

    def test_documents_are_installed_with_links_that_work(self):
        documents = PREFIX / "share/doc/weir"
        pages = list(documents.rglob("*.md"))
        self.assertGreater(len(pages), 100)
        self.assertEqual(broken_links(pages, documents), [])
        for page in ("docs/README.md", "docs/guide/first-pipeline.md", "docs/pictures/a-buffers-way.svg", "examples/model_once.c"):
            self.assertTrue((documents / page).is_file(), page)

    def test_the_examples_find_their_files(self):
        examples, stub = PREFIX / "share/doc/weir/examples", self.folder / "bin" / "gst-launch-1.0"
        stub.parent.mkdir()
        stub.write_text("#!/bin/sh\nprintf '%s\\n' \"$@\"\n")
        stub.chmod(0o755)
        anything = self.folder / "anything"
        anything.write_text("x")
        street = subprocess.run([examples / "street/street", anything], capture_output=True, text=True, cwd=self.folder, check=False,
                                env={**self.environment, "PATH": f"{stub.parent}:{os.environ['PATH']}", "MODEL": str(anything)})
        self.assertEqual(street.returncode, 0, street.stderr)
        for name in ("card", "zones"):
            self.assertTrue(pathlib.Path(re.search(f"(?m)^{name}=(.*)", street.stdout)[1]).is_file(), street.stdout)
        offload = subprocess.run([examples / "offload/run", "--model", anything, "--rate", "0", anything], capture_output=True, text=True,
                                 env=self.environment, check=False)
        self.assertEqual(offload.stderr, "run: --rate 0 is below 1\n")

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


def pixels_of_picture(path, width, height):
    """The pixels of PICTURE, as an array height x width x 3."""
    subprocess.run(["gst-launch-1.0", "-q", *PICTURE.split(), "!", f"video/x-raw,format=RGB,width={width},height={height}", "!", "filesink",
                    f"location={path}"], check=True)
    return numpy.frombuffer(path.read_bytes(), numpy.uint8).reshape(height, -1)[:, :width * 3].reshape(height, width, 3)


PICTURE = "videotestsrc num-buffers=1 pattern=smpte75"


@unittest.skipUnless(has_engine("onnxruntime"), "needs ONNX Runtime")
class FixLines(unittest.TestCase):
    """The fix of each error is pasted into its pipeline until it runs, and the pipeline must then give the right values."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def model(self, name, *nodes, inputs, outputs, arrays=None, metadata=()):
        path = self.folder / f"{name}.onnx"
        path.write_bytes(onnx_writer.model(nodes, arrays or {}, inputs, outputs, metadata))
        return path

    def copying_model(self, *shape):
        """A model that returns its input."""
        return self.model("copy", ("Identity", ["x"], "y"), inputs=[("x", shape)], outputs=[("y", shape)])

    def values(self, line):
        """The numbers that a pipeline without a sink gives once its fixes are pasted."""
        mended(self, f"{line} ! filesink location={self.folder}/out")
        return numpy.frombuffer((self.folder / "out").read_bytes(), numpy.float32)

    def detector(self, side=320):
        """Has the outputs of YOLOv8: one object, whose score is the mean of the input's values."""
        cells = sum((side // stride) ** 2 for stride in (8, 16, 32))
        rows, mean = numpy.zeros((1, 84, cells), "float32"), numpy.zeros((1, 84, cells), "float32")
        rows[0, :4, 100] = side / 2, side / 2, side / 4, side / 2
        mean[0, 4, 100] = 1
        return self.model("detector", ("ReduceMean", ["images"], "kept"), ("Squeeze", ["kept"], "mean"), ("Mul", ["score", "mean"], "scores"),
                          ("Add", ["scores", "rows"], "output0"), arrays={"rows": rows, "score": mean},
                          inputs=[("images", (1, 3, side, side))], outputs=[("output0", (1, 84, cells))])

    def detections(self, line):
        mended(self, f"{line} ! filesink location={self.folder}/out")
        return json.loads((self.folder / "out").read_text().splitlines()[0])["detections"]

    def test_pictures_get_the_size_order_and_range_of_the_model(self):
        model = self.detector()
        gray = "videotestsrc num-buffers=1 pattern=solid-color foreground-color=0xff999999 ! video/x-raw,format=RGB,width=320,height=320"
        for preparation in ("tensor_preprocess width=416 height=416 type=float32 layout=NHWC", "tensor_converter",
                            "tensor_converter ! tensor_transform mode=typecast option=float32",
                            "tensor_converter ! tensor_transform mode=transpose option=1:2:0:3"):
            with self.subTest(preparation):
                found, = self.detections(f"{gray} ! {preparation} ! tensor_filter model={model} ! tensor_decoder mode=detection ! "
                                         "tensor_decoder mode=json")
                self.assertAlmostEqual(found["score"], 0x99 / 255, places=3)
                self.assertEqual([round(x) for x in found["box"]], [120, 80, 200, 240])

    def test_a_tensor_is_read_as_the_dimensions_of_the_model(self):
        pixels = pixels_of_picture(self.folder / "pixels", 28, 28)
        source = f"{PICTURE} ! video/x-raw,format=RGB,width=28,height=28 ! tensor_converter ! tensor_transform mode=typecast option=float32"
        got = self.values(f"{source} ! tensor_filter model={self.copying_model('N', 28 * 28 * 3)}")
        numpy.testing.assert_array_equal(got, pixels.astype("float32").ravel())

    def test_a_clip_gets_the_order_of_the_model(self):
        pixels = pixels_of_picture(self.folder / "pixels", 12, 10)
        source = f"{PICTURE.replace('=1', '=4')} ! video/x-raw,format=RGB,width=12,height=10,framerate=10/1 ! tensor_converter"
        model = self.copying_model(1, 3, 4, 10, 12)
        clip = numpy.stack([pixels] * 4).transpose(3, 0, 1, 2).astype("float32")
        for middle in ("tensor_aggregator frames-out=4 frames-dim=3", "tensor_transform mode=typecast option=float32", "identity"):
            with self.subTest(middle):
                got = self.values(f"{source} ! {middle} ! tensor_filter model={model}")
                numpy.testing.assert_allclose(got, clip.ravel(), rtol=1e-6)

    def test_a_sensor_gets_the_window_and_the_type_of_the_model(self):
        samples = numpy.arange(8 * 6, dtype="int16")
        (self.folder / "samples").write_bytes(samples.tobytes())
        source = f"filesrc location={self.folder}/samples blocksize=12 ! application/octet-stream,framerate=100/1"
        for shape, wanted in (((1, 8, 6), samples), ((1, 6, 8), samples.reshape(8, 6).T)):
            with self.subTest(shape):
                got = self.values(f"{source} ! tensor_converter input-dim=6:1 input-type=int16 ! tensor_filter model={self.copying_model(*shape)}")
                numpy.testing.assert_array_equal(got, wanted.astype("float32").ravel())

    def test_outputs_of_a_model_are_read_before_they_are_written(self):
        found, = self.detections("videotestsrc num-buffers=1 pattern=white ! video/x-raw,format=RGB,width=320,height=320 ! tensor_preprocess "
                                 f"layout=NCHW type=float32 scale=0.003 ! tensor_filter model={self.detector()} ! tensor_decoder mode=json")
        self.assertAlmostEqual(found["score"], 255 * 0.003, places=2)

    def test_real_numbers_become_pixels(self):
        pixels = pixels_of_picture(self.folder / "pixels", 12, 8)
        source = (f"{PICTURE} ! video/x-raw,format=RGB,width=12,height=8 ! tensor_converter ! "
                  "tensor_transform mode=arithmetic option=typecast:float32,div:255.0")
        for turn, shape in (("", (1, 8, 12, 3)), (" ! tensor_transform mode=transpose option=1:2:0:3", (1, 3, 8, 12))):
            with self.subTest(shape):
                mended(self, f"{source}{turn} ! tensor_filter model={self.copying_model(*shape)} ! tensor_decoder mode=direct_video ! "
                       f"filesink location={self.folder}/out")
                got = numpy.frombuffer((self.folder / "out").read_bytes(), numpy.uint8).reshape(8, 12, 3)
                numpy.testing.assert_allclose(got.astype(int), pixels, atol=1)

    def test_a_flexible_stream_becomes_video(self):
        pixels = pixels_of_picture(self.folder / "pixels", 12, 8)
        mended(self, f"{PICTURE} ! video/x-raw,format=RGB,width=12,height=8 ! tensor_converter ! other/tensors,format=flexible ! "
               f"tensor_decoder mode=direct_video ! filesink location={self.folder}/out")
        self.assertEqual((self.folder / "out").read_bytes(), pixels.tobytes())

    def test_a_forgotten_link_is_named(self):
        for line in (f"{PICTURE} ! video/x-raw,format=RGB,width=12,height=8 ! tensor_converter tensor_transform mode=typecast option=float32 ! "
                     f"filesink location={self.folder}/out",
                     f"{PICTURE} ! video/x-raw,format=RGB,width=12,height=8 ! tensor_converter ! tensor_transform mode=typecast option=float32 "
                     f"filesink location={self.folder}/out"):
            mended(self, line, limit=1)
            got = numpy.frombuffer((self.folder / "out").read_bytes(), numpy.float32)
            numpy.testing.assert_array_equal(got, pixels_of_picture(self.folder / "pixels", 12, 8).ravel())

    def test_two_dimensions_are_no_flags(self):
        (self.folder / "samples").write_bytes(bytes(range(24)))
        line = mended(self, f"filesrc location={self.folder}/samples blocksize=24 ! application/octet-stream,framerate=1/1 ! "
                      "tensor_converter input-dim=6:4 input-type=uint8 ! other/tensors,format=static,num_tensors=1,dimensions=6:4,types=uint8 ! "
                      f"filesink location={self.folder}/out", limit=1)
        self.assertIn("dimensions=(string)6:4", line)
        self.assertEqual((self.folder / "out").read_bytes(), bytes(range(24)))
        branch = "videotestsrc num-buffers=1 ! video/x-raw,format=GRAY8,width=8,height=4 ! tensor_converter ! "
        done = run(f"tensor_mux name=m ! other/tensors,format=static,num_tensors=2,dimensions=1:8:4.1:8:4,types=uint8.uint8 ! fakesink {branch}m. {branch}m.")
        self.assertEqual(done.returncode, 0, done.stderr)

    def test_a_loop_begins_with_a_frame_of_known_size(self):
        """The size of the sum is known with the data only: values that are not above `low` are left out."""
        model = self.model("sum", ("Add", ["x", "state"], "sum"), ("Greater", ["x", "low"], "kept"), ("Compress", ["sum", "kept"], "out"),
                           arrays={"low": numpy.array([-1], "float32")}, inputs=[("x", (1,)), ("state", (1,))], outputs=[("out", ("n",))])
        numpy.arange(1, 5, dtype="float32").tofile(self.folder / "in")
        mended(self, f"filesrc location={self.folder}/in blocksize=4 ! application/octet-stream,framerate=10/1 ! tensor_converter input-dim=1 "
               "input-type=float32 ! mux.sink_0 tensor_reposrc slot-index=7 "
               "caps=other/tensors,format=static,num_tensors=1,dimensions=(string)1,types=float32,framerate=10/1 ! mux.sink_1 "
               f"tensor_mux name=mux sync-mode=nosync ! tensor_filter model={model} ! tee name=t ! queue ! tensor_reposink slot-index=7 "
               f"t. ! queue ! tensor_converter ! filesink location={self.folder}/out")
        self.assertEqual(numpy.fromfile(self.folder / "out", "float32").tolist(), [1, 3, 6, 10])

    def test_an_input_of_a_model_can_be_a_constant(self):
        model = self.model("scaled", ("Mul", ["x", "k"], "y"), inputs=[("x", (1, 4)), ("k", (1, 4))], outputs=[("y", (1, 4))])
        x, k = numpy.arange(12, dtype="float32").reshape(3, 4), numpy.array([1, 2, 3, 4], "float32")
        x.tofile(self.folder / "x")
        k.tofile(self.folder / "k")
        converter = "blocksize=16 ! application/octet-stream,framerate=30/1 ! tensor_converter input-dim=4:1 input-type=float32 !"
        text = run(f"filesrc location={self.folder}/x {converter} tensor_filter model={model} ! fakesink").stderr
        self.assertIn("no tensor for k", text)
        self.assertIn("for a constant, a stream of one frame, and sync-mode=refresh", text)
        done = run(f"tensor_mux name=m sync-mode=refresh ! tensor_filter model={model} ! filesink location={self.folder}/y "
                   f"filesrc location={self.folder}/x {converter} m.sink_0 filesrc location={self.folder}/k {converter} m.sink_1")
        self.assertEqual(done.returncode, 0, done.stderr)
        numpy.testing.assert_array_equal(numpy.fromfile(self.folder / "y", "float32").reshape(3, 4), x * k)

    def test_a_stream_that_nothing_decodes_needs_a_converter_of_its_own(self):
        for media, name in (("application/x-event-stream,framerate=30/1", "event-stream"), ("application/vnd.imu+raw", "vnd-imu-raw"),
                            ("application/9axis", "axis"), ("application/x-" + 80 * "a", 64 * "a"), ("application/x-123", "my-converter"),
                            ("application/x--", "my-converter"), ("application/x-auto", "my-converter"), ("application/any", "my-converter")):
            text = run(f"filesrc location=/dev/zero ! {media} ! tensor_converter ! fakesink").stderr
            self.assertIn(f"needed: a module that converts {media.partition(',')[0]}, in a folder of WEIR_MODULE_PATH", text)
            fix = re.search("fix: (.*)", text)[1]
            self.assertEqual(fix, f"weir new converter {name}")
            self.assertNotIn("decodebin", text)
            made = subprocess.run([os.environ["WEIR_COMMAND"], *fix.split()[1:]], cwd=self.folder, capture_output=True, text=True, check=False)
            self.assertEqual(made.returncode, 0, made.stderr)
            shutil.rmtree(self.folder / name)

    def test_elements_of_other_projects_have_an_equivalent(self):
        for name, equivalent, fix in (("gvadetect model=a.onnx device=CPU", "tensor_filter", "weir try a.onnx photo.jpg"),
                                      ("onnxinference model-file=b.onnx", "tensor_preprocess", "weir try b.onnx photo.jpg"),
                                      ("nvinfer config-file-path=c.txt", "tensor_decoder mode=detection", None),
                                      ("gvadetect model=a.xml", "weir try", None),
                                      ("gvatrack tracking-type=zero-term", "tensor_tracker", "videotestsrc ! tensor_tracker ! fakesink"),
                                      ("nvtracker name=k tracker-width=8", "tensor_tracker", "videotestsrc ! tensor_tracker name=k ! fakesink"),
                                      ("rosimagesrc", "appsrc", None), ("tensor_ros_sink", "edgesink", None)):
            with self.subTest(name):
                if subprocess.run(["gst-inspect-1.0", "--exists", name.split()[0]], check=False).returncode == 0:
                    continue
                text = run(f"videotestsrc ! {name} ! fakesink").stderr
                self.assertIn(f"Weir has no element {name.split()[0]} of ", text)
                self.assertIn(equivalent, re.search("needed: (.*)", text)[1])
                self.assertEqual(re.findall("fix: (.*)", text), [fix] if fix else [])

    def test_the_guide_names_the_equivalents_that_the_errors_name(self):
        source = (SOURCE / "apps/weir/launch/pipeline_text.cpp").read_text()
        rows = re.findall(r"(?m)^\| (`gva\w+`) \| (.*) \|$", (SOURCE / "docs/guide/from-dlstreamer.md").read_text())
        table = {name.strip("`"): re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", cell).replace("`", "") for name, cell in rows}
        self.assertEqual(sorted(table), sorted(re.findall(r'Foreign\{"(\w+)", kDlStreamer', source)))
        for name, cell in table.items():
            needed = re.search("needed: (.*)", run(f"videotestsrc ! {name} ! fakesink").stderr)[1]
            self.assertTrue(cell.startswith(needed.partition("; weir try")[0]), (name, cell, needed))


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
