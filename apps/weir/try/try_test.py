#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""weir try: real models on real pictures where they are, and what it refuses."""

import json
import os
import pathlib
import re
import shutil
import subprocess
import unittest

import numpy
import onnx_writer
import tap_runner
from weir_case import HAS_ONNX, MODEL, SANITIZED, SOURCE, WITHOUT_LEAKS, Case, weir

SHARED = pathlib.Path(os.environ.get("WEIR_DATA") or SOURCE / "../shared")
CARDS = {"WEIR_CARD_PATH": str(SOURCE / "models" / "cards"), **WITHOUT_LEAKS}


def model(name):
    return SHARED / "models" / name


def picture(name):
    return SHARED / "media" / name


def write_map_model(folder, output, size=(96, 96), metadata=()):
    """A model whose output of the input's size is the mean of the colours."""
    path = folder / "map.onnx"
    path.write_bytes(onnx_writer.model([("Conv", ("image", "w"), output)], {"w": numpy.full((1, 3, 1, 1), 1 / 3, "f")},
                                       [("image", (1, 3, *size))], [(output, (1, 1, *size))], metadata))
    return path


def write_rows_model(folder, output, rows, columns, metadata=()):
    """A model of pictures of 640 x 640 whose output has `rows` rows of `columns` numbers."""
    path = folder / "rows.onnx"
    nodes = [("ReduceMean", ("image",), "mean"), ("Add", ("mean", "a"), "column"), ("Add", ("column", "b"), output)]
    arrays = {"a": numpy.zeros((rows, 1), "f"), "b": numpy.zeros((1, columns), "f")}
    path.write_bytes(onnx_writer.model(nodes, arrays, [("image", (1, 3, 640, 640))], [(output, (1, 1, rows, columns))], metadata))
    return path


def overlap(a, b):
    width, height = min(a[2], b[2]) - max(a[0], b[0]), min(a[3], b[3]) - max(a[1], b[1])
    if width <= 0 or height <= 0:
        return 0
    area = lambda box: (box[2] - box[0]) * (box[3] - box[1])  # noqa: E731
    return width * height / (area(a) + area(b) - width * height)


