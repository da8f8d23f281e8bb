#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Pipelines that serve NNStreamer's query clients, with a Python peer that was written from docs/compatibility/edge-wire.md alone."""

import contextlib
import io
import json
import os
import pathlib
import re
import signal
import struct
import subprocess
import sys
import tempfile
import unittest

import edge_peer
import tap_runner
from built_modules import has_engine
from launched_pipeline import Pipeline

SOURCE = pathlib.Path(os.environ["WEIR_SOURCE"])
SHARED = pathlib.Path(os.environ.get("WEIR_DATA") or SOURCE / "../shared")
MODEL = SHARED / "models/classification/mobilenet_v2_1.0_224_quant.tflite"
SECONDS = 60
FOUR = "other/tensor,dimension=(string)4:1,type=(string)uint8,framerate=0/1"
SUMS = ("received", "answered", "refused", "expired", "aborted")
# A client that sends a request again and again, and prints a line for each response.
ENDLESS = """
import sys
import edge_peer
with edge_peer.listener(0) as back, edge_peer.connection_to(sys.argv[1]) as a:
    form, start = edge_peer.recognise(edge_peer.reader_of(a))
    greeting = edge_peer.read_message(edge_peer.reader_of(a), form, start)
    address = f"127.0.0.1:{back.getsockname()[1]}".encode() + b"\\0"
    a.sendall(edge_peer.encode_message(form, edge_peer.HOST_INFO, greeting[1], [address]))
    b, _ = back.accept()
    while True:
        a.sendall(edge_peer.encode_message(form, edge_peer.TRANSFER_DATA, greeting[1], [b"abcd"], [["client_id", "1"]]))
        if len(sys.argv) == 2:
            edge_peer.read_message(edge_peer.reader_of(b), form)
            print("response", flush=True)
"""


class Served(unittest.TestCase):
    def serve(self, text):
        pipeline = Pipeline(text)
        self.addCleanup(pipeline.stop)
        self.assertTrue(pipeline.port, "".join(pipeline.lines))
        return pipeline

    def client(self, pipeline, *frames, form=0):
        """The capability, and the responses."""
        output = io.StringIO()
        with contextlib.redirect_stdout(output):
            edge_peer.run_client(edge_peer.arguments(["client", "--connect", f"127.0.0.1:{pipeline.port}", "--form", str(form),
                                                      *(",".join(part.hex() for part in frame) for frame in frames)]))
        greeting, *responses = map(json.loads, output.getvalue().splitlines())
        self.assertEqual({response["command"] for response in responses}, {"TRANSFER_DATA"})
        return greeting, [[bytes.fromhex(memory) for memory in response["memories"]] for response in responses]

    def endless(self, pipeline, *options):
        process = subprocess.Popen([sys.executable, "-c", ENDLESS, f"127.0.0.1:{pipeline.port}", *options], stdout=subprocess.PIPE, text=True)
        for cleanup in (process.stdout.close, process.wait, process.kill):
            self.addCleanup(cleanup)
        return process

    def ended(self, pipeline):
        """The sums of the log, which are right."""
        text = pipeline.stop()
        self.assertEqual(pipeline.process.returncode, 0, text)
        sums = dict(zip(SUMS, map(int, re.search(r"requests: (\d+) received = (\d+) answered \+ (\d+) refused \+ (\d+) expired \+ (\d+) aborted",
                                                 text).groups())))
        self.assertEqual(sums["received"], sum(sums[name] for name in SUMS[1:]))
        return sums


