# SPDX-License-Identifier: LGPL-2.1-or-later
"""Compares two results of the same clip in JSON Lines: boxes frame by frame, and what was counted."""

import statistics


def overlap(a, b):
    """Intersection over union of two boxes x1, y1, x2, y2."""
    width, height = min(a[2], b[2]) - max(a[0], b[0]), min(a[3], b[3]) - max(a[1], b[1])
    if width <= 0 or height <= 0:
        return 0.0
    areas = sum((box[2] - box[0]) * (box[3] - box[1]) for box in (a, b))
    return width * height / (areas - width * height)


def pairs(ours, theirs, least=0.5):
    """Overlaps of the boxes of one frame that are matched, the best pair first, and how many of both lists are left."""
    scored = sorted(((overlap(a, b), i, j) for i, a in enumerate(ours) for j, b in enumerate(theirs)), reverse=True)
    found, used = [], (set(), set())
    for value, i, j in scored:
        if value >= least and i not in used[0] and j not in used[1]:
            found.append(value)
            used[0].add(i)
            used[1].add(j)
    return found, len(ours) + len(theirs) - 2 * len(found)


def compare_boxes(ours, theirs):
    """Of the objects of all frames."""
    if len(ours) != len(theirs):
        raise ValueError(f"{len(ours)} frames against {len(theirs)}: every frame must go through both")
    matched, alone = [], 0
    for a, b in zip(ours, theirs):
        if abs(a["time"] - b["time"]) > 0.001:
            raise ValueError(f"frames of different times: {a['time']} s against {b['time']} s")
        found, left = pairs(*([one["box"] for one in frame["detections"]] for frame in (a, b)))
        matched += found
        alone += left
    if not matched:
        raise ValueError("no boxes match")
    return {"matched": len(matched), "unmatched": alone, "median": statistics.median(matched), "least": min(matched),
            "share of 0.9": sum(value >= 0.9 for value in matched) / len(matched)}


def inside(frame):
    """How many objects are in each area."""
    return {zone["name"]: zone["inside"] for zone in frame["zones"] if "inside" in zone}


def crossings(frame):
    """How many objects have crossed each line until this frame: forward, backward."""
    return {zone["name"]: (zone["forward"], zone["backward"]) for zone in frame["zones"] if "forward" in zone}


def equal_counts(ours, theirs):
    """The share of frames in which all areas have as many objects in both."""
    return sum(inside(a) == inside(b) for a, b in zip(ours, theirs, strict=True)) / len(ours)