class Refused(Case):
    def test_a_model_that_does_not_exist(self):
        self.refused(weir("try", self.folder / "no.onnx", "test", **CARDS), 1, "WEIR-3003")

    def test_a_model_that_does_not_exist_comes_with_the_command_for_the_one_that_was_meant(self):
        near = self.folder / "my model.onnx"
        shutil.copy(MODEL, near)
        environment = {"WEIR_MODELS": str(self.folder / "models"), **CARDS}
        for given, fix in ((self.folder / "my modl.onnx", f"weir try '{near}' 'a photo.jpg'"),
                           (self.folder / "of-nobody.onnx", None), (self.folder / "ultraface.onnx", "weir models get ultraface"),
                           ("/nonexistent/yolox-nano.onnx", "weir models get yolox-nano"),
                           ("/nonexistent/yolox_nano.onnx", "weir models get yolox-nano")):
            done = weir("try", given, "a photo.jpg", **environment)
            self.refused(done, 1, f"WEIR-3003: the model file does not exist\n  offered: {given}\n")
            fixes = re.findall("(?m)^  fix: (.*)$", done.stderr)
            self.assertEqual(fixes, [fix] if fix else [], done.stderr)
            self.assertNotIn("/path/to", done.stderr)

    def test_a_model_that_was_not_fetched_names_the_command(self):
        self.refused(weir("try", "yolox-nano", "test", WEIR_MODELS=str(self.folder), **CARDS), 1, "WEIR-3003",
                     "weir models get yolox-nano")

    def test_a_name_that_is_nearly_one_of_the_catalogue(self):
        self.refused(weir("try", "yolox-nan", "test", WEIR_MODELS=str(self.folder), **CARDS), 1, "did you mean yolox-nano?")

    def test_the_address_of_a_server_needs_the_option_for_its_engine(self):
        refused = weir("try", "grpc://127.0.0.1:8001/boxes", "photo.jpg", **CARDS)
        self.refused(refused, 1, "WEIR-3001: no engine can be selected for this model", "fix: --engine oip")
        self.assertNotIn("framework=", refused.stderr)

    @unittest.skipUnless(HAS_ONNX, "the engine onnxruntime is not built")
    def test_inputs_that_do_not_exist(self):
        for name, words in ((self.folder, "the input is a folder"), (self.folder / "no.jpg", "the input does not exist"),
                            ("/dev/video99", "the input does not exist")):
            self.refused(weir("try", "--mode", "text", MODEL, name, **CARDS), 1, "WEIR-4001", words, f"weir try {MODEL} photo.jpg")

    @unittest.skipUnless(HAS_ONNX, "the engine onnxruntime is not built")
    def test_addresses_without_host_or_port(self):
        for address in ("tcp://", "tcp://localhost", "tcp://:5000", "tcp://localhost:port"):
            self.refused(weir("try", "--mode", "text", MODEL, address, **CARDS), 1, "WEIR-1004", "the address has no host or no port",
                         f"offered: {address}", "needed: tcp://HOST:PORT")

    @unittest.skipUnless(HAS_ONNX, "the engine onnxruntime is not built")
    def test_a_network_camera_does_not_wait_for_a_slow_model(self):
        newest = "videoconvert ! queue leaky=downstream max-size-buffers=1 ! "
        for address, is_live in (("rtsp://127.0.0.1:1/camera", True), ("http://127.0.0.1:1/clip.webm", False)):
            for options in ((), ("-o", self.folder / "out.webm")):
                done = weir("try", "--mode", "text", MODEL, address, *options, **CARDS)
                self.assertEqual((done.returncode, newest in done.stderr), (1, is_live), done.stderr)

    @unittest.skipUnless(HAS_ONNX, "the engine onnxruntime is not built")
    def test_text_without_a_dictionary(self):
        path = write_rows_model(self.folder, "softmax", 40, 6625)
        self.refused(weir("try", path, "test", **CARDS), 1, "WEIR-4002",
                     "text recognition needs the model's dictionary", "fix: --labels /path/to/dictionary.txt")

    @unittest.skipUnless(HAS_ONNX, "the engine onnxruntime is not built")
    def test_an_output_of_an_unknown_kind(self):
        self.refused(weir("try", "--mode", "text", MODEL, "test", "-o", self.folder / "x.doc", **CARDS), 1, "WEIR-1004", ".webm")

    @unittest.skipUnless(HAS_ONNX, "the engine onnxruntime is not built")
    def test_a_window_without_a_display(self):
        without = {"DISPLAY": "", "WAYLAND_DISPLAY": "", "GST_PLUGIN_FEATURE_RANK": "fbdevsink:NONE,kmssink:NONE", **CARDS}
        self.refused(weir("try", write_map_model(self.folder, "depth"), "test", "--show", **without), 1,
                     "WEIR-1004: no window can be opened", "DISPLAY or WAYLAND_DISPLAY names its display",
                     "fix: --output found.jpg instead of --show, or ssh -X for a remote machine")

    @unittest.skipUnless(HAS_ONNX, "the engine onnxruntime is not built")
    def test_a_mode_that_cannot_read_the_outputs(self):
        self.refused(weir("try", "--mode", "pose", MODEL, "test", **CARDS), 1, "WEIR-2001", "no head of this mode",
                     "needed: the outputs of a head of docs/heads.md: ", " and 2 others")
        path = write_rows_model(self.folder, "rows", 84, 8400)
        refused = weir("try", "--mode", "classification", "--engine", "onnxruntime", path, "test", **CARDS)
        self.refused(refused, 1, "no head of this mode", "(docs/heads.md)", f"fix: weir try {path} test --engine onnxruntime\n")
        self.assertIn("read as detection by the head yolov8", weir(*re.search("fix: weir (.*)", refused.stderr)[1].split(), **CARDS).stderr)
        path = write_map_model(self.folder, "mask")
        refused = weir("try", "--mode", "pose", path, "test", **CARDS)
        self.refused(refused, 1, "WEIR-2001", "no head of this mode")
        self.assertNotIn("fix: weir try", refused.stderr, "the map can be read in several modes")

    @unittest.skipUnless(HAS_ONNX, "the engine onnxruntime is not built")
    def test_a_card_of_another_file(self):
        path = self.folder / "net.onnx"
        path.write_bytes(pathlib.Path(MODEL).read_bytes())
        card = json.loads(pathlib.Path(MODEL).with_suffix(".card.json").read_text()) | {"sha256": "0" * 64}
        (self.folder / "net.card.json").write_text(json.dumps(card))
        self.refused(weir("try", path, "test", **CARDS), 1, "WEIR-3009: the card next to the model belongs to a different file")

    @unittest.skipUnless(HAS_ONNX, "the engine onnxruntime is not built")
    def test_a_mode_or_a_head_that_does_not_exist(self):
        self.refused(weir("try", "--mode", "detect", MODEL, "test", **CARDS), 1, "WEIR-1004", "there is no such mode",
                     "offered: --mode detect", "one of: text, detection")
        self.refused(weir("try", "--head", "yolo99", MODEL, "test", **CARDS), 1, "WEIR-1004", "this mode has no such head", "offered: --head yolo99")
        self.refused(weir("try", "--head", "yolov8x", MODEL, "test", **CARDS), 1, "WEIR-1004", "did you mean yolov8?", "fix: --head yolov8")

    @unittest.skipUnless(HAS_ONNX, "the engine onnxruntime is not built")
    def test_a_warning_of_the_pipeline_names_the_option_of_the_command(self):
        path = self.folder / "faces.onnx"
        scores, boxes = numpy.zeros((1, 4420, 2), "f"), numpy.tile(numpy.array([0.9, -0.5, -1.75, 2.25], "f"), (1, 4420, 1))
        scores[0, 100, 1] = 0.9
        nodes = [("ReduceMean", ("image",), "mean"), ("Mul", ("mean", "zero"), "nothing"), ("Add", ("nothing", "s"), "scores"), ("Add", ("nothing", "b"), "boxes")]
        path.write_bytes(onnx_writer.model(nodes, {"zero": numpy.zeros(1, "f"), "s": scores, "b": boxes}, [("image", (1, 3, 240, 320))],
                                           [("scores", (1, *scores.shape)), ("boxes", (1, *boxes.shape))]))
        warned = weir("try", "--head", "ultraface", path, "test", **CARDS).stderr
        self.assertIn("offsets from prior boxes", warned)
        self.assertRegex(warned, r"fix: --head ultraface-raw\b")
        self.assertNotIn("custom=head:ultraface-raw", warned)

    @unittest.skipUnless(HAS_ONNX, "the engine onnxruntime is not built")
    def test_outputs_that_can_be_read_in_several_ways(self):
        """A map of the input's size is a mask, a depth or the probability of text; 85 rows are classes with or without objectness."""
        refused = weir("try", write_map_model(self.folder, "mask"), "test", **CARDS)
        self.refused(refused, 1, "WEIR-2001", "can be read as text (db) or as segmentation (deeplab) or as depth (depth)",
                     "fix: --mode text or --mode segmentation or --mode depth")
        path = write_rows_model(self.folder, "rows", 85, 8400)
        self.refused(weir("try", path, "test", **CARDS), 1, "WEIR-2001", "as detection (yolov8) or as detection (yolox)",
                     "fix: --head yolov8 or --head yolox")

    @unittest.skipUnless(HAS_ONNX, "the engine onnxruntime is not built")
    def test_outputs_of_another_size_than_the_task_of_the_metadata_has(self):
        """3549 cells are those of 416 x 416. Without the metadata they are scores of a text or depths."""
        self.refused(weir("try", write_rows_model(self.folder, "out", 84, 3549), "test", **CARDS), 1, "as text (ctc) or as depth (depth)")
        path = write_rows_model(self.folder, "out", 84, 3549, [("task", "detect")])
        for options, what in (((), "no known head fits these outputs"), (("--mode", "detection"), "no head of this mode fits these outputs")):
            refused = weir("try", *options, path, "test", **CARDS)
            self.refused(refused, 1, "WEIR-2001: " + what, "float32 3549:84:1:1 'out' of an input of 640 x 640", "--head yolov8")
            self.assertLess(len(refused.stderr), 1000, refused.stderr)
        self.assertIn("read as detection by the head yolov8", weir("try", "--head", "yolov8", path, "test", **CARDS).stderr)

    def test_words_that_are_missing(self):
        self.refused(weir("try"), 2)
        self.refused(weir("try", MODEL), 2)


