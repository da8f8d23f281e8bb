# SPDX-License-Identifier: LGPL-2.1-or-later
"""Scores of trackers from their published definitions, in NumPy, for whole sequences. It shares nothing with src/core/evaluate.

CLEAR MOT: K. Bernardin, R. Stiefelhagen, "Evaluating multiple object tracking performance", 2008.
IDF1: E. Ristani et al., "Performance measures and a data set for multi-target, multi-camera tracking", 2016.
HOTA: J. Luiten et al., "HOTA: A higher order metric for evaluating multi-object tracking", 2020.

A sequence is a list of (truth, found), each a dict of a track's number to its box x1, y1, x2, y2.
"""

import numpy

THRESHOLDS = numpy.arange(1, 20) * 0.05


def overlaps(truth, found):
    """Intersection over union of each box of the truth with each found one."""
    a = numpy.array(list(truth.values()), float).reshape(-1, 1, 4)
    b = numpy.array(list(found.values()), float).reshape(1, -1, 4)
    sides = numpy.minimum(a[..., 2:], b[..., 2:]) - numpy.maximum(a[..., :2], b[..., :2])
    common = numpy.clip(sides, 0, None).prod(-1)
    return common / ((a[..., 2:] - a[..., :2]).prod(-1) + (b[..., 2:] - b[..., :2]).prod(-1) - common)


def parts_of(values):
    """Rows and columns that are connected by values above 0, apart."""
    rows_left = set(range(values.shape[0]))
    while rows_left:
        rows, columns, edge = set(), set(), {min(rows_left)}
        while edge:
            rows |= edge
            columns |= {int(c) for r in edge for c in numpy.flatnonzero(values[r] > 0)}
            edge = {int(r) for c in columns for r in numpy.flatnonzero(values[:, c] > 0)} - rows
        rows_left -= rows
        if columns:
            yield sorted(rows), sorted(columns)


def best_pairs(values):
    """The pairs (row, column) with the greatest sum of values above 0: dynamic programming over the sets of rows in use."""
    out = []
    for rows, columns in parts_of(values):
        part = values[numpy.ix_(rows, columns)]
        is_turned = part.shape[0] > part.shape[1]
        part = part.T if is_turned else part
        pairs = best_of_part(part)
        out += [(rows[c], columns[r]) if is_turned else (rows[r], columns[c]) for r, c in pairs]
    return out


def best_of_part(part):
    count = part.shape[0]
    assert count <= 18, "too many tracks that compete for this method"
    sets = numpy.arange(1 << count)
    best, steps = numpy.zeros(1 << count), []
    for column in part.T:
        chosen, after = numpy.full(1 << count, -1), best.copy()
        for row in numpy.flatnonzero(column > 0):
            with_row = sets[(sets >> row) & 1 == 1]
            value = best[with_row ^ (1 << row)] + column[row]
            better = value > after[with_row]
            after[with_row[better]] = value[better]
            chosen[with_row[better]] = row
        best = after
        steps.append(chosen)
    pairs, used = [], (1 << count) - 1
    for column in range(len(steps) - 1, -1, -1):
        row = steps[column][used]
        if row >= 0:
            pairs.append((int(row), column))
            used ^= 1 << int(row)
    return pairs


def clear_mot(sequence):
    """Misses, false boxes, switches, boxes of the truth. A pair of the frame before stays while its overlap is at least 0.5."""
    last, previous = {}, {}
    missed = false = switches = boxes = 0
    for truth, found in sequence:
        values = overlaps(truth, found)
        values[values < 0.5] = 0
        truths, founds = list(truth), list(found)
        pairs = {}
        for t, a in enumerate(truths):
            if previous.get(a) in found and values[t, founds.index(previous[a])] > 0:
                f = founds.index(previous[a])
                pairs[a] = previous[a]
                values[t, :] = values[:, f] = 0
        for t, f in best_pairs(values):
            pairs[truths[t]] = founds[f]
        switches += sum(a in last and last[a] != b for a, b in pairs.items())
        last.update(pairs)
        previous = pairs
        boxes += len(truth)
        missed += len(truth) - len(pairs)
        false += len(found) - len(pairs)
    return numpy.array([missed, false, switches, boxes])


