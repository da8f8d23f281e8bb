# SPDX-License-Identifier: LGPL-2.1-or-later
"""A pipeline of gst-launch-1.0 that serves clients."""

import contextlib
import os
import re
import signal
import subprocess
import threading


class Gate:
    """Holds the frames of a pipeline whose text contains `text`, until open(). The pipe that it is must hold all later ones."""

    def __init__(self, test):
        self.end, self.begin = os.pipe()
        test.addCleanup(os.close, self.end)
        test.addCleanup(os.close, self.begin)
        os.set_blocking(self.begin, False)
        with contextlib.suppress(BlockingIOError):
            while True:
                os.write(self.begin, bytes(4096))
        os.set_blocking(self.begin, True)
        os.set_blocking(self.end, False)
        # The branch of fdsink is the first, and the thread of the frame serves both.
        self.text = (f"identity name=gate silent=false ! tee name=held ! fdsink fd={self.begin} sync=false async=false "
                     "enable-last-sample=false held. !")

    def open(self):
        with contextlib.suppress(BlockingIOError):
            while True:
                os.read(self.end, 1 << 16)


class Pipeline:
    """Plays until stop(). `port` is that of its tensor_query_serversrc, which has port=0."""

    def __init__(self, text, ports=1, gate=None):
        self.process = subprocess.Popen(
            ["gst-launch-1.0", "-v", *text.split()], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
            stdin=subprocess.DEVNULL, pass_fds=[gate.begin] if gate else [],
            env={**os.environ, "GST_DEBUG": "tensor_query_serversrc:4", "GST_TRACERS": "", "GST_DEBUG_NO_COLOR": "1"})
        self.lines, self.changed, self.ended = [], threading.Condition(), False
        self.interrupted = False
        self.reader = threading.Thread(target=self.read)
        self.reader.start()
        found = self.wait_for(r": port = (\d+)", ports)
        self.wait_for(r"(Setting pipeline to PLAYING)", 1)
        self.port = int(found[0]) if found else None

    def read(self):
        for line in self.process.stdout:
            with self.changed:
                self.lines.append(line)
                self.changed.notify_all()
        with self.changed:
            self.ended = True
            self.changed.notify_all()

    def found(self, pattern):
        return re.findall(pattern, "".join(self.lines))

    def wait_for(self, pattern, count=1, seconds=60):
        """What `pattern` finds in the output once it is there `count` times; [] when the pipeline ends first."""
        with self.changed:
            self.changed.wait_for(lambda: self.ended or len(self.found(pattern)) >= count, seconds)
            return self.found(pattern)

    def frames_at_gate(self, count):
        """How many frames have come to the gate, once there are `count`."""
        return len(self.wait_for(r"GstIdentity:gate: last-message = chain", count))

    def interrupt(self):
        """Stops; does not wait. Once: another signal would kill the program while it stops."""
        if not self.interrupted and self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
        self.interrupted = True

    def stop_at_end(self):
        """The whole output of a pipeline that ends itself."""
        self.process.wait(60)
        return self.stop()

    def stop(self):
        """The whole output."""
        self.interrupt()
        try:
            self.process.wait(30)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
            raise
        finally:
            self.reader.join()
            self.process.stdout.close()
        return "".join(self.lines)
