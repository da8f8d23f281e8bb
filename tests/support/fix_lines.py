# SPDX-License-Identifier: LGPL-2.1-or-later
"""Pastes the fix of an error into the pipeline that has it, as a user does."""

import os
import re
import subprocess

SECONDS = 60
# Elements that read video: a fix that begins with one of them takes the place of what makes tensors of the video.
READERS_OF_VIDEO = ("videoconvert", "videoscale", "tensor_preprocess")
MAKERS_OF_TENSORS = ("tensor_converter", "tensor_preprocess")


def factory(element):
    return element.split()[0] if element.split() else ""


def with_properties(element, other):
    """The element with the properties of the other one, which has the same factory. The begin of another branch may follow it."""
    words = element.split()
    end = next((i for i, word in enumerate(words[1:], 1) if "=" not in word), len(words))
    properties = dict(word.split("=", 1) for word in words[1:end])
    properties.update(word.split("=", 1) for word in other.split()[1:])
    return " ".join([words[0], *(f"{name}={value}" for name, value in properties.items()), *words[end:]])


def pasted(line, failing, fix):
    """The pipeline with the fix of an error of its element `failing`, a name of a factory.

    A fix that begins as the pipeline does is all of it. Otherwise the elements of the fix come before the failing element, whose
    properties may be part of it: as the last element, or as the first one, if others are to follow it.
    """
    if fix.split(" ! ")[0] == line.split(" ! ")[0]:
        return fix
    elements, parts = line.split(" ! "), fix.split(" ! ")
    if factory(parts[-1]) in map(factory, elements):
        failing = factory(parts[-1])
    at = next(i for i, element in enumerate(elements) if factory(element) == failing)
    before, after = parts, []
    if factory(parts[-1]) == failing:
        before, elements[at] = parts[:-1], with_properties(elements[at], parts[-1])
    elif factory(parts[0]) == failing:
        before, after, elements[at] = [], parts[1:], with_properties(elements[at], parts[0])
    begin = at
    if before and factory(before[0]) in READERS_OF_VIDEO:
        begin = min((i for i, element in enumerate(elements[:at]) if factory(element) in MAKERS_OF_TENSORS), default=at)
    return " ! ".join(elements[:begin] + before + [elements[at]] + after + elements[at + 1:])


def run(line, environment=None):
    return subprocess.run([os.environ["WEIR_COMMAND"], "run", line], timeout=SECONDS, capture_output=True, text=True,
                          stdin=subprocess.DEVNULL, check=False, env={**os.environ, **(environment or {})})


def failing_factory(text):
    """The factory of the element that posted the error, by the name that GStreamer gave it."""
    name = re.search(r"error from (\w+?)\d*: WEIR-", text)
    found = name and name[1].removeprefix("weirtensor")
    return name and f"tensor_{found}" if found and name[1].startswith("weirtensor") else name and name[1]


def mended(test, line, limit=3):
    """Pastes fixes until the pipeline runs, and returns it. At most `limit` fixes are needed."""
    shown = []
    for _ in range(limit + 1):
        done = run(line)
        shown.append(f"{line}\n{done.stdout}{done.stderr}")
        if done.returncode == 0:
            break
        text = done.stdout + done.stderr
        fix = re.search(r"^  fix: (.*)$", text, re.MULTILINE)
        test.assertTrue(fix, "there is no fix:\n" + "\n".join(shown))
        line = pasted(line, failing_factory(text), fix[1])
    test.assertEqual(done.returncode, 0, "\n".join(shown))
    test.assertGreater(len(shown), 1, "the pipeline had no error")
    return line
