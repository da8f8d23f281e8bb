# SPDX-License-Identifier: LGPL-2.1-or-later
"""Runs the unittest cases of the calling program and prints TAP, so that Meson counts each case.

Test protocol `tap` in Meson. Failures go to stderr, which Meson shows for such a program.
"""

import sys
import unittest


class TapResult(unittest.TestResult):
    def __init__(self):
        super().__init__()
        self.number = 0
        self.wrong = []  # tracebacks of the current case and its subtests

    def startTest(self, test):
        super().startTest(test)
        self.wrong = []

    def addError(self, test, err):
        super().addError(test, err)
        self.wrong.append(self.errors[-1][1])
        if not isinstance(test, unittest.TestCase):  # setUpClass or setUpModule failed: no case starts
            self.say(test)

    def addFailure(self, test, err):
        super().addFailure(test, err)
        self.wrong.append(self.failures[-1][1])

    def addSubTest(self, test, subtest, err):
        super().addSubTest(test, subtest, err)
        if err is not None:
            self.wrong.append(f"{subtest.id()}\n{self._exc_info_to_string(err, test)}")

    def addUnexpectedSuccess(self, test):
        super().addUnexpectedSuccess(test)
        self.wrong.append("it was expected to fail")

    def addSkip(self, test, reason):
        super().addSkip(test, reason)
        self.say(test, f" # SKIP {reason}")

    def stopTest(self, test):
        super().stopTest(test)
        if not self.skipped or self.skipped[-1][0] is not test:
            self.say(test)

    def say(self, test, comment=""):
        self.number += 1
        name = test.id().removeprefix("__main__.")
        print(f"{'not ok' if self.wrong else 'ok'} {self.number} {name}{comment}")
        sys.stdout.flush()
        for text in self.wrong:
            print(f"{name}\n{text}", file=sys.stderr, flush=True)


def main():
    result = TapResult()
    names = sys.argv[1:]
    module = sys.modules["__main__"]
    loader = unittest.defaultTestLoader
    cases = loader.loadTestsFromNames(names, module) if names else loader.loadTestsFromModule(module)
    cases.run(result)
    print(f"1..{result.number}", flush=True)
    sys.exit(0 if result.wasSuccessful() and result.number else 1)
