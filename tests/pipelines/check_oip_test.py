#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""tools/check-oip against an inference server of Python's grpcio that is right, and against others that are not."""

import os
import pathlib
import subprocess
import unittest

import tap_runner
from peer_process import start_grpcio_server

SOURCE = pathlib.Path(os.environ["WEIR_SOURCE"])


class CheckOip(unittest.TestCase):
    def server(self, *options):
        return f"127.0.0.1:{start_grpcio_server(self, *options)[1]}"

    def check(self, address, *options):
        done = subprocess.run([SOURCE / "tools/check-oip", address, *options], capture_output=True, text=True, timeout=240)
        lines = done.stdout.splitlines()
        self.assertTrue(lines, done.stderr)
        failed = [line.removeprefix("FAILED").strip() for line in lines if line.startswith("FAILED")]
        self.assertEqual(done.returncode, 1 if failed else 0)
        passed = sum(line.startswith("ok ") for line in lines)
        self.assertEqual(lines[-1], f"{passed} passed, {len(failed)} failed")
        return passed, failed

    def test_a_right_server_passes(self):
        self.assertEqual(self.check(self.server(), "--model", "affine"), (18, []))
        self.assertEqual(self.check(self.server("--typed", "--type", "INT32"), "--model", "affine"), (18, []))

    def test_without_a_model_the_server_alone_is_checked(self):
        self.assertEqual(self.check(self.server()), (4, []))

    def test_what_is_wrong_is_named(self):
        for behaviour, check in (("short", "raw contents are answered"), ("wrong-type", "raw contents are answered: other outputs than"),
                                 ("refuses-raw", "raw contents are answered: INVALID_ARGUMENT: raw contents are not accepted"),
                                 ("no-output", "raw contents are answered: other outputs than the description has"),
                                 ("error", "id is echoed: INTERNAL: the model failed")):
            _, failed = self.check(self.server("--behaviour", behaviour), "--model", "affine")
            self.assertTrue(any(line.startswith(check) for line in failed), f"{behaviour}: {failed}")

    def test_a_model_that_is_not_there_is_named(self):
        _, failed = self.check(self.server(), "--model", "other")
        self.assertIn("model describes its tensors: NOT_FOUND: there is no model other", failed)

    def test_no_server_fails_every_check(self):
        passed, failed = self.check("127.0.0.1:9", "--model", "affine")
        self.assertEqual((passed, len(failed)), (0, 22))
        self.assertIn("server is live: UNAVAILABLE", failed[0])


if __name__ == "__main__":
    tap_runner.main()
