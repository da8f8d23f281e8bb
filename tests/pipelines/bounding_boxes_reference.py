# SPDX-License-Identifier: LGPL-2.1-or-later
"""The mode bounding_boxes of tensor_decoder in NumPy, written from docs/compatibility/decoder.md 5.3."""

import numpy as np

from drawing_reference import RED, RISE, Frame

f4 = np.float32


def whole(value):
    """As a conversion in C: towards zero."""
    return int(np.trunc(value))


def overlap(a, b):
    across = max(0, min(a[0] + a[2], b[0] + b[2]) - max(a[0], b[0]) + 1)
    down = max(0, min(a[1] + a[3], b[1] + b[3]) - max(a[1], b[1]) + 1)
    both = across * down
    if not both:
        return 0.0
    union = a[2] * a[3] + b[2] * b[3] - both
    return max(0.0, both / union) if union else float("inf")


def rotated_overlap(a, b):
    small, large = (a, b) if a[2] * a[3] <= b[2] * b[3] else (b, a)
    steps = (np.arange(6) + 0.5) / 6 - 0.5
    x, y = np.meshgrid(steps * small[2], steps * small[3])
    cos, sin = np.cos(float(small[6])), np.sin(float(small[6]))
    x, y = small[0] + x * cos - y * sin - large[0], small[1] + x * sin + y * cos - large[1]
    cos, sin = np.cos(float(large[6])), np.sin(float(large[6]))
    inside = (abs(x * cos + y * sin) <= large[2] / 2) & (abs(y * cos - x * sin) <= large[3] / 2)
    both = small[2] * small[3] * inside.sum() / 36
    union = a[2] * a[3] + b[2] * b[3] - both
    return both / union if union > 0 else 0.0


def suppress(boxes, threshold, how=overlap):
    kept = []
    for box in sorted(boxes, key=lambda b: -b[5]):
        if not any(f4(how(better, box)) > f4(threshold) for better in kept):
            kept.append(box)
    return kept


# Each scheme returns boxes of x, y, width, height, class, probability and angle.

def mobilenet_ssd(boxes, scores, priors, size, threshold=0.5, scales=(10, 10, 5, 5), most=0.5, first=False):
    """With `first` the first class over the threshold, as tensor_region takes it; otherwise the best."""
    width, height = size
    found = []
    for b, s, (py, px, ph, pw) in zip(boxes.reshape(-1, 4), scores, priors.T):
        over = s[1:] >= np.log(threshold / (1 - threshold))
        if not over.any():
            continue
        best = 1 + (over if first else s[1:]).argmax()
        yc, xc = b[0] / f4(scales[0]) * ph + py, b[1] / f4(scales[1]) * pw + px
        h, w = np.exp(b[2] / f4(scales[2])) * ph, np.exp(b[3] / f4(scales[3])) * pw
        found.append((max(0, whole((xc - w / 2) * width)), max(0, whole((yc - h / 2) * height)), whole(w * width),
                      whole(h * height), best, 1 / (1 + np.exp(-s[best])), 0))
    return suppress(found, most)


def postprocessed(boxes, classes, scores, count, size, threshold):
    found = []
    for (y1, x1, y2, x2), c, s in zip(boxes.clip(0, 1)[:int(count)], classes, scores):
        if s >= f4(threshold):
            found.append((whole(x1 * size[0]), whole(y1 * size[1]), whole((x2 - x1) * size[0]), whole((y2 - y1) * size[1]),
                          int(c), s, 0))
    return found


def openvino(records, size):
    found = []
    for image, _, conf, x1, y1, x2, y2 in records:
        if image < 0:
            break
        if conf >= f4(0.8):
            found.append((whole(x1 * size[0]), whole(y1 * size[1]), whole((x2 - x1) * size[0]), whole((y2 - y1) * size[1]),
                          -1, 1, 0))
    return found


def yolo(rows, size, fixed, in_pixels, threshold, most):
    """YOLOv5 (5 values before the classes) and YOLOv8 (4)."""
    scale = np.array([1, 1, 1, 1] if in_pixels else [*size, *size], f4)
    found = []
    for row in rows:
        best = row[fixed:].argmax()
        probability = row[fixed + best] * (row[4] if fixed == 5 else f4(1))
        if probability > f4(threshold):
            cx, cy, w, h = row[:4] * scale
            found.append((whole(max(f4(0), cx - w / 2)), whole(max(f4(0), cy - h / 2)), whole(min(f4(size[0]), w)),
                          whole(min(f4(size[1]), h)), best, probability, 0))
    return suppress(found, most)


