# SPDX-License-Identifier: LGPL-2.1-or-later
"""Simulates an event camera of 64x48 pixels that looks at the figure, and writes its events as frames or as an Event Stream file.

A pixel of an event camera reports an event when the logarithm of its brightness has changed by a threshold since its last event.
Event frames count the events of 1/30 s: 128 + 16 * (brighter - darker), limited to a byte.
"""

import numpy
import simulator

WIDTH, HEIGHT, RATE = 64, 48, 30
STEPS = 3  # pictures that are drawn for each frame
FOCAL, CENTRE_Z = 48.0, 1.1  # pixels; the height of the camera in metres
THRESHOLD, NOISE = 0.25, 0.002  # of the logarithm; false events for each pixel and frame
GAIN, REST = 16, 128


def coverage(joints):
    """How much of each pixel the figure covers: [times, HEIGHT, WIDTH], 0 to 1, with soft edges."""
    rows, columns = numpy.mgrid[0:HEIGHT, 0:WIDTH].astype(numpy.float32) + numpy.float32(0.5)
    depth = numpy.maximum(joints[..., 1], 0.5)
    x = (WIDTH / 2 + FOCAL * joints[..., 0] / depth).astype(numpy.float32)
    y = (HEIGHT / 2 - FOCAL * (joints[..., 2] - CENTRE_Z) / depth).astype(numpy.float32)
    covered = numpy.zeros((len(joints), HEIGHT, WIDTH), numpy.float32)
    for one, other, radius in simulator.LIMBS:
        i, j = simulator.JOINTS.index(one), simulator.JOINTS.index(other)
        ax, ay, dx, dy = (value[:, None, None] for value in (x[:, i], y[:, i], x[:, j] - x[:, i], y[:, j] - y[:, i]))
        length = numpy.maximum(dx * dx + dy * dy, 1e-6)
        along = numpy.clip(((columns - ax) * dx + (rows - ay) * dy) / length, 0, 1)
        away = numpy.hypot(columns - ax - along * dx, rows - ay - along * dy)
        thick = (FOCAL * radius / depth[:, i]).astype(numpy.float32)[:, None, None]
        numpy.maximum(covered, numpy.clip(thick - away + 0.5, 0, 1), out=covered)
    return covered


def counts(activity, seconds, rng):
    """Events of a clip: int16 arrays [steps, HEIGHT, WIDTH] of brighter and of darker events; RATE * STEPS steps a second."""
    steps = int(round(seconds * RATE * STEPS))
    joints = simulator.figure(activity, numpy.arange(steps + 1) / (RATE * STEPS), rng)
    background = numpy.log(rng.uniform(0.25, 0.6) + rng.uniform(0, 0.25, (HEIGHT, WIDTH))).astype(numpy.float32)
    person = numpy.log(rng.choice([rng.uniform(0.05, 0.15), rng.uniform(0.95, 1.4)]))
    covered = numpy.zeros((1, HEIGHT, WIDTH), numpy.float32) if joints is None else coverage(joints)
    threshold = (THRESHOLD * rng.normal(1, 0.08, (HEIGHT, WIDTH))).astype(numpy.float32)
    reference = background + covered[0] * (person - background)
    brighter, darker = rng.poisson(NOISE / STEPS / 2, (2, steps, HEIGHT, WIDTH)).astype(numpy.int16)
    for step in range(steps if joints is not None else 0):
        change = numpy.trunc((background + covered[step + 1] * (person - background) - reference) / threshold)
        reference += change * threshold
        brighter[step] += numpy.maximum(change, 0).astype(numpy.int16)
        darker[step] += numpy.maximum(-change, 0).astype(numpy.int16)
    return brighter, darker


def make_frames(brighter, darker):
    """Event frames: uint8 [frames, HEIGHT, WIDTH]."""
    balance = (brighter - darker).reshape(-1, STEPS, HEIGHT, WIDTH).sum(axis=1)
    return numpy.clip(REST + GAIN * balance, 0, 255).astype(numpy.uint8)


def clip(activity, rng, seconds=simulator.CLIP_SECONDS):
    return make_frames(*counts(activity, seconds, rng))


def make_events(brighter, darker, rng):
    """Single events in the order of their times: arrays of microseconds, x, y, and whether it became brighter."""
    parts = []
    for kind, of_kind in ((True, brighter), (False, darker)):
        step, y, x = numpy.nonzero(of_kind)
        number = of_kind[step, y, x]
        step, y, x = (numpy.repeat(values, number) for values in (step, y, x))
        # In whole microseconds, and not before the step begins or after it ends.
        period = 1e6 / (RATE * STEPS)
        times = numpy.maximum(numpy.floor((step + rng.uniform(0, 1, len(step))) * period), numpy.ceil(step * period)).astype(numpy.int64)
        parts.append((times, x, y, numpy.full(len(x), kind)))
    columns = [numpy.concatenate(column) for column in zip(*parts)]
    order = numpy.argsort(columns[0], kind="stable")
    return [column[order] for column in columns]


def event_stream(times, x, y, brighter, width=WIDTH, height=HEIGHT):
    """The bytes of an Event Stream file, version 2.0, of DVS events (github.com/neuromorphic-paris/event_stream)."""
    out = bytearray(b"Event Stream" + bytes([2, 0, 0, 1]) + width.to_bytes(2, "little") + height.to_bytes(2, "little"))
    last = 0
    for time, column, row, on in zip(times.tolist(), x.tolist(), y.tolist(), brighter.tolist()):
        waits, rest = divmod(time - last, 127)
        last = time
        out += b"\xff" * waits  # each 127 microseconds
        out += bytes([rest << 1 | on]) + column.to_bytes(2, "little") + row.to_bytes(2, "little")
    return bytes(out)
