# SPDX-License-Identifier: LGPL-2.1-or-later
"""Plays a pipeline."""

import gi

gi.require_version("Gst", "1.0")
from gi.repository import GLib, Gst  # noqa: E402


def play_to_end(pipeline):
    """Plays until the end of the stream or an error: its text, or None. The pipeline stays in PLAYING."""
    loop, bus, errors = GLib.MainLoop(), pipeline.get_bus(), []

    def on_error(_, message):
        errors.append(f"{message.src.name}: {message.parse_error()[0].message}")
        loop.quit()

    bus.add_signal_watch()
    bus.connect("message::eos", lambda *_: loop.quit())
    bus.connect("message::error", on_error)
    pipeline.set_state(Gst.State.PLAYING)
    loop.run()
    return errors[0] if errors else None
