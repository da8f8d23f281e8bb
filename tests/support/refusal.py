# SPDX-License-Identifier: LGPL-2.1-or-later
"""Pipelines that must fail."""

import os
import subprocess

SECONDS = 120


def refusal(test, line):
    """What `weir run` says of a line that it cannot play.

    Not gst-launch-1.0: version 1.22 waits for ever now and then after an error in a pipeline that prerolls,
    with GStreamer's own elements too.
    """
    done = subprocess.run([os.environ["WEIR_COMMAND"], "run", line], timeout=SECONDS, capture_output=True, text=True,
                          stdin=subprocess.DEVNULL)
    test.assertGreater(done.returncode, 0, done.stdout + done.stderr)
    return done.stderr
