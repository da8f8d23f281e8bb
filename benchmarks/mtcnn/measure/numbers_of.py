# SPDX-License-Identifier: LGPL-2.1-or-later
"""The statistics of the figures, computed from lists of times and samples."""

import math
import statistics


def middle(values):
    """Returns (median, minimum, maximum) of the rounds."""
    return statistics.median(values), min(values), max(values)


def percentile(values, share):
    """The smallest value that `share` of the values do not exceed (nearest rank)."""
    if not values:
        raise ValueError("a percentile of nothing")
    if not 0 < share <= 1:
        raise ValueError(f"a share of {share}, not above 0 and up to 1")
    ordered = sorted(values)
    return ordered[max(math.ceil(share * len(ordered) - 1e-9), 1) - 1]


def rate(times):
    """Events per second, from the first to the last."""
    if len(times) < 2 or max(times) <= min(times):
        raise ValueError(f"no rate of {len(times)} events")
    return (len(times) - 1) / (max(times) - min(times))


def jitter_ms(times, period):
    """The deviation in milliseconds of each distance between neighbours from `period` (seconds)."""
    return [abs(later - earlier - period) * 1e3 for earlier, later in zip(times, times[1:])]


def slope_per_minute(samples, warm_up):
    """Least squares over (seconds, value), from `warm_up` seconds after the first sample on."""
    later = [one for one in samples if one[0] - samples[0][0] >= warm_up]
    if len(later) < 3:
        raise ValueError(f"{len(later)} samples after {warm_up} s, three are needed")
    x = statistics.fmean(time for time, _ in later)
    y = statistics.fmean(value for _, value in later)
    return 60 * sum((t - x) * (v - y) for t, v in later) / sum((t - x) ** 2 for t, _ in later)


def of_floor(value, floor):
    """`value` as a percentage of the floor; None without a floor."""
    return 100 * value / floor if floor else None
