#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Scores models/clock_digits.onnx on clocks that timeoverlay really drew over noisy moving pictures.

Frame n of a picture is due at n * STEP, so what its clock shows is known without reading it. The
frames are far apart in time (122.5 s), which makes every digit change and the hours reach two digits.
"""

import argparse
import pathlib
import subprocess
import sys
import tempfile

import cv2
import numpy as np

import clock_strips as strips

STEP_NUMERATOR, STEP_DENOMINATOR = 12371, 101  # seconds between frames: the inverse of the frame rate
FORMAT = f"video/x-raw,width=640,height=480,framerate={STEP_DENOMINATOR}/{STEP_NUMERATOR}"
OVERLAY = 'timeoverlay font-desc="DejaVu Sans Mono Bold 32" halignment=left valignment=top xpad=25 ypad=25'
CROP = "videocrop left=26 right=302 top=26 bottom=402"  # 312x52 at (26, 26): 12 cells of 26x52
STRIP = f"videoscale ! videoconvert ! video/x-raw,format=GRAY8,width={strips.STRIP_WIDTH},height={strips.STRIP_HEIGHT}"
MODEL = pathlib.Path(__file__).resolve().parents[2] / "models" / "clock_digits.onnx"

# Name of a picture: (bottom pattern, top pattern, top's opacity, more timeoverlay properties).
PICTURES = {
    "ball under light snow": ("ball", "snow", 0.35, ""),
    "ball under heavy snow": ("ball", "snow", 0.7, ""),
    "colour bars under snow": ("smpte", "snow", 0.35, ""),
    "snow alone, shaded text": ("snow", "snow", 0.5, "shaded-background=true"),
    "snow alone": ("snow", "snow", 0.5, ""),
    "moving zone plate": ("zone-plate kx2=20 ky2=20 kt=7", "snow", 0.2, ""),
}


def pipeline(picture, frames, path):
    """The gst-launch-1.0 arguments that write the strips of one picture to path."""
    bottom, top, opacity, more = picture
    return (f"compositor name=mix sink_1::alpha={opacity} ! {FORMAT} ! videoconvert ! {FORMAT},format=I420 "
            f"! {OVERLAY} {more} ! {CROP} ! {STRIP} ! filesink location={path} "
            f"videotestsrc num-buffers={frames} pattern={bottom} ! {FORMAT} ! mix.sink_0 "
            f"videotestsrc num-buffers={frames} pattern={top} ! {FORMAT} ! mix.sink_1")


def record(picture, frames):
    """What the pipeline hands the model, as uint8 [frames, H, W]."""
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "strips.gray8"
        command = "exec gst-launch-1.0 -q " + pipeline(picture, frames, path).replace(" ! ", " '!' ")
        subprocess.run(["sh", "-c", command], check=True)
        return np.fromfile(path, np.uint8).reshape(-1, strips.STRIP_HEIGHT, strips.STRIP_WIDTH)


def clock_text(frame):
    milliseconds = frame * 1000 * STEP_NUMERATOR // STEP_DENOMINATOR
    seconds, milliseconds = divmod(milliseconds, 1000)
    return f"{seconds // 3600}:{seconds // 60 % 60:02}:{seconds % 60:02}.{milliseconds:03}".ljust(strips.CELLS)


def read(network, strip):
    """The text that the model sees in one strip, a space for each blank cell."""
    tensor = (strip.astype(np.float32) - 127.5) / 127.5
    network.setInput(tensor.reshape(1, strips.STRIP_HEIGHT, strips.STRIP_WIDTH, 1), "strip")
    best = network.forward().reshape(strips.CELLS, -1).argmax(1)
    return "".join(" " if label == strips.BLANK else strips.LABELS[label] for label in best)


def score(network, recorded):
    """(digits right, digits, whole clocks right), with the first few misread clocks printed."""
    right = total = clocks = 0
    for frame, strip in enumerate(recorded):
        expected, seen = clock_text(frame), read(network, strip)
        digits = [place for place, character in enumerate(expected) if character.isdigit()]
        right += sum(expected[place] == seen[place] for place in digits)
        total += len(digits)
        clocks += expected == seen
        if expected != seen and frame + 1 - clocks <= 3:
            print(f"    frame {frame}: '{expected}' read as '{seen}'")
    return right, total, clocks


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--frames", type=int, default=360, help="frames of each picture")
    parser.add_argument("--least", type=float, default=0.995, help="part of the digits that must be right")
    chosen = parser.parse_args()
    network = cv2.dnn.readNetFromONNX(str(MODEL))
    failed = False
    for name, picture in PICTURES.items():
        recorded = record(picture, chosen.frames)
        right, total, clocks = score(network, recorded)
        print(f"{name}: {right / total:.3%} of {total} digits right, {clocks} of {len(recorded)} whole clocks")
        failed |= right < chosen.least * total or len(recorded) < chosen.frames
    sys.exit(failed)


if __name__ == "__main__":
    main()