@unittest.skipUnless(HAS_ONNX and not SANITIZED, "needs the engine onnxruntime")
class Depth(Case):
    def test_a_model_whose_output_is_named_depth(self):
        done = weir("try", "--json", write_map_model(self.folder, "predicted_depth"), "test", **CARDS)
        frames = [json.loads(line) for line in self.good(done).splitlines()]
        self.assertIn("read as depth by the head depth", done.stderr)
        self.assertEqual(len(frames), 100)
        depth = frames[0]["depth"][0]
        # The colours of the test picture are 0 to 1, less the mean of ImageNet, by its deviation: the mean of R, G and B.
        white = sum((1 - m) / s for m, s in zip((0.485, 0.456, 0.406), (0.229, 0.224, 0.225))) / 3
        black = sum(-m / s for m, s in zip((0.485, 0.456, 0.406), (0.229, 0.224, 0.225))) / 3
        self.assertLess(abs(depth["greatest"] - white), 0.5)
        self.assertLess(abs(depth["least"] - black), 0.5)
        self.assertTrue(depth["least"] < depth["mean"] < depth["greatest"])

    def test_the_depths_are_drawn(self):
        """Black and white halves become the ends of the scale."""
        from PIL import Image
        picture, output = self.folder / "halves.png", self.folder / "depth.png"
        halves = Image.new("RGB", (64, 64))
        halves.paste("white", (32, 0, 64, 64))
        halves.save(picture)
        done = weir("try", write_map_model(self.folder, "depth"), picture, "--output", output, **CARDS)
        self.assertRegex(self.good(done), r"(?m)^  depth -\S+ to \S+, mean \S+$")
        drawn = Image.open(output).convert("RGB")
        self.assertEqual(drawn.size, (64, 64))
        for place, color in (((8, 32), (68, 1, 84)), ((56, 32), (253, 231, 37))):
            self.assertLess(max(abs(a - b) for a, b in zip(drawn.getpixel(place), color)), 8, place)

    def test_a_picture_of_a_video_is_its_first_frame(self):
        from PIL import Image
        for name, start in (("first.png", b"\x89PNG"), ("first.jpg", b"\xff\xd8\xff")):
            output = self.folder / name
            self.good(weir("try", write_map_model(self.folder, "depth"), "test", "--output", output, **CARDS))
            self.assertEqual(output.read_bytes().count(start), 1, (name, len(output.read_bytes())))
            self.assertEqual(Image.open(output).size, (320, 240))

    def read_upright(self, source):
        """The size of the source picture; whether its quarters are drawn from dark to light, as write_quarters() has them."""
        from PIL import Image
        drawn = self.folder / "drawn.png"
        done = weir("try", "--mode", "depth", write_map_model(self.folder, "depth"), source, "--output", drawn, **CARDS)
        self.assertRegex(self.good(done), r"(?m)^  depth ")
        picture = Image.open(drawn).convert("L")
        width, height = picture.size
        shades = [picture.getpixel((x * width // 4, y * height // 4)) for y in (1, 3) for x in (1, 3)]
        return picture.size, shades == sorted(shades) and shades[0] + 60 < shades[3], done.stderr

    def write_quarters(self, path, transposed=None, **options):
        from PIL import Image
        picture = Image.new("RGB", (64, 96))
        for i, grey in enumerate((0, 90, 170, 255)):
            x, y = 32 * (i % 2), 48 * (i // 2)
            picture.paste((grey, grey, grey), (x, y, x + 32, y + 48))
        (picture if transposed is None else picture.transpose(transposed)).save(path, **options)

    def test_photos_are_turned_as_their_exif_orientation_says(self):
        """Pillow's rotations are counter-clockwise: 6 says that the photo must be turned clockwise."""
        from PIL import Image
        turns, photo = Image.Transpose, self.folder / "photo.jpg"
        stored = (None, turns.FLIP_LEFT_RIGHT, turns.ROTATE_180, turns.FLIP_TOP_BOTTOM, turns.TRANSPOSE, turns.ROTATE_90, turns.TRANSVERSE,
                  turns.ROTATE_270)
        for orientation, transposed in enumerate(stored, 1):
            exif = Image.Exif()
            exif[0x0112] = orientation
            self.write_quarters(photo, transposed, quality=95, exif=exif)
            size, is_upright, printed = self.read_upright(photo)
            self.assertEqual((size, is_upright), ((64, 96), True), (orientation, printed))
            self.assertEqual("videoflip" in printed, orientation > 1, printed)

    def test_photos_of_other_names_and_addresses_are_turned_too(self):
        """Also one with a second FF before a marker, which JPEG allows."""
        from PIL import Image
        exif = Image.Exif()
        exif[0x0112] = 6
        photo = self.folder / "a photo.jpg"
        self.write_quarters(photo, Image.Transpose.ROTATE_90, quality=95, exif=exif)
        filled, other = photo.with_name("filled.jpg"), photo.with_name("photo.jfif")
        whole = photo.read_bytes()
        for at in (2, whole.index(b"Exif") - 4):
            filled.write_bytes(whole[:at] + b"\xff\xff" + whole[at:])
            size, is_upright, printed = self.read_upright(filled)
            self.assertEqual((size, is_upright), ((64, 96), True), printed)
        other.write_bytes(whole)
        for source in (other, photo.as_uri(), other.as_uri()):
            size, is_upright, printed = self.read_upright(source)
            self.assertEqual((size, is_upright), ((64, 96), True), printed)
            self.assertIn("videoflip video-direction=90r", printed)

    def test_photos_of_other_formats_are_turned_too(self):
        """In PNG the Exif data may stand before or after the pixels, in WebP it stands after them."""
        from PIL import Image, features
        exif = Image.Exif()
        exif[0x0112] = 6
        photo, late = self.folder / "photo.png", self.folder / "late.png"
        self.write_quarters(photo, Image.Transpose.ROTATE_90, exif=exif)
        whole = photo.read_bytes()
        at = whole.index(b"eXIf") - 4
        end = at + 12 + int.from_bytes(whole[at:at + 4], "big")
        last = whole.index(b"IEND") - 4
        late.write_bytes(whole[:at] + whole[end:last] + whole[at:end] + whole[last:])
        photos = [photo, late, photo.as_uri()]
        for source in photos:
            size, is_upright, printed = self.read_upright(source)
            self.assertEqual((size, is_upright), ((64, 96), True), (source, printed))
            self.assertIn("videoflip video-direction=90r", printed)
        # WebP may have no decoder here: the pipeline is printed before the photo is read.
        if features.check("webp"):
            webp = self.folder / "photo.webp"
            self.write_quarters(webp, Image.Transpose.ROTATE_90, exif=exif)
            done = weir("try", "--mode", "depth", write_map_model(self.folder, "depth"), webp, "--output", self.folder / "drawn.png", **CARDS)
            self.assertIn("videoflip video-direction=90r", done.stderr)

    def test_a_damaged_photo_is_not_turned(self):
        from PIL import Image
        exif = Image.Exif()
        exif[0x0112] = 6
        photo = self.folder / "photo.png"
        self.write_quarters(photo, exif=exif)
        whole = photo.read_bytes()
        at = whole.index(b"eXIf") - 4
        photo.write_bytes(whole[:at] + (0xFFFFFFF0).to_bytes(4, "big") + whole[at + 4:])
        done = weir("try", "--mode", "depth", write_map_model(self.folder, "depth"), photo, **CARDS)
        self.assertNotIn("videoflip", done.stderr)

    def test_videos_are_turned_as_their_header_says(self):
        photo, clip = self.folder / "stored.png", self.folder / "clip.mp4"
        from PIL import Image
        self.write_quarters(photo, Image.Transpose.ROTATE_90)
        self.good(weir("run", f"filesrc location={photo} ! pngdec ! imagefreeze num-buffers=3 ! videoconvert ! jpegenc ! qtmux ! "
                       f"filesink location={clip}"))
        # The matrix of the track, 9 numbers of 4 bytes: as it is stored, and turned clockwise.
        upright = numpy.array([1 << 16, 0, 0, 0, 1 << 16, 0, 0, 0, 1 << 30], ">i4").tobytes()
        turned = numpy.array([0, 1 << 16, 0, -1 << 16, 0, 0, 64 << 16, 0, 1 << 30], ">i4").tobytes()
        before, track, after = clip.read_bytes().partition(b"tkhd")
        clip.write_bytes(before + track + after.replace(upright, turned, 1))
        size, is_upright, printed = self.read_upright(clip)
        self.assertEqual((size, is_upright), ((64, 96), True), printed)

    def test_an_open_size_is_that_of_the_metadata(self):
        for imgsz, width, height in (("[48, 64]", 64, 48), ("96", 96, 96), ("[0, 64]", 640, 640), ("[48, 64, 3]", 640, 640), (None, 640, 640)):
            model = write_map_model(self.folder, "depth", ("h", "w"), [("imgsz", imgsz)] if imgsz else [])
            done = weir("try", "--mode", "depth", model, "test", "--output", self.folder / "one.png", **CARDS)
            self.assertIn("depth", self.good(done))
            self.assertIn(f"tensor_preprocess width={width} height={height} ", done.stderr)

    def test_paths_are_read_as_they_are(self):
        """With blanks and both quotes; the printed line finds the same files in a shell."""
        from PIL import Image
        folder = self.folder / "it's \"a\" folder"
        folder.mkdir()
        picture, output = folder / "a photo.png", folder / "its depth.png"
        Image.new("RGB", (64, 64), "white").save(picture)
        done = weir("try", write_map_model(folder, "depth"), picture, "--output", output, **CARDS)
        self.assertRegex(self.good(done), r"(?m)^  depth -?\d")
        self.assertEqual(Image.open(output).size, (64, 64))
        output.unlink()
        line = next(line for line in done.stderr.splitlines() if line.startswith("gst-launch-1.0 "))
        pasted = subprocess.run(["sh", "-c", line], capture_output=True, text=True, timeout=60, env={**os.environ, **CARDS})
        self.assertEqual(pasted.returncode, 0, pasted.stderr)
        self.assertTrue(output.exists())


@unittest.skipUnless(HAS_ONNX and SHARED.is_dir() and not SANITIZED, "needs the engines and the models and media of ../shared")
class Real(Case):
    def tried(self, name, image, *options):
        done = weir("try", *options, "--json", model(name), picture(image), **CARDS)
        frames = [json.loads(line) for line in self.good(done).splitlines()]
        self.assertEqual(len(frames), 1)
        self.assertRegex(done.stderr, "gst-launch-1.0 filesrc .* tensor_preprocess .* tensor_decoder .*mode=json")
        return frames[0]

    def labels(self, frame, least=0.4):
        return sorted(d["label"] for d in frame["detections"] if d["score"] >= least)

    def test_a_detector_with_a_card(self):
        frame = self.tried("detection/yolox_nano.onnx", "image/bus.jpg")
        self.assertEqual(frame["version"], 1)
        self.assertEqual(frame["size"], [810, 1080])
        found = self.labels(frame)
        self.assertIn("bus", found)
        self.assertGreaterEqual(found.count("person"), 3)

    def test_published_boxes_of_ssd(self):
        frame = self.tried("detection/coco_ssd_mobilenet_v1_1.0_quant.tflite", "image/cats_and_dogs.jpg")
        for label, (x, y, w, h) in (("cat", (54, 396, 393, 196)), ("cat", (602, 157, 394, 447)), ("dog", (389, 197, 278, 409))):
            box = (x, y, x + w, y + h)
            self.assertTrue(any(d["label"] == label and overlap(d["box"], box) > 0.85 for d in frame["detections"]), (label, box))

    def test_faces_with_key_points(self):
        frame = self.tried("face/yunet_n_dynamic.onnx", "face/three_people.jpg")
        sure = [d for d in frame["detections"] if d["score"] > 0.8]
        self.assertGreaterEqual(len(sure), 3)
        for face in sure:
            self.assertEqual(len(face["keypoints"]), 5)

    def test_a_classifier_with_a_card(self):
        frame = self.tried("classification/mobilenet_v1_0.25_224_quant.tflite", "image/burger.jpg")
        self.assertEqual(frame["labels"][0]["label"], "cheeseburger")
        self.assertAlmostEqual(frame["labels"][0]["score"], 0.96, delta=0.03)
        self.assertNotIn("detections", frame)

    def test_a_class_map_has_its_classes(self):
        frame = self.tried("segmentation/deeplabv3_257_mv_gpu.tflite", "image/segmentation_input.jpg")
        self.assertEqual([segment["label"] for segment in frame["segments"]], ["background", "horse", "person"])
        self.assertAlmostEqual(sum(segment["part"] for segment in frame["segments"]), 1, delta=0.01)
        done = weir("try", model("segmentation/deeplabv3_257_mv_gpu.tflite"), picture("image/segmentation_input.jpg"), **CARDS)
        self.assertRegex(self.good(done), r"(?m)^  horse \d+ % of the picture$")

    def test_a_photo_with_the_results_drawn(self):
        output = self.folder / "found.jpg"
        done = weir("try", model("detection/FastestDet.onnx"), picture("image/bus.jpg"), "--output", output, **CARDS)
        self.assertRegex(self.good(done), r"(?m)^  person \d+ %")
        self.assertGreater(output.stat().st_size, 50000)

    def test_the_printed_pipeline_can_be_pasted(self):
        done = weir("try", model("detection/yolox_nano.onnx"), picture("image/bus.jpg"), **CARDS)
        line = re.search("^gst-launch-1.0 .*$", done.stderr, re.M).group()
        self.runs(line.replace("fdsink fd=1", f"filesink location={self.folder}/pasted.jsonl"), **CARDS)
        pasted = json.loads((self.folder / "pasted.jsonl").read_text())
        self.assertIn("bus", self.labels(pasted))
        self.assertNotIn(" labels=", line, "tensor_decoder finds them in the card")

    def test_a_copy_with_another_name_has_the_labels_of_its_card(self):
        """tensor_decoder finds them by the digest too."""
        copy = self.folder / "other.onnx"
        shutil.copy(model("detection/yolox_nano.onnx"), copy)
        done = weir("try", copy, picture("image/bus.jpg"), **CARDS, XDG_CACHE_HOME=str(self.folder))
        self.assertRegex(self.good(done), r"(?m)^  bus \d+ %")
        self.assertNotIn("labels=", done.stderr)

    @unittest.skipUnless("tensorflow-lite" in os.environ["WEIR_MODULE_PATH"], "the engine tensorflow-lite is not built")
    def test_a_model_of_sound_gets_a_pipeline_for_sound(self):
        done = weir("try", SHARED / "models/audio/yamnet.tflite", SHARED / "media/audio/speech.wav", **CARDS)
        self.refused(done, 1, "WEIR-2001: weir try runs models that take a picture", "float32 15600")
        line = re.search("fix: (.*)", done.stderr)[1]
        played = subprocess.run(line, shell=True, capture_output=True, text=True, timeout=120, env={**os.environ, **CARDS}, check=True)
        labels = [json.loads(text)["labels"][0]["label"] for text in played.stdout.splitlines()]
        self.assertEqual(set(labels), {"Speech"})

    @unittest.skipUnless("tensorflow-lite" in os.environ["WEIR_MODULE_PATH"], "the engine tensorflow-lite is not built")
    def test_a_model_of_other_data_is_sent_to_its_description(self):
        model = SHARED / "models/sensor/keypoint_classifier.tflite"
        self.refused(weir("try", model, "test", **CARDS), 1, "weir try runs models that take a picture", f"fix: weir inspect {model}\n")

    def test_a_model_without_a_card_is_read_by_its_outputs(self):
        done = weir("try", "--json", model("detection/yolox_nano.onnx"), picture("image/bus.jpg"), WEIR_CARD_PATH=str(self.folder))
        frame = json.loads(self.good(done))
        self.assertIn("read as detection by the head yolox", done.stderr)
        self.assertIn("assumed: pixels as 0 to 255, BGR, letterboxed", done.stderr)
        self.assertIn("the classes have no names; set them with --labels FILE", done.stderr)
        self.assertGreaterEqual(len([d for d in frame["detections"] if d["score"] > 0.4]), 4)

    def test_models_without_cards_are_read_by_their_outputs(self):
        """What MANIFEST.md says of these pictures, with nothing but the files of the models; "class 5" has no name."""
        for name, image, words in (("detection/FastestDet.onnx", "image/bus.jpg", r"(?s)class 0 \d+ %.*class 5 "),
                                   ("classification/mobilenet_v2_quant.onnx", "image/orange.png", "class 950 49 %"),
                                   ("classification/vww_96_int8.tflite", "image/bus.jpg", "class 1 9"),
                                   ("face/yunet_n_dynamic.onnx", "face/three_people.jpg", r"(class 0 9\d %.*\s+){3}"),
                                   ("segmentation/deeplabv3_257_mv_gpu.tflite", "image/segmentation_input.jpg", r"class 13 29 % of the picture")):
            if name.endswith(".tflite") and "tensorflow-lite" not in os.environ["WEIR_MODULE_PATH"]:
                continue
            with self.subTest(name):
                done = weir("try", model(name), picture(image), WEIR_CARD_PATH=str(self.folder))
                self.assertRegex(self.good(done), words)

    def test_labels_of_the_user_count(self):
        labels = self.folder / "labels.txt"
        labels.write_text("".join(f"thing {i}\n" for i in range(80)))
        frame = self.tried("detection/yolox_nano.onnx", "image/bus.jpg", "--labels", labels)
        self.assertIn("thing 5", self.labels(frame))


if __name__ == "__main__":
    tap_runner.main()
