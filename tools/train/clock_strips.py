# SPDX-License-Identifier: LGPL-2.1-or-later
"""Draws labelled clock strips from font glyphs: what the digit reader learns from and is scored on.

A strip is the part of a picture that holds a clock's text, cut into CELLS cells of one character
each. It is drawn at the size at which it stands in a 640x480 picture (a cell is 26x52 pixels) and
then scaled down to the model's input, as a pipeline does with videocrop and videoscale.
"""

import glob
from dataclasses import dataclass

import numpy as np
from PIL import Image, ImageDraw, ImageFont

LABELS = ["0", "1", "2", "3", "4", "5", "6", "7", "8", "9", ":", ".", "blank"]
BLANK = LABELS.index("blank")
CELLS = 12
STRIP_HEIGHT, STRIP_WIDTH = 32, 192  # the model's input: a cell is 16 wide

CELL_PITCH, CELL_HEIGHT = 26, 52  # in the picture
WIDTH = CELLS * CELL_PITCH
MARGIN = 16  # a glyph may lean out of its cell; also keeps shifted glyphs on the canvas

FONT_ROOT = "/usr/share/fonts"
TRAINING_FONTS = [
    "truetype/dejavu/DejaVuSansMono.ttf", "truetype/dejavu/DejaVuSansMono-Bold.ttf",
    "truetype/dejavu/DejaVuSans-Bold.ttf", "truetype/dejavu/DejaVuSerif.ttf",
    "truetype/hack/Hack-Regular.ttf", "truetype/hack/Hack-Bold.ttf",
    "truetype/freefont/FreeMono.ttf", "truetype/freefont/FreeMonoBold.ttf",
    "truetype/freefont/FreeSans.ttf", "truetype/freefont/FreeSansBold.ttf",
    "truetype/freefont/FreeSerifBold.ttf",
    "truetype/jetbrains-mono/JetBrainsMono-Regular.ttf",
    "truetype/jetbrains-mono/JetBrainsMono-ExtraBold.ttf",
    "truetype/noto/NotoMono-Regular.ttf", "truetype/noto/NotoSansMono-Bold.ttf",
    "opentype/inconsolata/Inconsolata.otf",
]
HELD_BACK_FONTS = [  # whole families: no sibling of these is trained on
    "truetype/liberation/LiberationMono-Regular.ttf", "truetype/liberation/LiberationMono-Bold.ttf",
    "truetype/liberation/LiberationSans-Bold.ttf",
    "truetype/firacode/FiraCode-Medium.ttf", "truetype/firacode/FiraCode-Bold.ttf",
]
DIGIT_HEIGHTS = (28, 30, 32, 33, 34, 36)  # pixels in the picture; DejaVu Sans Mono Bold 32 is 33
OUTLINE_WIDTHS = (1, 2)


def font_path(name):
    """The file of a font given relative to FONT_ROOT; Debian moves some between folders."""
    found = glob.glob(f"{FONT_ROOT}/**/{name.rsplit('/', 1)[-1]}", recursive=True)
    if not found:
        raise FileNotFoundError(f"font {name} is not installed; see tools/train/README.md")
    return sorted(found)[0]


@dataclass
class GlyphSet:
    """One font at one size: for each printable label an alpha mask, bare and with outlines."""

    bare: np.ndarray  # [labels, height, width], 0..1
    outlined: dict  # outline width -> array of the same shape


def sized_font(path, digit_height):
    """The font at the size where '0' is digit_height tall and every digit fits a cell."""
    probe = ImageFont.truetype(path, 100)
    left, top, right, bottom = probe.getbbox("0", anchor="ls")
    widest = max(probe.getlength(digit) for digit in "0123456789")
    size = 100 * min(digit_height / (bottom - top), 1.06 * CELL_PITCH / widest)
    return ImageFont.truetype(path, max(1, round(size)))


def draw_mask(font, text, baseline, outline):
    """One character, centred by its advance on a canvas that is a cell and its margins."""
    canvas = Image.new("L", (CELL_PITCH + 2 * MARGIN, CELL_HEIGHT + 2 * MARGIN))
    x = canvas.width / 2 - font.getlength(text) / 2
    ImageDraw.Draw(canvas).text((x, baseline), text, fill=255, font=font, anchor="ls", stroke_width=outline)
    return np.asarray(canvas, dtype=np.float32) / 255


def draw_masks(font, baseline, outline):
    return np.stack([draw_mask(font, character, baseline, outline) for character in LABELS[:BLANK]])


def load_glyphs(name):
    """All glyph sets of one font."""
    sets = []
    for digit_height in DIGIT_HEIGHTS:
        font = sized_font(font_path(name), digit_height)
        left, top, right, bottom = font.getbbox("0", anchor="ls")
        baseline = MARGIN + CELL_HEIGHT / 2 - (top + bottom) / 2
        outlined = {width: draw_masks(font, baseline, width) for width in OUTLINE_WIDTHS}
        sets.append(GlyphSet(draw_masks(font, baseline, 0), outlined))
    return sets


def random_labels(rng):
    """Half clock-like text, half any characters, so that no cell learns what usually stands in it."""
    if rng.random() < 0.5:
        return rng.choice(len(LABELS), CELLS, p=[0.076] * 10 + [0.08] * 3)
    hours = rng.choice([rng.integers(10), rng.integers(10, 100)])
    text = f"{hours}:{rng.integers(60):02}:{rng.integers(60):02}.{rng.integers(1000):03}"
    return np.array([LABELS.index(c) for c in text] + [BLANK] * (CELLS - len(text)))


