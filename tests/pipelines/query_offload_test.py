#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""tensor_query_client in a process of its own: with a Python peer of NNStreamer's protocol, with servers of Weir, and when either is killed."""

import json
import re
import signal
import subprocess
import sys
import time

import edge_peer
import tap_runner
from launched_pipelines import SECONDS, LaunchedPipelines
from peer_process import start_peer

CAPS = 'other/tensors,format=static,num_tensors=1,dimensions=(string)8,types=(string)uint8,framerate=(fraction)0/1'
FRAMES = [bytes(range(i, i + 8)) for i in range(0, 240, 10)]


def plus_one(frame):
    return bytes(byte + 1 for byte in frame)


class Query(LaunchedPipelines):
    def setUp(self):
        super().setUp()
        self.out = self.folder / "out"

    def client(self, port, options="", out=None):
        """A client whose frames are 8 bytes of its standard input each; its responses are in the file `out`."""
        process = self.launch(f"fdsrc blocksize=8 ! application/octet-stream ! tensor_converter input-dim=8 input-type=uint8 ! "
                              f"tensor_query_client port=0 dest-port={port} {options} ! "
                              f"filesink async=false buffer-mode=unbuffered location={out or self.out}",
                              stdin=subprocess.PIPE, GST_DEBUG="GST_TRACER:7,tensor_query_client:4", GST_DEBUG_NO_COLOR="1")
        self.addCleanup(process.stdin.close)
        process.out = out or self.out
        return process

    def send(self, client, frame):
        client.stdin.buffer.write(frame)
        client.stdin.buffer.flush()

    def ask(self, client, frame):
        """The response to a frame."""
        size = client.out.stat().st_size if client.out.exists() else 0
        self.send(client, frame)
        while not client.out.exists() or client.out.stat().st_size < size + 8:
            self.assertIsNone(client.poll(), self.output_of(client))
        return client.out.read_bytes()[size:]

    def ask_until_in_time(self, client, frame):
        """For clients whose responses may come too late."""
        while not client.out.exists() or client.out.stat().st_size == 0:
            self.assertIsNone(client.poll(), self.output_of(client))
            self.send(client, frame)
            time.sleep(0.1)

    def outcomes(self, client):
        """Of a client that ends now."""
        client.stdin.close()
        self.ends(client)
        found = self.wait_for(client, r"(\d+) sent: (\d+) answered, (\d+) late, (\d+) refused, (\d+) lost")
        sent, *rest = map(int, found.groups())
        self.assertEqual(sent, sum(rest))
        return dict(zip(("sent", "answered", "late", "refused", "lost"), [sent, *rest]))


class WithThePythonPeer(Query):
    def peer(self, *options):
        return start_peer(self, sys.executable, edge_peer.__file__, "server", "--src-caps", CAPS, "--sink-caps", CAPS, *options)

    def test_each_form_of_headers(self):
        for form in (0, 2088, 168, 160):
            self.out.unlink(missing_ok=True)
            peer, port = self.peer("--form", str(form))
            client = self.client(port, "timeout=60000")
            self.assertEqual([self.ask(client, frame) for frame in FRAMES[:3]], FRAMES[:3])
            self.assertEqual(self.outcomes(client)["answered"], 3)
            received = [json.loads(line) for line in peer.stdout.read().splitlines()]
            self.assertEqual(peer.wait(SECONDS), 0)
            self.assertEqual([bytes.fromhex(message["memories"][0]) for message in received], FRAMES[:3])
            self.assertEqual({message["form"] for message in received}, {form or 2088})
            for number, message in enumerate(received):
                self.assertEqual(dict(message["metadata"]), {"client_id": str(message["client_id"]), "weir.seq": str(number)})

    def test_answers_belong_to_their_frames_when_the_server_drops_some(self):
        _, port = self.peer("--drop", "3", "--clients", "100")
        client = self.client(port, "timeout=50")
        for frame in FRAMES:
            self.send(client, frame)
        outcomes = self.outcomes(client)
        self.assertEqual(outcomes["sent"], len(FRAMES))
        self.assertGreater(outcomes["late"], 0)
        written = self.out.read_bytes()
        responses = [written[i:i + 8] for i in range(0, len(written), 8)]
        self.assertEqual(responses, sorted(set(responses)))
        self.assertLessEqual(set(responses), set(FRAMES))
        self.assertGreaterEqual(len(responses), outcomes["answered"])

    def test_a_killed_server_is_an_error(self):
        peer, port = self.peer()
        client = self.client(port, "timeout=60000")
        self.ask(client, FRAMES[0])
        peer.kill()
        peer.wait()
        self.send(client, FRAMES[1])
        self.assertNotEqual(client.wait(SECONDS), 0)
        self.assertIn("the connection to the query server was lost", self.output_of(client))
        self.assertIn(f"localhost:{port}", self.output_of(client))


