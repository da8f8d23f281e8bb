# SPDX-License-Identifier: LGPL-2.1-or-later
"""The measurements: what to run, and the numbers it gives. A number's name is its row in the table."""

import json
import pathlib
import statistics

import numbers_of as numbers
from processes import watch

ROOT = pathlib.Path(__file__).resolve().parents[3]
STAGES = ("pyramid and P-Net", "regions and R-Net", "regions and O-Net")
WEIR = {"weir": ["--framework", "onnxruntime", "--custom", "NumThreads:1"], "kernels": ["--framework", "mtcnn-kernels"]}  # both engines
FLOORS = {"onnxruntime": "floor", "mtcnn-kernels": "kernels-floor"}  # per engine
DECODES = {name: name + ", floor and decoding" for name in ("pictures per second", "CPU ms per picture")}  # rows also compared with a floor that decodes
LIVE_RATE = 30  # pictures per second of the camera
SETTLE = 1.0  # seconds at the start of a live run that are ignored
MAPPED, RSS, THREADS = "mapped memory, MB", "peak RSS, MB", "threads"


class Programs:
    """The commands of the compared programs: weir, kernels, control, and ros if it is built."""

    def __init__(self, build, min_face, folder):
        self.options, self.folder = ["--build", build, "--min-face", str(min_face)], pathlib.Path(folder)
        self.report = self.folder / "report.json"

    def run(self, who, *arguments):
        """Returns Watched."""
        return watch([ROOT / ("examples" if who in WEIR else "benchmarks") / "mtcnn/run", *self.options, *WEIR.get(who, [f"--{who}"]), *arguments])

    def watched(self, who, clip, *options):
        """Returns (Watched, the report of the times)."""
        self.report.unlink(missing_ok=True)
        seen = self.run(who, "--report", self.report, *options, clip)
        return seen, json.loads(self.report.read_text())

    def floor(self, engine, *arguments):
        """Returns (Watched, its output)."""
        seen = self.run(FLOORS[engine], *arguments)
        return seen, json.loads(seen.text)


def fast(programs, who, clip):
    """All pictures of the clip as fast as possible. The rate excludes the start."""
    seen, report = programs.watched(who, clip)
    done = [one[3] for one in report["pictures"]]
    out = {"pictures per second": numbers.rate(done), "CPU ms per picture": seen.cpu_seconds * 1e3 / len(done),
           "CPU share, cores": seen.cpu_seconds / seen.seconds, RSS: seen.peak_rss, MAPPED: seen.mapped,
           THREADS: seen.threads}
    if report["copied"] is not None:
        out["MB copied per picture"] = report["copied"] / len(done) / 1e6
    return out


def latency(programs, who, clip):
    """One picture per second: how long each takes, and where; the first one is cold."""
    _, report = programs.watched(who, clip, "--live")
    return {"pictures": [[(later - earlier) * 1e3 for earlier, later in zip(one, one[1:])] + [(one[3] - one[0]) * 1e3]
                         for one in report["pictures"][1:]]}


def of_latencies(rounds):
    """Returns rows for a program's rounds: medians of each round, and the slowest hundredth over all rounds.

    With fewer than a hundred pictures this is the slowest one, and its row is named so.
    """
    out = []
    for one in rounds:
        columns = list(zip(*one["pictures"]))
        out.append({"latency, ms": statistics.median(columns[3]),
                    **{f"{name}, ms": statistics.median(column) for name, column in zip(STAGES, columns)}})
    whole = [picture[3] for one in rounds for picture in one["pictures"]]
    name, share = ("p99", 0.99) if len(whole) >= 100 else ("slowest", 1)
    return out, {f"latency, {name}, ms": numbers.percentile(whole, share)}, len(whole)


def live(programs, who, clip, offered):
    """A camera with 30 pictures per second. Weir draws on each of them; the others only find faces."""
    _, report = programs.watched(who, clip, "--live", *(["--draw"] if who in WEIR else []))
    done = [one[3] for one in report["pictures"]]
    first = min(one[0] for one in report["pictures"])
    later = [time for time in done if time - first >= SETTLE]
    out = {"results per second at 30": numbers.rate(later),
           "pictures that the networks got, %": 100 * report["begun"] / offered}
    if who in WEIR:
        shown = [time for time in report["shown"] if time - report["shown"][0] >= SETTLE]
        out |= {"display: pictures per second": numbers.rate(shown),
                "display: pictures left out": offered - len(report["shown"]),
                "display: jitter, median, ms": numbers.percentile(numbers.jitter_ms(shown, 1 / LIVE_RATE), 0.5),
                "display: jitter, p99, ms": numbers.percentile(numbers.jitter_ms(shown, 1 / LIVE_RATE), 0.99)}
    return out


def memory(programs, who, clip, warm_up, seconds):
    """A live run of `seconds`: growth of resident memory, without start and end."""
    seen, _ = programs.watched(who, clip, "--live", *(["--draw"] if who in WEIR else []))
    samples = [(time, rss) for time, rss in seen.samples if time < seconds]
    later = [rss for time, rss in samples if time >= warm_up]
    return {"samples": [[round(time, 2), round(rss, 2)] for time, rss in samples],
            "RSS at 30, median, MB": statistics.median(later), "RSS at 30, peak, MB": seen.peak_rss,
            "RSS growth, MB per minute": numbers.slope_per_minute(samples, warm_up)}


def requests(programs, clip):
    """The control's requests to the networks for the clip, for floor()."""
    path = programs.folder / "requests"
    programs.run("control", "--requests", path, clip)
    return path


def floor(programs, engine, what, cores, clip):
    """The engine's time for the same invokes in a plain loop: on one thread, on all cores, and the latter with decoding."""
    seen, one = programs.floor(engine, what)
    _, all_cores = programs.floor(engine, "--threads", cores, "--clip", clip, what)
    decoding = {DECODES[name]: all_cores["decoding"][key] for name, key in (("pictures per second", "rate"), ("CPU ms per picture", "cpu_ms"))}
    return {**decoding, "pictures": one["pictures"], "pictures per second": all_cores["rate"], "results per second at 30": min(all_cores["rate"], LIVE_RATE),
            "CPU ms per picture": all_cores["cpu_ms"], "CPU share, cores": all_cores["cpu_ms"] * all_cores["rate"] / 1e3,
            RSS: seen.peak_rss, MAPPED: seen.mapped, THREADS: seen.threads, "RSS at 30, peak, MB": seen.peak_rss,
            "RSS at 30, median, MB": seen.peak_rss,
            "display: pictures per second": LIVE_RATE, "pictures that the networks got, %": 100 * min(all_cores["rate"] / LIVE_RATE, 1)}
