# SPDX-License-Identifier: LGPL-2.1-or-later
"""Simulates two ultra-wideband (UWB) radios in the room of the figure: the echoes of each pulse, by distance.

A radio sends a pulse 25 times a second and receives the channel response: 32 magnitudes, one for each 0.2 m of distance. The response is
the sum of the echoes of walls and furniture, of the joints of the person, and of noise; echoes have phases, so that a movement of
centimetres changes the sum.
"""

import numpy
import simulator

BINS, RATE = 32, 25
NEAREST, BIN, WAVELENGTH, PULSE = 0.8, 0.2, 0.075, 0.18  # metres; PULSE is the standard deviation of the pulse's envelope
PLACES = numpy.array([[-2.0, 0.0, 1.0], [2.0, 0.0, 1.0]])  # of the radios
WEIGHTS = numpy.array([1.0, 1.0, 0.6, 0.3, 0.25, 0.3, 0.25, 0.4, 0.25, 0.4, 0.25])  # the echo of each joint


def echoes(distance, weight):
    """The sum of the echoes from these distances: complex [..., BINS]."""
    bins = NEAREST + BIN * numpy.arange(BINS)
    envelope = numpy.exp(-0.5 * ((bins - distance[..., None]) / PULSE) ** 2)
    phase = numpy.exp(-4j * numpy.pi * distance / WAVELENGTH)
    return (envelope * (weight * phase / distance**2)[..., None]).sum(axis=-2)


def clip(activity, rng, seconds=simulator.CLIP_SECONDS):
    """Responses of both radios: float32 [2, frames, BINS]."""
    time = numpy.arange(int(round(seconds * RATE))) / RATE
    joints = simulator.figure(activity, time, rng)
    received = []
    for place in PLACES:
        walls = echoes(rng.uniform(1.0, 7.0, 6), rng.uniform(0.1, 1.2, 6))
        response = walls + 0.008 * (rng.normal(size=(len(time), BINS)) + 1j * rng.normal(size=(len(time), BINS)))
        if joints is not None:
            response = response + echoes(numpy.linalg.norm(joints - place, axis=-1), WEIGHTS)
        received.append(numpy.abs(response))
    return numpy.array(received, numpy.float32)