class WithServersOfWeir(Query):
    def server(self, port=0, more=""):
        """Adds 1 to each byte."""
        process = self.launch(f"tensor_query_serversrc port={port} ! {CAPS} ! tensor_transform mode=arithmetic option=add:1 ! {more} "
                              "tensor_query_serversink async=false", GST_DEBUG="GST_TRACER:7,tensor_query_serversrc:4",
                              GST_DEBUG_NO_COLOR="1")
        process.port = int(self.wait_for(process, r"listening on localhost:(\d+)")[1])
        return process

    def stop(self, server):
        server.send_signal(signal.SIGINT)
        server.wait(SECONDS)

    def test_frames_become_answers(self):
        server = self.server()
        client = self.client(server.port, "timeout=60000")
        self.assertEqual([self.ask(client, frame) for frame in FRAMES], [plus_one(frame) for frame in FRAMES])
        self.assertEqual(self.outcomes(client), {"sent": 24, "answered": 24, "late": 0, "refused": 0, "lost": 0})
        self.stop(server)

    def test_each_of_several_clients_gets_its_answers(self):
        server = self.server()
        clients = [self.client(server.port, "timeout=60000", self.folder / str(i)) for i in range(3)]
        for frame in FRAMES:
            for i, client in enumerate(clients):
                own = bytes([i]) + frame[1:]
                self.assertEqual(self.ask(client, own), plus_one(own))
        for client in clients:
            self.assertEqual(self.outcomes(client)["answered"], 24)

    def test_a_server_that_drops_frames_repeats_the_numbers_of_the_others(self):
        server = self.server(more="identity drop-probability=0.5 !")
        client = self.client(server.port, "timeout=100 max-request=100")  # no new connection after late responses
        for frame in FRAMES:
            self.send(client, frame)
        outcomes = self.outcomes(client)
        self.assertEqual(outcomes["sent"], len(FRAMES))
        self.assertGreater(outcomes["answered"], 0)
        self.assertGreater(outcomes["late"], 0)
        written = self.out.read_bytes()
        responses = [written[i:i + 8] for i in range(0, len(written), 8)]
        self.assertEqual(responses, sorted(set(responses)))
        asked = [plus_one(frame) for frame in FRAMES]
        self.assertLessEqual(set(responses), set(asked))
        # Without numbers each response after the first dropped frame would be taken for the one before.
        first_dropped = next(response for response in asked if response not in responses)
        self.assertGreater(responses[-1], first_dropped)
        self.assertEqual(len(re.findall("connected to", self.output_of(client))), 1, self.output_of(client))

    def test_a_killed_client_does_not_stop_the_server(self):
        server = self.server()
        first = self.client(server.port, "timeout=60000", self.folder / "first")
        self.ask(first, FRAMES[0])
        first.kill()
        first.wait()
        second = self.client(server.port, "timeout=60000")
        self.assertEqual(self.ask(second, FRAMES[1]), plus_one(FRAMES[1]))
        self.assertIsNone(server.poll())

    def test_with_reconnect_a_killed_server_is_replaced(self):
        server = self.server()
        client = self.client(server.port, "timeout=60000 reconnect=true")
        self.ask(client, FRAMES[0])
        server.kill()
        server.wait()
        self.send(client, FRAMES[1])
        self.wait_for(client, "the connection to the query server was lost")
        self.server(server.port)
        before = self.out.stat().st_size
        while self.out.stat().st_size == before:
            self.assertIsNone(client.poll(), self.output_of(client))
            self.send(client, FRAMES[2])
        self.assertEqual(self.out.read_bytes()[before:before + 8], plus_one(FRAMES[2]))

    def test_a_frozen_server_is_late_and_its_answers_stay_with_their_frames(self):
        server = self.server()
        client = self.client(server.port, "timeout=100")
        self.ask_until_in_time(client, FRAMES[0])
        server.send_signal(signal.SIGSTOP)
        self.send(client, FRAMES[1])
        self.send(client, FRAMES[2])
        self.send(client, FRAMES[3])
        server.send_signal(signal.SIGCONT)
        before = self.out.stat().st_size
        sent = []
        while not sent or self.out.read_bytes()[-8:] != plus_one(sent[-1]):
            self.assertIsNone(client.poll(), self.output_of(client))
            sent.append(bytes([len(sent) % 100]) * 8)
            self.send(client, sent[-1])
        asked = [plus_one(frame) for frame in FRAMES[:4] + sent]
        written = self.out.read_bytes()[before:]
        for i in range(0, len(written), 8):
            self.assertIn(written[i:i + 8], asked)
        self.outcomes(client)


if __name__ == "__main__":
    tap_runner.main()
