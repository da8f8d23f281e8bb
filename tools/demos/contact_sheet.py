# SPDX-License-Identifier: LGPL-2.1-or-later
"""A contact sheet: pictures of a run in one PNG."""

from PIL import Image

COLUMNS, WIDTH, GAP = 4, 400, 6


def make_picture(width, height, data):
    """RGB bytes; rows padded to 4 bytes as GStreamer does."""
    return Image.frombuffer("RGB", (width, height), data, "raw", "RGB", (width * 3 + 3) // 4 * 4, 1)


def save_picture(width, height, data, path):
    make_picture(width, height, data).save(path)


def write_contact_sheet(pictures, path):
    """pictures: (width, height, RGB bytes)."""
    thumbnails = []
    for width, height, data in pictures:
        picture = make_picture(width, height, data)
        thumbnails.append(picture.resize((WIDTH, WIDTH * height // width)))
    if not thumbnails:
        return
    row_height = max(t.height for t in thumbnails) + GAP
    rows = -(-len(thumbnails) // COLUMNS)
    sheet = Image.new("RGB", (COLUMNS * (WIDTH + GAP) + GAP, rows * row_height + GAP), "white")
    for index, thumbnail in enumerate(thumbnails):
        row, column = divmod(index, COLUMNS)
        sheet.paste(thumbnail, (GAP + column * (WIDTH + GAP), GAP + row * row_height))
    sheet.save(path)