def scaled(image, width, height, method):
    return np.asarray(Image.fromarray(image.astype(np.float32)).resize((width, height), method))


def random_background(rng):
    """Flat, gradient, colour-bar, blotchy or checked grey, at times with discs; 0..255."""
    low, high = np.sort(rng.uniform(0, 255, 2))
    kind = rng.integers(5)
    if kind == 0:
        picture = np.full((CELL_HEIGHT, WIDTH), low if rng.random() < 0.6 else high)
    elif kind == 1:
        picture = np.linspace(*rng.permutation([low, high]), WIDTH)[None, :].repeat(CELL_HEIGHT, 0)
    else:
        columns = rng.integers(2, 12) if kind == 2 else rng.integers(2, 60)
        rows = 1 if kind == 2 else rng.integers(1, 12)
        method = Image.BICUBIC if kind == 3 else Image.NEAREST
        picture = scaled(rng.uniform(low, high, (rows, columns)), WIDTH, CELL_HEIGHT, method)
    for _ in range(rng.choice(4, p=[0.5, 0.2, 0.15, 0.15])):
        picture = with_disc(picture, rng)
    return with_noise(picture.astype(np.float32), rng)


def with_disc(picture, rng):
    """A disc in any place, as light as the text or any grey: its edges must not pass for a character."""
    y, x = np.mgrid[:CELL_HEIGHT, :WIDTH]
    radius, cy, cx = rng.uniform(8, 60), rng.uniform(-20, CELL_HEIGHT + 20), rng.uniform(-10, WIDTH + 10)
    value = rng.choice([255, rng.uniform(0, 255)])
    return np.where((y - cy) ** 2 + (x - cx) ** 2 < radius**2, value, picture)


def with_noise(picture, rng):
    """Blends in snow (independent grey pixels) or adds Gaussian noise."""
    kind = rng.integers(3)
    if kind == 0:
        return picture
    if kind == 1:
        weight = rng.uniform(0, 1)
        return (1 - weight) * picture + weight * rng.uniform(0, 255, picture.shape)
    return picture + rng.normal(0, rng.uniform(2, 50), picture.shape)


def text_mask(masks, labels, origin, pitch):
    """Alpha of a whole line; origin (x, y) shifts it from its nominal place."""
    line = np.zeros((CELL_HEIGHT + 4 * MARGIN, WIDTH + 4 * MARGIN), dtype=np.float32)
    height, width = masks.shape[1:]
    for cell, label in enumerate(labels):
        if label == BLANK:
            continue
        x = round(MARGIN + origin[0] + cell * pitch)
        y = round(MARGIN + origin[1])
        window = line[y : y + height, x : x + width]
        np.maximum(window, masks[label], out=window)
    return line[2 * MARGIN : -2 * MARGIN, 2 * MARGIN : -2 * MARGIN]


def paint(picture, alpha, value):
    return picture + alpha * (value - picture)


def draw_picture(glyphs, labels, rng):
    """The strip as it stands in the picture: light text with, mostly, an outline and a shadow."""
    origin, pitch = rng.uniform((-3.5, -5), (3.5, 5)), rng.uniform(25.7, 26.3)
    bare = text_mask(glyphs.bare, labels, origin, pitch)
    picture, ink = random_background(rng), rng.uniform(200, 255)
    if rng.random() < 0.3:  # a shaded box, as timeoverlay can draw
        picture = picture - rng.uniform(40, 140)
    style = rng.random()
    if style < 0.75:
        shadow = np.roll(bare, rng.integers(1, 4, 2), (0, 1))
        picture = paint(picture, shadow * rng.uniform(0, 0.8), 0)
        picture = paint(picture, text_mask(glyphs.outlined[rng.choice(OUTLINE_WIDTHS)], labels, origin, pitch),
                        rng.uniform(0, 40))
    else:  # no outline: keep the picture dark enough for the text to show
        picture = np.clip(picture, 0, 255) * rng.uniform(0.2, 0.55)
    return paint(np.clip(picture, 0, 255), bare, ink)


def draw_strip(glyphs, labels, rng):
    """One model input as uint8 [STRIP_HEIGHT, STRIP_WIDTH]: drawn, scaled, at times soft or noisy."""
    picture = draw_picture(glyphs, labels, rng)
    method = rng.choice([Image.BILINEAR, Image.BOX, Image.NEAREST, Image.BICUBIC])
    strip = scaled(picture, STRIP_WIDTH, STRIP_HEIGHT, int(method))
    contrast, brightness = rng.uniform(0.6, 1.1), rng.uniform(-25, 25)
    strip = (strip - 127.5) * contrast + 127.5 + brightness
    if rng.random() < 0.4:
        strip = strip + rng.normal(0, rng.uniform(1, 20), strip.shape)
    return np.clip(np.rint(strip), 0, 255).astype(np.uint8)


def draw_strips(fonts, count, seed):
    """count strips [count, H, W] and their labels [count, CELLS], the fonts in turn."""
    rng = np.random.default_rng(seed)
    sets = [load_glyphs(name) for name in fonts]
    strips = np.empty((count, STRIP_HEIGHT, STRIP_WIDTH), dtype=np.uint8)
    labels = np.empty((count, CELLS), dtype=np.int64)
    for i in range(count):
        of_font = sets[i % len(sets)]
        labels[i] = random_labels(rng)
        strips[i] = draw_strip(of_font[rng.integers(len(of_font))], labels[i], rng)
    return strips, labels
