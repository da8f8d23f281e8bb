# SPDX-License-Identifier: LGPL-2.1-or-later
"""Metrics of results against truth, written from their published definitions in NumPy, for the tests of weir evaluate.

They share nothing with the C++ code: each goes through the data in the most direct way, however slow.
Boxes are x, y, width, height.
"""

import itertools

import numpy

THRESHOLDS = numpy.linspace(0.5, 0.95, 10)
RECALLS = numpy.linspace(0, 1, 101)


def iou(a, b):
    width = min(a[0] + a[2], b[0] + b[2]) - max(a[0], b[0])
    height = min(a[1] + a[3], b[1] + b[3]) - max(a[1], b[1])
    common = max(width, 0) * max(height, 0)
    union = a[2] * a[3] + b[2] * b[3] - common
    return common / union if union > 0 else 0.0


def similarity(truth, box):
    if not truth["crowd"]:
        return iou(truth["box"], box)
    a = truth["box"]
    width = min(a[0] + a[2], box[0] + box[2]) - max(a[0], box[0])
    height = min(a[1] + a[3], box[1] + box[3]) - max(a[1], box[1])
    return max(width, 0) * max(height, 0) / (box[2] * box[3]) if box[2] * box[3] > 0 else 0.0


def matched(truths, founds, threshold, low, high):
    """For each found box, by falling score: 1 right, 0 false, None not counted. And the number of boxes to find."""
    ignored = [t["crowd"] or not low <= t["area"] <= high for t in truths]
    used = [False] * len(truths)
    marks = []
    for score, box in founds:
        options = [(similarity(t, box), -i) for i, t in enumerate(truths)
                   if not ignored[i] and not used[i] and similarity(t, box) >= threshold]
        if options:
            used[-max(options)[1]] = True
            marks.append((score, 1))
            continue
        extra = [(similarity(t, box), i) for i, t in enumerate(truths)
                 if ignored[i] and (t["crowd"] or not used[i]) and similarity(t, box) >= threshold]
        if extra:
            used[max(extra)[1]] = True
            marks.append((score, None))
        else:
            marks.append((score, 0 if low <= box[2] * box[3] <= high else None))
    return marks, ignored.count(False)


def curve(pictures, category, threshold, low=0, high=1e10, most=100):
    """Precision at 101 recalls, and the greatest recall; None where nothing is to find."""
    marks, positives = [], 0
    for truths, founds in pictures:
        of_category = sorted(((s, b) for c, s, b in founds if c == category), key=lambda f: -f[0])[:most]
        some, count = matched([t for t in truths if t["category"] == category], of_category, threshold, low, high)
        marks += some
        positives += count
    if positives == 0:
        return None
    marks = [m for m in sorted(marks, key=lambda m: -m[0]) if m[1] is not None]
    right = numpy.cumsum([m[1] for m in marks]) if marks else numpy.zeros(0)
    recall, precision = right / positives, right / numpy.arange(1, len(right) + 1)
    at = [max(precision[recall >= r], default=0.0) for r in RECALLS]
    return numpy.array(at), (recall[-1] if len(recall) else 0.0)


def average_precision(pictures, categories, thresholds=THRESHOLDS, **how):
    curves = [curve(pictures, c, t, **how) for c in range(categories) for t in thresholds]
    curves = [c for c in curves if c is not None]
    return (numpy.mean([c[0].mean() for c in curves]), numpy.mean([c[1] for c in curves])) if curves else (None, None)


def assignments(rows, columns):
    """All ways to pair some rows with some columns."""
    for choice in itertools.product([None, *range(columns)], repeat=rows):
        used = [c for c in choice if c is not None]
        if len(used) == len(set(used)):
            yield choice


def mota(sequence):
    """sequence: (truth, found) of each frame, dicts of track: box. Returns MOTA and the switches."""
    last, previous = {}, {}
    misses = false = switches = boxes = 0
    for truth, found in sequence:
        ids, others = list(truth), list(found)
        best, best_value = (None,) * len(ids), (-1, -1.0)
        for choice in assignments(len(ids), len(others)):
            pairs = [(t, others[c]) for t, c in zip(ids, choice) if c is not None]
            if any(iou(truth[t], found[f]) < 0.5 for t, f in pairs):
                continue
            value = (sum(previous.get(t) == f for t, f in pairs), sum(iou(truth[t], found[f]) for t, f in pairs))
            if value > best_value:
                best, best_value = choice, value
        previous = {t: others[c] for t, c in zip(ids, best) if c is not None}
        switches += sum(t in last and last[t] != f for t, f in previous.items())
        last.update(previous)
        boxes += len(ids)
        misses += len(ids) - len(previous)
        false += len(others) - len(previous)
    return 1 - (misses + false + switches) / boxes, switches


def get_tracks(sequence, side):
    return sorted({track for frame in sequence for track in frame[side]})


def idf1(sequence):
    truths, founds = get_tracks(sequence, 0), get_tracks(sequence, 1)
    common = [[sum(iou(t[a], f[b]) >= 0.5 for t, f in sequence if a in t and b in f) for b in founds] for a in truths]
    right = max(sum(common[r][c] for r, c in enumerate(choice) if c is not None)
                for choice in assignments(len(truths), len(founds)))
    return 2 * right / (sum(len(t) for t, _ in sequence) + sum(len(f) for _, f in sequence))


def hota(sequence):
    truths, founds = get_tracks(sequence, 0), get_tracks(sequence, 1)
    lengths = [{track: sum(track in frame[side] for frame in sequence) for track in tracks}
               for side, tracks in ((0, truths), (1, founds))]
    agreement = {(a, b): 0.0 for a in truths for b in founds}
    for truth, found in sequence:
        for a, b in itertools.product(truth, found):
            value = iou(truth[a], found[b])
            both = sum(iou(truth[a], box) for box in found.values()) + sum(iou(box, found[b]) for box in truth.values())
            if both - value > 1e-15:
                agreement[a, b] += value / (both - value)
    agreement = {(a, b): v / (lengths[0][a] + lengths[1][b] - v) for (a, b), v in agreement.items()}
    matches = []
    for truth, found in sequence:
        ids, others = list(truth), list(found)
        value = lambda choice: sum(agreement[ids[r], others[c]] * iou(truth[ids[r]], found[others[c]])  # noqa: E731
                                   for r, c in enumerate(choice) if c is not None)
        best = max(assignments(len(ids), len(others)), key=value)
        matches += [(ids[r], others[c], iou(truth[ids[r]], found[others[c]])) for r, c in enumerate(best) if c is not None]
    boxes = [sum(len(frame[side]) for frame in sequence) for side in (0, 1)]
    scores = []
    for alpha in numpy.arange(0.05, 0.99, 0.05):
        kept = [(a, b) for a, b, overlap in matches if overlap >= alpha - 1e-12]
        association = sum(kept.count(pair) / (lengths[0][pair[0]] + lengths[1][pair[1]] - kept.count(pair)) for pair in kept)
        detection = len(kept) / (sum(boxes) - len(kept))
        scores.append((detection * association / len(kept)) ** 0.5 if kept else 0.0)
    return numpy.mean(scores)
