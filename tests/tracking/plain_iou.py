# SPDX-License-Identifier: LGPL-2.1-or-later
"""A plain tracker to compare with: the greatest overlap with a track's last box comes first, and nothing is predicted.

As E. Bochinski et al., "High-speed tracking-by-detection without using image information", 2017, with a gap of up to `age` frames.
"""

import numpy

import metrics


def follow(frames, high=0.5, least=0.2, age=30, hits=2):
    """frames: arrays of x1, y1, x2, y2, score. Returns for each a dict of number: box."""
    tracks, given, out = [], 0, []  # a track: box, number (0 = none yet), frames with a box, frame of the last one
    for now, rows in enumerate(frames):
        boxes = {i: row[:4] for i, row in enumerate(rows) if row[4] >= high}
        tracks = [track for track in tracks if now - track["seen"] <= (age if track["number"] else 1)]
        values = metrics.overlaps({i: track["box"] for i, track in enumerate(tracks)}, boxes)
        keys, used = list(boxes), set()
        for t, b in sorted(zip(*numpy.nonzero(values >= least)), key=lambda pair: -values[pair]):
            if tracks[t]["seen"] == now or keys[b] in used:
                continue
            used.add(keys[b])
            tracks[t].update(box=boxes[keys[b]], seen=now, hits=tracks[t]["hits"] + 1)
        tracks += [{"box": boxes[key], "number": 0, "hits": 1, "seen": now} for key in keys if key not in used]
        for track in tracks:
            if track["seen"] == now and track["number"] == 0 and track["hits"] >= hits:
                given += 1
                track["number"] = given
        out.append({track["number"]: track["box"] for track in tracks if track["seen"] == now and track["number"]})
    return out
