#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Counts the test cases of Meson's last test run and prints `N passed, N failed`.

tools/count-tests.py BUILD STATUS, where STATUS is what `meson test` returned. GoogleTest and TAP programs
count by their cases, others as one. A program that failed though no case of it did (it crashed, it leaked, it ran
out of time) counts as one failure more.
"""

import json
import pathlib
import re
import sys
import xml.etree.ElementTree as ElementTree

GOOD = {"OK", "EXPECTEDFAIL"}


def read_programs(log):
    """The test programs that ran, as Meson judged them."""
    if not log.exists():
        return []
    return [json.loads(line) for line in log.read_text(errors="replace").splitlines() if line.strip()]


def read_suites(log):
    """The suites of cases; Meson names those of GoogleTest PROJECT.PROGRAM.SUITE, that of TAP PROJECT.PROGRAM."""
    if not log.exists():
        return []
    # Meson copies what a test printed, also characters that XML does not have: the colours of a log, for one.
    text = re.sub(r"[^\t\n\r -\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]", "?", log.read_text(errors="replace"))
    return [s for s in ElementTree.fromstring(text.encode()).iter("testsuite") if "." in s.get("name")]


def get_result(case):
    if case.find("failure") is not None or case.find("error") is not None:
        return "failed"
    if case.find("skipped") is not None or case.get("status") == "notrun":
        return "skipped"
    return "passed"


def count_program(program, suites, counts):
    name, result = program["name"], program["result"]
    suites = [s for s in suites if f".{name}." in f"{s.get('name')}."]
    cases = [(s.get("name").partition(f".{name}")[2].lstrip("."), c) for s in suites for c in s.iter("testcase")]
    before = len(counts["failed"])
    for suite, case in cases:
        counts[get_result(case)].append(f"{name}: {suite}{'.' if suite else ''}{case.get('name')}")
    if result not in GOOD | {"SKIP"}:
        if len(counts["failed"]) == before:
            why = ", though none of its cases did" if cases else ""
            counts["failed"].append(f"{name}: {result}{why}")
    elif not cases:
        counts["skipped" if result == "SKIP" else "passed"].append(name)


def main():
    logs = pathlib.Path(sys.argv[1]) / "meson-logs"
    suites = read_suites(logs / "testlog.junit.xml")
    counts = {"passed": [], "skipped": [], "failed": []}
    for program in read_programs(logs / "testlog.json"):
        count_program(program, suites, counts)
    failed = counts["failed"]
    if sys.argv[2] != "0" and not failed:
        failed.append("meson test failed before it ran a test")
    if not counts["passed"] and not failed:
        failed.append("no test ran")
    for name in failed:
        print(f"FAILED {name}")
    if counts["skipped"]:
        print(f"{len(counts['skipped'])} skipped")
    print(f"{len(counts['passed'])} passed, {len(failed)} failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
