# SPDX-License-Identifier: LGPL-2.1-or-later
"""The modes pose_estimation, image_segment and tensor_region of tensor_decoder in NumPy.

Written from docs/compatibility/decoder.md 5.4, 5.5 and 5.7.
"""

import numpy as np

from bounding_boxes_reference import f4, mobilenet_ssd
from drawing_reference import RISE, WHITE, Frame

# Names and connections.
BODY = [("top", [1]), ("neck", [0, 2, 5, 8, 11]), ("r_shoulder", [1, 3]), ("r_elbow", [2, 4]), ("r_wrist", [3]),
        ("l_shoulder", [1, 6]), ("l_elbow", [5, 7]), ("l_wrist", [6]), ("r_hip", [1, 9]), ("r_knee", [8, 10]), ("r_ankle", [9]),
        ("l_hip", [1, 12]), ("l_knee", [11, 13]), ("l_ankle", [12])]


def joints(heat, output, size, offsets=None):
    """The place of each key point in pixels of the output, or None; arrays have rows, columns and key points."""
    (ow, oh), (iw, ih) = output, size
    rows, columns, points = heat.shape
    if offsets is not None:
        heat = 1 / (1 + np.exp(-heat))
    found = []
    for k in range(points):
        row, column = np.unravel_index(heat[:, :, k].argmax(), (rows, columns))
        if heat[row, column, k] < 0.5:
            found.append(None)
            continue
        if offsets is None:
            x, y = column * ow // iw, row * oh // ih
        else:
            px = f4(column) / f4(columns - 1) * f4(iw) + offsets[row, column, points + k]
            py = f4(row) / f4(rows - 1) * f4(ih) + offsets[row, column, k]
            x, y = np.trunc(px * f4(ow) / f4(iw)), np.trunc(py * f4(oh) / f4(ih))
        found.append((int(np.clip(x, 0, ow)), int(np.clip(y, 0, oh))))
    return found


def draw_pose(places, output, body):
    frame = Frame(output)
    for i, (_, connected) in enumerate(body):
        for k in connected:
            if k < i or places[i] is None or places[k] is None:
                continue
            frame.dot(*places[i], WHITE)
            frame.dot(*places[k], WHITE)
            start, end = sorted((places[i], places[k]), key=lambda place: place[0])
            frame.line(*start, *end, WHITE, thick=True)
    for place, (name, _) in zip(places, body):
        if place is not None:
            frame.text(place[0], max(0, place[1] - RISE), name)
    return frame


def class_colors(labels):
    return np.array([0] + [0xFFFFFF // (labels + 1) * i | 0xFF000000 for i in range(1, labels + 1)], "<u4")


def segment_scores(scores, labels):
    """The pixels of scores of rows, columns and classes."""
    classes = np.where(scores.max(axis=2) > f4(0.5), scores.argmax(axis=2), 0)
    return class_colors(labels)[classes]


def segment_numbers(numbers, labels):
    return class_colors(labels)[numbers.astype(int)]


def depths(values):
    if values.max() == 0:
        return np.zeros(values.shape, "<u4")
    gray = (values / values.max() * f4(255)).astype(np.uint32)
    return gray * 0x010101 | 0xFF000000


def regions(boxes, scores, priors, size, count, *parameters):
    """`count` regions of x, y, width, height; unused ones are zero."""
    found = mobilenet_ssd(boxes, scores, priors, size, *parameters, first=True)[:count]
    return np.array([box[:4] for box in found] + [[0] * 4] * (count - len(found)), "<u4")
