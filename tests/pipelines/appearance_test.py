#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""The line of tensor_tracker's README with a second network: heads that change sides out of sight, frames without heads."""

import json
import os
import pathlib
import re
import shlex
import subprocess
import tempfile
import unittest

import numpy

import tap_runner
from built_modules import has_engine

SOURCE = pathlib.Path(os.environ["WEIR_SOURCE"])
SHARED = pathlib.Path(os.environ.get("WEIR_DATA") or SOURCE / "../shared")
PHOTO = SHARED / "media/face/obama_and_biden.jpg"
MODELS = {"ultraface/": SHARED / "models/face", "mobilenet-v2-onnx/": SHARED / "models/classification"}
WIDTH, HEIGHT, RATE, FRAMES = 640, 360, 25, 80
HEADS = ((715, 340, 975, 690, 104, 140), (1105, 270, 1365, 650, 104, 152))  # left, top, right, bottom in the photo; width, height in the clip
ENVIRONMENT = {**os.environ, "GST_TRACERS": "", "GST_DEBUG": ""}


def gst(line):
    return subprocess.run(["gst-launch-1.0", "-q", *shlex.split(line)], capture_output=True, env=ENVIRONMENT, timeout=120, check=True).stdout


def photo_size():
    """Of a JPEG file: the height and the width of its frame header."""
    data, at = PHOTO.read_bytes(), 2
    while not 0xC0 <= data[at + 1] <= 0xC2:
        at += 2 + int.from_bytes(data[at + 2:at + 4], "big")
    return int.from_bytes(data[at + 7:at + 9], "big"), int.from_bytes(data[at + 5:at + 7], "big")


def head(left, top, right, bottom, width, height):
    """A head of the photo, and the ellipse in which it is opaque."""
    photo_width, photo_height = photo_size()
    pixels = gst(f"filesrc location={PHOTO} ! jpegdec ! videoconvert ! videocrop left={left} top={top} right={photo_width - right} "
                 f"bottom={photo_height - bottom} ! videoscale ! video/x-raw,format=RGBx,width={width},height={height},pixel-aspect-ratio=1/1 ! "
                 "filesink location=/dev/stdout")
    rows, columns = numpy.mgrid[0:height, 0:width] + 0.5
    mask = (2 * columns / width - 1) ** 2 + (2 * rows / height - 1) ** 2 < 1
    return numpy.frombuffer(pixels, numpy.uint8).reshape(height, width, 4)[..., :3], mask


def offset(number):
    """Pixels from the middle of the picture to both heads; None while they are out of sight.

    They walk towards each other, are not seen between 0.9 s and 2.2 s, have changed sides by then, and walk on slowly.
    """
    time = number / RATE
    if time <= 0.9:
        return 110 * (1 - time)
    return None if time < 2.2 else -20 - 40 * (time - 2)


def draw(path, offsets):
    heads = [head(*one) for one in HEADS]
    noise = numpy.random.default_rng(1).integers(84, 97, (HEIGHT, WIDTH, 1))
    background = numpy.repeat(noise, 3, axis=2).astype(numpy.uint8)
    with open(path.with_suffix(".rgb"), "wb") as file:
        for place in offsets:
            frame = background.copy()
            for (pixels, mask), side in reversed(list(zip(heads, (-1, 1)))) if place is not None else ():
                left, top = round(WIDTH / 2 + side * place - mask.shape[1] / 2), 178 - mask.shape[0] // 2
                frame[top:top + mask.shape[0], left:left + mask.shape[1]][mask] = pixels[mask]
            file.write(frame.tobytes())
    gst(f"filesrc location={path.with_suffix('.rgb')} blocksize={WIDTH * HEIGHT * 3} ! rawvideoparse format=rgb width={WIDTH} height={HEIGHT} "
        f"framerate={RATE}/1 ! videoconvert ! jpegenc quality=95 ! avimux ! filesink location={path}")


@unittest.skipUnless(PHOTO.exists() and has_engine("onnxruntime"), "no photo, or no engine onnxruntime")
class Appearance(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.temporary.name)
        draw(cls.folder / "clip.mp4", [offset(number) for number in range(FRAMES)])

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    def play(self, clip, tracker=None):
        """The frames that the line writes; `tracker` instead of its tensor_tracker."""
        text = (SOURCE / "src/elements/tensor_tracker/README.md").read_text()
        line = re.search(r"^gst-launch-1\.0 -q\n(?:  .*\n)+", text, re.M).group().replace("\n", " ")
        for name, folder in MODELS.items():
            line = line.replace(f"model={name}", f"model={folder}/")
        line = line.replace("/usr/share/weir/cards", str(SOURCE / "models/cards")).replace("location=clip.mp4", f"location={self.folder}/{clip}")
        if tracker:
            line = re.sub(r"tensor_tracker [^!]*!", f"{tracker} !", line)
        done = subprocess.run(line, shell=True, capture_output=True, text=True, env=ENVIRONMENT, timeout=120, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        return [json.loads(one) for one in done.stdout.splitlines()]

    def share_kept(self, frames):
        """The part of the heads that are found after the crossing with the number that they had before it."""
        numbers = {True: [], False: []}  # of each frame: that of the head that is left at first, that of the other one
        for frame in frames:
            number, found = round(frame["time"] * RATE), sorted(frame["detections"], key=lambda one: one["box"][0])
            if len(found) == 2:
                before = number <= 0.9 * RATE
                numbers[before].append([one.get("track", 0) for one in (found if before else reversed(found))])
        self.assertGreater(len(numbers[True]), 15)
        self.assertGreater(len(numbers[False]), 15)
        begun = numbers[True][-1]
        self.assertEqual(len(set(begun) - {0}), 2, begun)
        return float((numpy.array(numbers[False]) == begun).mean())

    def test_numbers_survive_a_crossing_out_of_sight(self):
        with_looks = self.play("clip.mp4")
        self.assertEqual(self.share_kept(with_looks), 1)
        self.assertEqual({len(one["detections"]) for one in with_looks} - {1, 2}, set())
        for other in ("tensor_tracker max-age=3000000000", "tensor_tracker mode=iou max-age=3000000000"):
            self.assertEqual(self.share_kept(self.play("clip.mp4", other)), 0, other)

    def test_frames_without_objects_hold_up_nothing(self):
        draw(self.folder / "empty.mp4", [None] * 60 + [100] * 5)
        times = [round(frame["time"] * RATE) for frame in self.play("empty.mp4")]
        self.assertEqual(times, list(range(60, 65)))


if __name__ == "__main__":
    tap_runner.main()
