#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""The control: variants A, B, C and BC of the example in Python and NumPy, with threads and queues instead of a pipeline.

control.py --modules FOLDER --networks FOLDER [--live] [--workers N] VARIANT RECORDING

Each stage is a thread, with a queue of 16 items to the next one. The networks are the same files, run by the same engines. Prints an
activity for each result, with a zero byte after it. --live reads the recording at the rate of the sensors. --workers opens the large network
of a variant N times, for N threads.
"""

import argparse
import collections
import concurrent.futures
import pathlib
import queue
import sys
import threading
import time

import numpy
import weir

ACTIVITIES = ("empty room", "walking", "falling", "waving", "sitting down")
EVENT_RATE, RADIO_RATE = 30, 25
END = object()


def get_items(source):
    """The items of a queue until its end."""
    while (item := source.get()) is not END:
        yield item


class Stages:
    """Threads that are connected by queues; an exception in one of them ends the program."""

    def __init__(self):
        self.threads, self.error = [], None

    def add(self, work, *inputs):
        """A thread of `work`, a generator function of iterators over the queues `inputs`; returns the queue of what it yields."""
        output = queue.Queue(16)

        def run():
            sources = [get_items(one) for one in inputs]
            try:
                for item in work(*sources):
                    output.put(item)
            except Exception as error:  # reported by run_all
                self.error = error
            output.put(END)
            for source in sources:  # of streams of other lengths, or after an error: the stages before must not wait
                collections.deque(source, maxlen=0)

        self.threads.append(threading.Thread(target=run))
        return output

    def run_all(self, last):
        for thread in self.threads:
            thread.start()
        for item in get_items(last):
            sys.stdout.buffer.write(item.encode() + b"\0")
            sys.stdout.buffer.flush()
        for thread in self.threads:
            thread.join()
        if self.error:
            sys.exit(f"control: {self.error}")


def read_frames(path, dtype, shape, rate):
    """Whole frames of a file, one at a time; at `rate` frames a second unless it is 0."""
    size = int(numpy.prod(shape)) * numpy.dtype(dtype).itemsize
    begin = time.monotonic()
    with open(path, "rb") as file:
        number = 0
        while len(data := file.read(size)) == size:
            if rate:
                time.sleep(max(0, begin + number / rate - time.monotonic()))
            number += 1
            yield numpy.frombuffer(data, dtype).reshape(shape)


def windows(items, length, step):
    """Arrays of `length` items, each `step` items after the one before."""
    kept, skipped = collections.deque(maxlen=length), length
    for item in items:
        kept.append(item)
        skipped -= 1
        if skipped == 0:
            yield numpy.stack(kept)
            skipped = step


def normalised(stacks):
    for stack in stacks:
        yield (stack.astype(numpy.float32) - 128) * 0.0625


def standardised(stacks):
    for stack in stacks:
        yield (numpy.abs(stack - stack.mean(dtype=numpy.float64)) / stack.std(dtype=numpy.float64)).astype(numpy.float32)


def infer(model):
    def work(arrays):
        for array in arrays:
            yield model.invoke(array)[0].reshape(-1)
    return work


def infer_at_once(models):
    """Each model works on an array of its own; the results keep the order of the arrays."""
    free = queue.SimpleQueue()
    for model in models:
        free.put(model)

    def invoke(array):
        model = free.get()
        try:
            return model.invoke(array)[0].reshape(-1)
        finally:
            free.put(model)

    def work(arrays):
        with concurrent.futures.ThreadPoolExecutor(len(models)) as threads:
            pending = collections.deque()
            for array in arrays:
                pending.append(threads.submit(invoke, array))
                if len(pending) > 2 * len(models):
                    yield pending.popleft().result()
            for one in pending:
                yield one.result()
    return work


def infer_with(options, open_model):
    return infer(open_model()) if options.workers == 1 else infer_at_once([open_model() for _ in range(options.workers)])


def names(results):
    for result in results:
        yield ACTIVITIES[int(result.argmax())]


def event_results(stages, options):
    rate = EVENT_RATE if options.live else 0
    frames = stages.add(lambda: read_frames(options.recording / "events.frames", numpy.uint8, (48, 64), rate))
    stacks = stages.add(lambda items: normalised(windows(items, 8, 4)), frames)
    return stages.add(infer_with(options, lambda: weir.Model(options.modules / "libars-event-network.so", engine="custom",
                                                             options={"weights": str(options.networks / "event_network.f32")})), stacks)


def sequence_results(stages, options, then=iter):
    """`then` is what the last thread does with the results."""
    results = event_results(stages, options)
    model = weir.Model(options.modules / "libars-sequence-network.so", engine="custom",
                       options={"weights": str(options.networks / "sequence_network.f16")})
    return stages.add(lambda items: then(infer(model)(windows(items, 12, 3))), results)


def radio_results(stages, options, then=iter):
    rate = RADIO_RATE if options.live else 0

    def reader(number):
        return lambda: read_frames(options.recording / f"radio{number}.frames", numpy.float32, (32,), rate)

    stacks = [stages.add(lambda items: standardised(windows(items, 75, 25)), stages.add(reader(number))) for number in (0, 1)]
    pairs = stages.add(lambda one, other: (numpy.stack(pair)[None] for pair in zip(one, other)), *stacks)
    work = infer_with(options, lambda: weir.Model(options.networks / "radio_network.onnx", engine="onnxruntime", threads=1))
    return stages.add(lambda items: then(work(items)), pairs)


def with_nearest(slow, fast, slow_step, fast_step):
    """Each item of `slow` with the item of `fast` whose time is nearest, until one of them ends; the steps are the times between items."""
    number, before, item = 0, None, next(fast, END)
    for time, of_slow in enumerate(slow):
        while item is not END and number * fast_step < time * slow_step:
            before, item, number = item, next(fast, END), number + 1
        if item is END:
            return
        over = number * fast_step - time * slow_step
        yield of_slow, before if before is not None and over > fast_step - over else item


def variant_a(stages, options):
    results = event_results(stages, options)
    return stages.add(lambda items: names(window.mean(axis=0) for window in windows(items, 6, 1)), results)


def variant_b(stages, options):
    return sequence_results(stages, options, names)


def variant_c(stages, options):
    return radio_results(stages, options, names)


def variant_bc(stages, options):
    """The mean of both results, for each result of the radios; times in milliseconds."""
    return stages.add(lambda radios, events: names((one + other) / 2 for one, other in with_nearest(radios, events, 1000, 400)),
                      radio_results(stages, options), sequence_results(stages, options))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("variant", choices=("a", "b", "c", "bc"))
    parser.add_argument("recording", type=pathlib.Path)
    parser.add_argument("--modules", type=pathlib.Path, required=True, help="folder of the networks' libraries")
    parser.add_argument("--networks", type=pathlib.Path, required=True, help="folder of the networks' weights")
    parser.add_argument("--live", action="store_true")
    parser.add_argument("--workers", type=int, default=1)
    options = parser.parse_args()
    stages = Stages()
    stages.run_all({"a": variant_a, "b": variant_b, "c": variant_c, "bc": variant_bc}[options.variant](stages, options))


if __name__ == "__main__":
    main()
