# SPDX-License-Identifier: LGPL-2.1-or-later
"""How much of what was read is right."""

import time

SECOND = 1_000_000_000


def clock_text(nanoseconds):
    """The time as timeoverlay writes it: h:mm:ss.mmm, milliseconds cut off."""
    milliseconds = nanoseconds // 1_000_000
    seconds, milliseconds = divmod(milliseconds, 1000)
    minutes, seconds = divmod(seconds, 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{seconds:02}.{milliseconds:03}"


class Score:
    """Digits right: each digit of the true text must stand at its place in what was read."""

    def __init__(self):
        self.frames = self.digits = self.right = 0
        self.first = self.last = None

    def add(self, read, true):
        self.frames += 1
        self.last = time.monotonic()
        self.first = self.first or self.last
        for place, sign in enumerate(true):
            if sign.isdigit():
                self.digits += 1
                self.right += read[place : place + 1] == sign

    @property
    def share(self):
        return self.right / self.digits if self.digits else 0.0

    @property
    def rate(self):
        """Frames per second of wall time."""
        return (self.frames - 1) / (self.last - self.first) if self.frames > 1 else 0.0
