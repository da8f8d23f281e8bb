# SPDX-License-Identifier: LGPL-2.1-or-later
"""Makes clips for measuring from the user's clip: repeated, at another rate, or as single pictures, without re-encoding."""

import gi

gi.require_version("Gst", "1.0")
gi.require_version("GstApp", "1.0")
from gi.repository import Gst, GstApp  # noqa: E402, F401: GstApp provides pull_sample

SECOND = 1_000_000_000


def samples(line):
    """The output of `line ! appsink`. SystemExit with GStreamer's error."""
    Gst.init(None)
    pipeline = Gst.parse_launch(line + " ! appsink name=out sync=false max-buffers=64")
    pipeline.set_state(Gst.State.PLAYING)
    sink, found = pipeline.get_by_name("out"), []
    while (sample := sink.try_pull_sample(10 * SECOND)) is not None:
        found.append(sample)
    fault = pipeline.get_bus().pop_filtered(Gst.MessageType.ERROR)
    ended = sink.is_eos()
    pipeline.set_state(Gst.State.NULL)
    if fault or not ended or not found:
        raise SystemExit(f"bench: {line}: " + (fault.parse_error()[0].message if fault else "nothing comes"))
    return found


def write(path, caps, pieces):
    """Writes (bytes, pts, duration, whether it is a delta frame) tuples into a Matroska file."""
    pipeline = Gst.parse_launch(f'appsrc name=in format=time max-bytes=0 ! matroskamux ! filesink location="{path}"')
    source = pipeline.get_by_name("in")
    source.set_property("caps", caps)
    pipeline.set_state(Gst.State.PLAYING)
    for memory, pts, duration, delta in pieces:
        buffer = memory.copy_deep()  # copy() of these bindings returns the same buffer
        buffer.pts, buffer.dts, buffer.duration = pts, Gst.CLOCK_TIME_NONE, duration
        if delta:
            buffer.set_flags(Gst.BufferFlags.DELTA_UNIT)
        source.emit("push-buffer", buffer)
    source.emit("end-of-stream")
    message = pipeline.get_bus().timed_pop_filtered(60 * SECOND, Gst.MessageType.ERROR | Gst.MessageType.EOS)
    pipeline.set_state(Gst.State.NULL)
    if not message or message.type == Gst.MessageType.ERROR:
        raise SystemExit(f"bench: {path} cannot be written")


def quoted(path):
    return '"' + str(path).replace("\\", "\\\\").replace('"', '\\"') + '"'


class Clip:
    """A user's video as coded pictures."""

    def __init__(self, path):
        self.path = path
        self.coded = samples(f"filesrc location={quoted(path)} ! parsebin name=p p. ! video/x-h264,alignment=au;"
                             "video/x-h265,alignment=au;video/x-vp8;video/x-vp9;image/jpeg;video/x-theora")

    def __len__(self):
        return len(self.coded)

    def again(self, path, rate, count):
        """Writes `count` coded pictures at `rate` per second, repeating the clip from its beginning.

        Decoding order differs from display order: some of the last pictures may be missing in between, and the others
        close the gap.
        """
        period = SECOND // rate
        taken = [(place // len(self), self.coded[place % len(self)].get_buffer()) for place in range(count)]
        shown = {one: place for place, one in enumerate(sorted((turn, buffer.pts) for turn, buffer in taken))}
        write(path, self.coded[0].get_caps(),
              [(buffer, shown[turn, buffer.pts] * period, period, buffer.has_flags(Gst.BufferFlags.DELTA_UNIT)) for turn, buffer in taken])
        return path

    def pictures(self, path, first, count, rate=1):
        """`count` single pictures (JPEG, quality 95), evenly spaced from picture `first` on, `rate` per second."""
        found = samples(f"filesrc location={quoted(self.path)} ! decodebin ! videoconvert ! video/x-raw,format=I420 ! "
                        "jpegenc quality=95")
        step = max(len(found) // count, 1)
        chosen = [found[(first + place * step) % len(found)] for place in range(count)]
        write(path, chosen[0].get_caps(),
              [(one.get_buffer(), place * SECOND // rate, SECOND // rate, False) for place, one in enumerate(chosen)])
        return path
