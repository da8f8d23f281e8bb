# SPDX-License-Identifier: LGPL-2.1-or-later
"""A test case whose pipelines are processes of gst-launch-1.0."""

import os
import pathlib
import re
import subprocess
import tempfile
import unittest

SECONDS = 240  # ends what hangs
LEAKED = r"object-alive, type-name=\(string\)\w+"


class LaunchedPipelines(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def launch(self, text, stdin=None, **environment):
        """gst-launch-1.0 in the background; its output is in the file `log` of the process."""
        log = tempfile.TemporaryFile(dir=self.folder)
        process = subprocess.Popen(["gst-launch-1.0", *text.split()], stdin=stdin, stdout=log, stderr=log, text=True,
                                   env=os.environ | environment)
        process.log = log
        for cleanup in (log.close, process.wait, process.kill):
            self.addCleanup(cleanup)
        return process

    def output_of(self, process):
        # Not seek(): the process writes at the same offset.
        log = process.log.fileno()
        return os.pread(log, os.fstat(log).st_size, 0).decode(errors="replace")

    def ends(self, process, code=0):
        self.assertEqual(process.wait(SECONDS), code, self.output_of(process))
        self.assertEqual(re.findall(LEAKED, self.output_of(process)), [])

    def wait_for(self, process, pattern):
        """The first match in the output, read until it comes or the process ends."""
        while True:
            ended = process.poll() is not None
            found = re.search(pattern, self.output_of(process))
            if found or ended:
                self.assertTrue(found, f"{pattern} is not in {self.output_of(process)}")
                return found
