# SPDX-License-Identifier: LGPL-2.1-or-later
"""Draws into RGBA frames with NumPy, written from docs/compatibility/decoder.md: what the drawing decoders are compared with."""

import numpy as np

RED, WHITE = (255, 0, 0, 255), (255, 255, 255, 255)
CELL = (13, 8)  # rows and columns of a character
ADVANCE, RISE = 9, 14
# Of a key point, without its centre: (dx, dy).
DOT = [(dx, dy) for dx, far in ((-3, 1), (3, 1), (-2, 2), (2, 2), (-1, 3), (1, 3), (0, 3)) for dy in range(-far, far + 1)
       if (dx, dy) != (0, 0)] + [(-4, 0), (4, 0), (0, -4), (0, 4)]


class Frame:
    """A transparent frame. Cells of text are only noted: their place is known, the shapes of glyphs are free."""

    def __init__(self, size):
        width, height = size
        self.pixels = np.zeros((height, width, 4), np.uint8)
        self.letters = []  # byte, left, top
        self.letter_at = np.full((height, width), -1)  # that was written last to a pixel

    def set(self, x, y, color):
        if 0 <= x < self.pixels.shape[1] and 0 <= y < self.pixels.shape[0]:
            self.pixels[y, x] = color
            self.letter_at[y, x] = -1

    def outline(self, left, top, right, bottom, color):
        for x in range(left, right + 1):
            self.set(x, top, color)
            self.set(x, bottom, color)
        for y in range(top + 1, bottom):
            self.set(left, y, color)
            self.set(right, y, color)

    def line(self, x1, y1, x2, y2, color, thick=False):
        """The nearest pixel at each step of the longer side; a half goes away from the start."""
        steps = max(abs(x2 - x1), abs(y2 - y1))

        def at(start, end, i):
            away = (2 * i * abs(end - start) + steps) // (2 * steps) if steps else 0
            return start + (away if end > start else -away)
        for i in range(steps + 1):
            x, y = at(x1, x2, i), at(y1, y2, i)
            self.set(x, y, color)
            if thick:
                self.set(x + 1, y, color)
                self.set(x, y + 1, color)

    def dot(self, x, y, color):
        for dx, dy in DOT:
            self.set(x + dx, y + dy, color)

    def text(self, x, y, text):
        height, width = self.letter_at.shape
        for byte in text.encode():
            if x + CELL[1] > width:
                return
            rows, columns = slice(max(0, y), max(0, y + CELL[0])), slice(max(0, x), max(0, x + CELL[1]))
            self.letter_at[rows, columns] = len(self.letters)
            self.letters.append((byte, x, y))
            x += ADVANCE


class Glyphs:
    """What frames show of each character: it looks the same in each of its cells."""

    def __init__(self, color):
        self.color = np.array(color, np.uint8)
        self.seen = {}  # character -> 1 where a pixel has the colour, 0 where it is transparent, -1 where it was covered

    def compare(self, drawn, wanted):
        """Raises AssertionError unless the picture is what the frame wants."""
        known = wanted.letter_at < 0
        np.testing.assert_array_equal(drawn[known], wanted.pixels[known])
        for i, (byte, left, top) in enumerate(wanted.letters):
            rows, columns = np.nonzero(wanted.letter_at == i)
            colored = (drawn[rows, columns] == self.color).all(axis=1)
            assert (colored | (drawn[rows, columns] == 0).all(axis=1)).all(), "text has one colour on transparent cells"
            glyph = self.seen.setdefault(chr(byte) if 32 <= byte <= 126 else "*", np.full(CELL, -1))
            before = glyph[rows - top, columns - left]
            assert ((before == colored) | (before < 0)).all(), f"the character {byte} looks like itself"
            glyph[rows - top, columns - left] = colored

    def check(self, least):
        """At least so many characters were seen as a whole, all different, and only the blank is empty."""
        whole = {char: glyph for char, glyph in self.seen.items() if (glyph >= 0).all()}
        assert len(whole) >= least, sorted(whole)
        assert len({glyph.tobytes() for glyph in whole.values()}) == len(whole), "glyphs differ"
        for char, glyph in whole.items():
            assert glyph.any() == (char != " "), repr(char)