def lengths_of(sequence, side):
    out = {}
    for frame in sequence:
        for track in frame[side]:
            out[track] = out.get(track, 0) + 1
    return out


def identity(sequence):
    """Frames in common of the best pairing of whole tracks, and the boxes of both sides."""
    truths, founds = lengths_of(sequence, 0), lengths_of(sequence, 1)
    row, column = {a: i for i, a in enumerate(truths)}, {b: i for i, b in enumerate(founds)}
    common = numpy.zeros((len(row), len(column)))
    for truth, found in sequence:
        for t, f in zip(*numpy.nonzero(overlaps(truth, found) >= 0.5)):
            common[row[list(truth)[t]], column[list(found)[f]]] += 1
    return numpy.array([sum(common[pair] for pair in most_common(common)), sum(truths.values()), sum(founds.values())])


def most_common(common):
    """The best pairing of many tracks: Bertsekas' auction (1979), in whole numbers, so that the result is exact.

    Each track of the truth has a column of its own of value 0, for none. With bids of less than 1 / rows it ends at the optimum.
    """
    rows, real = common.shape
    values = numpy.hstack([common, numpy.where(numpy.eye(rows) > 0, 0.0, -1e6)]) * (rows + 1)
    prices, owner, column_of = numpy.zeros(real + rows), {}, {}
    waiting = list(range(rows))
    while waiting:
        row = waiting.pop()
        gains = values[row] - prices
        best = int(gains.argmax())
        others = numpy.delete(gains, best)
        prices[best] += gains[best] - (others.max() if len(others) else gains[best]) + 1
        if best in owner:
            waiting.append(owner[best])
            del column_of[owner[best]]
        owner[best], column_of[row] = row, best
    return [(r, c) for r, c in column_of.items() if c < real]


def hota(sequence):
    """For each threshold: matches, missed, false boxes, and the sum of the association of the matches."""
    lengths = lengths_of(sequence, 0), lengths_of(sequence, 1)
    agreement = {}
    for truth, found in sequence:
        values = overlaps(truth, found)
        both = values.sum(0, keepdims=True) + values.sum(1, keepdims=True) - values
        for t, f in zip(*numpy.nonzero(values)):
            pair = list(truth)[t], list(found)[f]
            agreement[pair] = agreement.get(pair, 0) + values[t, f] / both[t, f]
    agreement = {(a, b): v / (lengths[0][a] + lengths[1][b] - v) for (a, b), v in agreement.items()}
    counts, pairs_of = numpy.zeros((4, len(THRESHOLDS))), {}
    for truth, found in sequence:
        truths, founds = list(truth), list(found)
        values = overlaps(truth, found)
        weights = numpy.array([[agreement.get((a, b), 0) for b in founds] for a in truths]).reshape(values.shape) * values
        matched = numpy.zeros(len(THRESHOLDS))
        for t, f in best_pairs(weights):
            is_match = values[t, f] >= THRESHOLDS - 1e-12
            matched += is_match
            pair = truths[t], founds[f]
            pairs_of[pair] = pairs_of.get(pair, 0) + is_match
        counts[:3] += [matched, len(truths) - matched, len(founds) - matched]
    for (a, b), number in pairs_of.items():
        counts[3] += number * number / (lengths[0][a] + lengths[1][b] - number)
    return counts


def scores(sequences):
    """MOTA, IDF1, HOTA and switches of several sequences together: their counts are added up."""
    missed, false, switches, boxes = sum(clear_mot(s) for s in sequences)
    common, truths, founds = sum(identity(s) for s in sequences)
    matched, misses, falses, association = sum(hota(s) for s in sequences)
    detection = matched / (matched + misses + falses)
    return {"MOTA": 1 - (missed + false + switches) / boxes, "IDF1": 2 * common / (truths + founds),
            "HOTA": float(numpy.mean(numpy.sqrt(detection * association / numpy.maximum(matched, 1)))), "switches": int(switches)}