def yolo_obb(rows, size, threshold, most):
    found = []
    for row in rows:
        scores = row[4:-1]
        if scores.max() > f4(threshold):
            cx, cy, w, h = row[:4] * np.array([*size, *size], f4)
            found.append((max(0, whole(cx)), max(0, whole(cy)), whole(w), whole(h), scores.argmax(), scores.max(), row[-1]))
    return suppress(found, most, rotated_overlap)


def yolov10(rows, size, threshold):
    found = []
    for x1, y1, x2, y2, conf, c in rows:
        if conf < f4(threshold):
            break
        found.append((whole(x1 * size[0]), whole(y1 * size[1]), whole((x2 - x1) * size[0]), whole((y2 - y1) * size[1]),
                      int(c), conf, 0))
    return found


def palm_anchors(strides=(8, 16, 16, 16), least=1.0, greatest=1.0, offset=(0.5, 0.5)):
    layers = len(strides)

    def scale(k):
        return (least + greatest) / 2 if layers == 1 else least + (greatest - least) * k / (layers - 1)
    anchors, first = [], 0
    while first < layers:
        end = first
        while end < layers and strides[end] == strides[first]:
            end += 1
        cells = -(-192 // strides[first])
        for y in range(cells):
            for x in range(cells):
                for k in range(first, end):
                    for s in (scale(k), scale(k + 1)):
                        anchors.append(((x + offset[0]) / cells, (y + offset[1]) / cells, s))
        first = end
    return np.array(anchors, f4)


def palms(boxes, scores, anchors, size, threshold=0.5):
    width, height = size
    found = []
    for b, s, (ax, ay, scale) in zip(boxes, scores.reshape(-1), anchors):
        probability = 1 / (1 + np.exp(-s.clip(-100, 100)))
        if probability >= f4(threshold):
            yc, xc = b[0] / f4(height) * scale + ay, b[1] / f4(width) * scale + ax
            h, w = b[2] / f4(height) * scale, b[3] / f4(width) * scale
            found.append((max(0, whole((xc - w / 2) * width)), max(0, whole((yc - h / 2) * height)), whole(w * width),
                          whole(h * height), 0, probability, 0))
    return suppress(found, 0.05)


class Tracker:
    def __init__(self):
        self.known, self.last = {}, 0  # number -> [x, y, missing]

    def follow(self, boxes):
        centres = [(x + w / 2, y + h / 2) for x, y, w, h, *_ in boxes]
        numbers = [0] * len(boxes)
        pairs = sorted(((x - cx) ** 2 + (y - cy) ** 2, number, i) for number, (x, y, _) in self.known.items()
                       for i, (cx, cy) in enumerate(centres))
        matched = set()
        for _, number, i in pairs:
            if number not in matched and not numbers[i]:
                numbers[i] = number
                matched.add(number)
        for number in list(self.known):
            self.known[number][2] = 0 if number in matched else self.known[number][2] + 1
            if self.known[number][2] >= 100:
                del self.known[number]
        for i, centre in enumerate(centres):
            if not numbers[i] and len(self.known) < 100:
                self.last += 1
                numbers[i] = self.last
                self.known[self.last] = [*centre, 0]
        return numbers


def draw(boxes, output, size, labels=None, numbers=None):
    """The frame on which the boxes and their labels are."""
    (ow, oh), (iw, ih) = output, size
    frame = Frame(output)
    for i, (x, y, w, h, c, _, angle) in enumerate(boxes):
        if labels and not 0 <= c < len(labels):
            continue
        if angle:
            cos, sin = np.cos(float(angle)), np.sin(float(angle))
            corners = [(whole((x + dx * cos - dy * sin) * ow / iw), whole((y + dx * sin + dy * cos) * oh / ih))
                       for dx, dy in ((-w / 2, -h / 2), (w / 2, -h / 2), (w / 2, h / 2), (-w / 2, h / 2))]
            for start, end in zip(corners, corners[1:] + corners[:1]):
                frame.line(*start, *end, RED)
            continue
        x1, x2 = whole(ow * x / iw), min(ow - 1, whole(ow * (x + w) / iw))
        y1, y2 = whole(oh * y / ih), min(oh - 1, whole(oh * (y + h) / ih))
        frame.outline(x1, y1, x2, y2, RED)
        if labels:
            frame.text(x1, max(0, y1 - RISE), labels[c] + (f"-{numbers[i]}" if numbers else ""))
    return frame
