# SPDX-License-Identifier: LGPL-2.1-or-later
"""The clock demo: a network reads the time that timeoverlay draws over a noisy moving picture.

One pipeline, live and in real time. A branch of it goes through the network to tensor_sink; what was read
is drawn under the clock of the same frame, and the picture is recorded. The sinks do not wait for each other
(async=false): the recording needs what tensor_sink gave.
"""

import json

import gi

gi.require_version("Gst", "1.0")
gi.require_version("GstApp", "1.0")
from gi.repository import GLib, Gst, GstApp  # noqa: E402,F401

from demos.contact_sheet import write_contact_sheet
from demos.score import Score, clock_text

RATE = 30
FRAME = Gst.SECOND // RATE
PIPELINE = """
  videotestsrc is-live=true num-buffers={frames} pattern=ball ! {source_caps} ! mix.sink_0
  videotestsrc is-live=true num-buffers={frames} pattern=snow ! {source_caps} ! mix.sink_1
  compositor name=mix sink_1::alpha=0.35 ! {source_caps}
    ! timeoverlay font-desc="DejaVu Sans Mono Bold 32" halignment=left valignment=top xpad=25 ypad=25
    ! tee name=picture

  picture. ! queue name=to_network max-size-buffers=4 leaky=downstream
    ! videocrop left=26 right=302 top=26 bottom=402 ! videoscale ! videoconvert
    ! video/x-raw,format=GRAY8,width=192,height=32 ! tensor_converter
    ! tensor_transform mode=arithmetic option=typecast:float32,add:-127.5,div:127.5
    ! tensor_filter name=network model={model} ! tensor_sink name=cells async=false

  picture. ! queue ! shown.video_sink
  appsrc name=read format=time caps=text/x-raw,format=utf8 ! shown.text_sink
  textoverlay name=shown font-desc="DejaVu Sans Mono Bold 20" halignment=left valignment=bottom
    ! videoconvert ! tee name=recorded
  recorded. ! queue ! vp8enc deadline=1 cpu-used=8 threads=2 target-bitrate=2000000 ! webmmux
    ! filesink location={clip} async=false
  recorded. ! queue ! videorate drop-only=true ! video/x-raw,framerate=12/{seconds} ! videoconvert
    ! video/x-raw,format=RGB ! appsink name=sheet sync=false async=false
"""


class ClockDemo:
    def __init__(self, root, folder, seconds):
        card = json.loads((root / "models" / "clock_digits.card.json").read_text())
        self.labels = ["" if label == "blank" else label for label in card["labels"]]
        self.frames = 0
        self.clip, self.sheet = folder / "clock.webm", folder / "clock.png"
        self.score = Score()
        self.pictures = []
        self.error = None
        caps = f"video/x-raw,format=I420,width=640,height=480,framerate={RATE}/1"
        self.pipeline = Gst.parse_launch(PIPELINE.format(
            frames=seconds * RATE, seconds=seconds, source_caps=caps, model=root / "models" / "clock_digits.onnx", clip=self.clip))
        self.text = self.pipeline.get_by_name("read")
        tee = self.pipeline.get_by_name("picture").get_static_pad("sink")
        tee.add_probe(Gst.PadProbeType.BUFFER, self.on_frame)
        cells = self.pipeline.get_by_name("cells")
        cells.connect("new-data", self.on_cells)
        cells.connect("eos", lambda sink: self.text.end_of_stream())
        sheet = self.pipeline.get_by_name("sheet")
        sheet.set_property("emit-signals", True)
        sheet.connect("new-sample", self.on_picture)

    def on_frame(self, pad, info):
        self.frames += 1
        return Gst.PadProbeReturn.OK

    def on_cells(self, sink, buffer):
        """A frame's cells: probabilities, float32 [1, 12, 13]."""
        _, view = buffer.map(Gst.MapFlags.READ)
        probabilities = memoryview(view.data).cast("f")
        width = len(self.labels)
        read = "".join(
            self.labels[max(range(width), key=lambda label: probabilities[cell * width + label])]
            for cell in range(len(probabilities) // width))
        probabilities.release()
        buffer.unmap(view)
        true = clock_text(buffer.pts)
        self.score.add(read, true)
        if self.score.frames % (RATE + 1) == 1:
            print(f"  read {read:<13} true {true}{'' if read == true else '   <- differs'}", flush=True)
        text = Gst.Buffer.new_wrapped(f"network reads {read}".encode())
        text.pts, text.duration = buffer.pts, FRAME
        self.text.push_buffer(text)

    def on_picture(self, sink):
        sample = sink.pull_sample()
        structure, buffer = sample.get_caps().get_structure(0), sample.get_buffer()
        _, view = buffer.map(Gst.MapFlags.READ)
        self.pictures.append((structure.get_value("width"), structure.get_value("height"), bytes(view.data)))
        buffer.unmap(view)
        return Gst.FlowReturn.OK

    def play(self):
        loop = GLib.MainLoop()
        bus = self.pipeline.get_bus()
        bus.add_signal_watch()
        bus.connect("message::eos", lambda *_: loop.quit())

        def on_error(_, message):
            error, _debug = message.parse_error()
            self.error = f"{message.src.name}: {error.message}"
            loop.quit()

        bus.connect("message::error", on_error)
        self.pipeline.set_state(Gst.State.PLAYING)
        try:
            loop.run()
        except KeyboardInterrupt:
            print("\ndemo: stopped by hand")
            self.pipeline.send_event(Gst.Event.new_eos())
        self.stats = self.pipeline.get_by_name("network").get_property("stats")
        self.pipeline.set_state(Gst.State.NULL)


def run(root, folder, seconds):
    """Plays the demo, prints what was read and measured. Returns the exit code: 0 from 99 % on."""
    Gst.init(None)
    folder.mkdir(parents=True, exist_ok=True)
    print(f"A network reads the clock of a live picture for {seconds} s:")
    demo = ClockDemo(root, folder, seconds)
    demo.play()
    if demo.error:
        print(f"demo: {demo.error}")
        return 1
    score, stats = demo.score, demo.stats
    dropped = demo.frames - score.frames
    print(f"""
  digits right        {score.right} of {score.digits} ({score.share:.2%})
  frames per second   {score.rate:.1f} ({score.frames} frames read)
  in the network      {stats.get_value("average-us") / 1000:.2f} ms a frame, 99 of 100 below {stats.get_value("p99-us") / 1000:.2f} ms
  frames dropped      {dropped} of {demo.frames}

  the annotated clip  {demo.clip}
  the contact sheet   {demo.sheet}
""")
    write_contact_sheet(demo.pictures, demo.sheet)
    if score.share < 0.99:
        print("demo: less than 99 % of the digits were right")
        return 1
    return 0
