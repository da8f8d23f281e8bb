# SPDX-License-Identifier: LGPL-2.1-or-later
"""Runs pipelines that must fail."""

import os
import subprocess

SECONDS = 120


def refusal(test, line):
    """Returns the error of `weir run` for a pipeline that it cannot play.

    Not gst-launch-1.0: version 1.22 sometimes hangs after an error in a pipeline that prerolls, even with
    GStreamer's own elements.
    """
    done = subprocess.run([os.environ["WEIR_COMMAND"], "run", line], timeout=SECONDS, capture_output=True, text=True,
                          stdin=subprocess.DEVNULL)
    test.assertGreater(done.returncode, 0, done.stdout + done.stderr)
    return done.stderr
