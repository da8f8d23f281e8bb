#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""weir evaluate --page: the page with the worst pictures."""

import base64
import html.parser
import io
import itertools
import re

import numpy
import tap_runner
from evaluation_case import SIZE, Coco
from PIL import Image


class BalancedHtml(html.parser.HTMLParser):
    """Fails where an element ends that is not the innermost open one, where an attribute is given twice or an id is not unique."""

    VOID = {"meta", "link", "br", "img", "hr", "input", "col"}

    def __init__(self):
        super().__init__()
        self.open, self.ids = [], set()

    def handle_starttag(self, tag, attrs):
        names = [name for name, _ in attrs]
        assert len(names) == len(set(names)), f"{tag}: an attribute twice: {names}"
        for name, value in attrs:
            assert name != "id" or value not in self.ids, f"id {value} twice"
            self.ids |= {value} if name == "id" else set()
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        pass

    def handle_endtag(self, tag):
        assert self.open and self.open[-1] == tag, f"</{tag}> in {self.open}"
        self.open.pop()


class Page(Coco):
    def test_has_the_worst_pictures_and_nothing_from_the_net(self):
        self.add([(0, 10, 10, 80, 80)], [[10, 10, 90, 90, 200, 0]])
        self.add([(0, 10, 10, 80, 80), (0, 150, 150, 50, 50)], [[100, 10, 140, 90, 200, 0]])
        self.write(("a <thing>",))
        page = self.folder / "page.html"
        self.assertIn(f"Page: {page}", self.good(self.evaluate("--page", page)))
        text = page.read_text()
        classes = re.findall(r'<p class="(\w+)"', text)
        for name in set(classes):  # one rule for each: the styles of two pages are joined
            self.assertEqual(len(re.findall(rf"\.{name}\b[^{{}}]*{{", text)), 1, name)
        self.assertNotRegex(text, "https?://|<script")
        self.assertEqual(text.count("data:image/jpeg;base64,"), 1)  # the first has no errors
        self.assertIn("2.png<br>2 missed, 1 false", text)
        self.assertIn('<rect class="missed" x="150.0" y="150.0" width="50.0" height="50.0"/>', text)
        self.assertIn('<rect class="false" x="100.0" y="10.0" width="40.0" height="80.0"/>', text)
        self.assertIn("a &lt;thing&gt;", text)
        balanced = BalancedHtml()
        balanced.feed(text)
        balanced.close()
        self.assertEqual(balanced.open, [])

    def test_the_pictures_are_those_of_the_folder(self):
        self.add([(0, 10, 10, 80, 80)], [[200, 10, 230, 90, 255, 0]])
        self.write()
        page = self.folder / "page.html"
        self.good(self.evaluate("--page", page))
        jpeg = base64.b64decode(re.search("base64,([^\"]+)\"", page.read_text()).group(1))
        shown = numpy.asarray(Image.open(io.BytesIO(jpeg)).convert("L"), int)
        original = numpy.asarray(Image.open(self.folder / "set" / "1.png"), int)
        self.assertEqual(shown.shape, original.shape)
        self.assertLess(numpy.abs(shown - original).mean(), 3)

    def test_that_cannot_be_written(self):
        self.add([(0, 10, 10, 80, 80)], [])
        self.write()
        self.refused(self.evaluate("--page", self.folder / "none" / "page.html"), 1, "WEIR-4010", "the page cannot be written")

    def labels(self, text):
        """The rectangle of each label, x1, y1, x2, y2, and its text."""
        found = re.findall(r'<g class="label \w+"><rect x="([\d.-]+)" y="([\d.-]+)" width="([\d.]+)" height="([\d.]+)"/><text[^>]*>([^<]*)', text)
        return [((x, y, x + width, y + height), label) for *place, label in found for x, y, width, height in [map(float, place)]]

    def test_labels_stay_inside_the_picture_and_do_not_cover_each_other(self):
        # Three results at one place, one at the right edge, one at the lower edge, and objects that are missed there.
        rows = [[10, 10, 90, 90, 200, 0], [10, 10, 91, 91, 210, 0], [12, 11, 92, 92, 220, 0], [250, 100, 255, 200, 230, 0], [100, 250, 200, 255, 240, 0]]
        self.add([(0, 200, 20, 79, 30), (0, 150, 240, 60, 39)], rows)
        self.write(("something",))
        page = self.folder / "page.html"
        self.good(self.evaluate("--page", page))
        labels = self.labels(page.read_text())
        self.assertEqual(sorted(label.split(" ")[0] for _, label in labels), ["something"] * 7)
        for (x1, y1, x2, y2), label in labels:
            self.assertTrue(0 <= x1 and 0 <= y1 and x2 <= SIZE[0] and y2 <= SIZE[1], (x1, y1, x2, y2, label))
        for (one, _), (other, _) in itertools.combinations(labels, 2):
            self.assertTrue(one[2] <= other[0] or other[2] <= one[0] or one[3] <= other[1] or other[3] <= one[1], (one, other))

    def test_boxes_of_large_pictures_are_drawn_in_pixels_of_the_page(self):
        self.add([(0, 1000, 400, 200, 100)], [])
        Image.new("L", (1280, 640)).save(self.folder / "set" / "1.png")
        self.truth["images"][-1] |= {"width": 1280, "height": 640}
        self.write()
        page = self.folder / "page.html"
        self.good(self.evaluate("--page", page))
        self.assertIn('<rect class="missed" x="500.0" y="200.0" width="100.0" height="50.0"/>', page.read_text())
        self.assertIn('viewBox="0 0 640 320" width="640" height="320"', page.read_text())


if __name__ == "__main__":
    tap_runner.main()