class Responses(Served):
    def test_a_pipeline_of_nnstreamer_needs_no_protocol(self):
        server = self.serve(f"tensor_query_serversrc port=0 ! {FOUR} ! tensor_transform mode=arithmetic option=add:1 ! tensor_query_serversink")
        for form in (0, 2088, 168):
            greeting, responses = self.client(server, [b"\1\2\3\4"], [b"\5\6\7\x08"], form=form)
            self.assertEqual(greeting["form"], form or 2088)
            self.assertRegex(greeting["capability"], r"^@query_server_src_caps@other/tensor.*@query_server_sink_caps@other/tensor")
            self.assertEqual(responses, [[b"\2\3\4\5"], [b"\6\7\x08\x09"]])
        self.assertEqual(self.ended(server), dict(received=6, answered=6, refused=0, expired=0, aborted=0))

    def test_a_client_is_greeted_although_the_caps_of_the_answers_come_with_its_request(self):
        picture = subprocess.run(["gst-launch-1.0", "-q", "videotestsrc", "num-buffers=1", "pattern=white", "!", "video/x-raw,width=16,height=8", "!", "jpegenc", "!",
                                  "fdsink"], capture_output=True, timeout=SECONDS, check=True).stdout
        pipeline = self.serve("tensor_query_serversrc port=0 caps=image/jpeg ! jpegdec ! videoconvert ! videoscale ! tensor_converter ! "
                              "other/tensors,format=static,num_tensors=1,dimensions=(string)1:4:2:1,types=(string)uint8 ! tensor_query_serversink")
        greeting, responses = self.client(pipeline, [picture])
        self.assertIn("4:2:1", greeting["capability"])
        self.assertEqual([[len(memory) for memory in response] for response in responses], [[8]])

    def test_the_first_greeting_has_the_caps_of_the_responses_also_behind_a_queue(self):
        for _ in range(5):
            pipeline = self.serve(f"tensor_query_serversrc port=0 caps={FOUR.replace('0/1', '30/1')} ! queue ! tensor_transform mode=typecast option=int16 ! "
                                  "tensor_query_serversink")
            first, second = (self.client(pipeline, [b"abcd"])[0]["capability"] for _ in range(2))
            self.assertEqual(first, second)
            self.assertIn("int16", first)
            self.assertIn("framerate=(fraction)30/1", first)

    def test_the_oldest_form_is_served_when_asked(self):
        server = self.serve(f"tensor_query_serversrc port=0 wire-version=0.2.2 ! {FOUR} ! tensor_query_serversink")
        self.assertEqual(self.client(server, [b"abcd"], form=160)[1], [[b"abcd"]])

    def test_the_line_of_the_document_serves(self):
        text = (SOURCE / "src/edge/tensor_query_serversrc/README.md").read_text()
        line, = re.findall(r"^gst-launch-1.0 (tensor_query_serversrc port=3000 ! other/tensors.*)$", text, re.MULTILINE)
        server = self.serve(line.replace("port=3000", "port=0"))
        self.assertEqual(self.client(server, [struct.pack("<4f", 1.5, -2, 0, 1e6)])[1], [[struct.pack("<4f", 4, -3, 1, 2000001)]])

    @unittest.skipUnless(has_engine("tensorflow-lite"), "the engine tensorflow-lite is not built")
    @unittest.skipUnless(MODEL.exists(), f"{MODEL} is not here")
    def test_a_model_recognises_the_pictures_of_a_client(self):
        server = self.serve("tensor_query_serversrc port=0 ! video/x-raw,format=RGB,width=224,height=224,framerate=0/1 ! tensor_converter ! "
                            f"tensor_filter model={MODEL} ! tensor_query_serversink")
        picture = (SHARED / "media/image/orange.raw").read_bytes()
        for (scores,) in self.client(server, [picture], [picture])[1]:
            self.assertEqual(max(range(1001), key=scores.__getitem__), 951)  # orange

    def test_two_servers_of_one_process(self):
        server = self.serve(f"tensor_query_serversrc port=0 id=1 ! {FOUR} ! tensor_transform mode=arithmetic option=add:1 ! tensor_query_serversink id=1 "
                            f"tensor_query_serversrc port=0 id=2 ! {FOUR} ! tensor_query_serversink id=2")
        ports = list(map(int, server.wait_for(r": port = (\d+)", 2)))
        responses = []
        for server.port in ports:
            responses += self.client(server, [b"abcd"])[1]
        self.assertEqual(sorted(responses), [[b"abcd"], [b"bcde"]])


class Clients(Served):
    def test_a_killed_client_does_not_stop_the_pipeline(self):
        server = self.serve(f"tensor_query_serversrc port=0 ! {FOUR} ! tensor_query_serversink")
        for _ in range(5):
            client = self.endless(server)
            for _ in range(20):
                self.assertEqual(client.stdout.readline(), "response\n")
            client.send_signal(signal.SIGKILL)
            client.wait()
            self.assertEqual(self.client(server, [b"wxyz"])[1], [[b"wxyz"]])
        sums = self.ended(server)
        self.assertGreaterEqual(sums["answered"], 105)
        self.assertEqual(sums["refused"] + sums["aborted"], 0)

    def test_a_client_that_does_not_read_stalls_no_other(self):
        server = self.serve(f"tensor_query_serversrc port=0 timeout=0 ! {FOUR} ! tensor_query_serversink")
        self.endless(server, "mute")
        for _ in range(3):
            self.assertEqual(self.client(server, [b"abcd"], [b"efgh"])[1], [[b"abcd"], [b"efgh"]])
        self.assertIsNone(server.process.poll())

    def test_a_frame_unlike_the_caps_closes_its_client_and_the_log_says_why(self):
        server = self.serve(f"tensor_query_serversrc port=0 ! {FOUR} ! tensor_query_serversink")
        done = subprocess.run([sys.executable, edge_peer.__file__, "client", "--connect", f"127.0.0.1:{server.port}", "010203"],
                              capture_output=True, text=True, timeout=SECONDS)
        self.assertIn("ERROR", done.stdout)
        self.assertTrue(server.wait_for("a query client was refused"))
        self.assertIn("127.0.0.1: ", "".join(server.lines))
        self.assertEqual(self.client(server, [b"abcd"])[1], [[b"abcd"]])
        self.assertEqual(self.ended(server), dict(received=2, answered=1, refused=1, expired=0, aborted=0))


class Security(Served):
    def test_required_tls_needs_two_properties(self):
        text = f"tensor_query_serversrc port=0 host=0.0.0.0 %s ! {FOUR} ! tensor_query_serversink"
        config = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory())) / "weir.ini"
        config.write_text("[network]\nrequire-tls=true\n")
        environment = {**os.environ, "WEIR_CONFIG": str(config)}

        def launch(options):
            return subprocess.Popen(["gst-launch-1.0", *(text % options).split()], env=environment, stdout=subprocess.PIPE,
                                    stderr=subprocess.STDOUT, text=True)

        with launch("") as refused:
            self.assertIn("WEIR-6003", refused.communicate(timeout=SECONDS)[0])
        self.assertNotEqual(refused.returncode, 0)
        with launch("insecure=true allow=127.0.0.1 num-buffers=0") as allowed:
            self.assertNotIn("WEIR-", allowed.communicate(timeout=SECONDS)[0])
        self.assertEqual(allowed.returncode, 0)


if __name__ == "__main__":
    tap_runner.main()
