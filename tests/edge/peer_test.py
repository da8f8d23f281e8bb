#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Tests of the Python peer: the bytes of docs/compatibility/edge-wire.md 10.7, and both ends of each role over TCP."""

import json
import subprocess
import sys
import unittest

import edge_peer
import tap_runner

SECONDS = 60
CLIENT_ID = 1051064743


def golden(head, zeros_to, tail):
    start = bytes.fromhex(head)
    return start + bytes(zeros_to - len(start)) + bytes.fromhex(tail)


HOST_INFO = golden("ed fe ed fe 02 00 00 00 02 00 00 06 00 00 dd ef a7 f9 a5 3e 00 00 00 00 01 00 00 00 00 00 00 00 0f", 2088,
                   "31 32 37 2e 30 2e 30 2e 31 3a 34 31 30 31 00")
TRANSFER_DATA = golden(
    "ed fe ed fe 01 00 00 00 02 00 00 06 00 00 dd ef a7 f9 a5 3e 00 00 00 00 02 00 00 00 00 00 00 00"
    "04 00 00 00 00 00 00 00 03 00 00 00 00 00 00 00", 2080,
    "19 00 00 00 00 00 00 00 01 02 03 04 78 79 7a"
    "01 00 00 00 63 6c 69 65 6e 74 5f 69 64 00 31 30 35 31 30 36 34 37 34 33 00")
MQTT = golden("da ed da ed 00 00 00 00 02 00 00 06 00 00 dd ef 01 00 00 00 00 00 00 00 04", 2072,
              "10 00 00 00 00 00 00 00 01 02 03 04 02 00 00 00 6b 32 00 76 32 00 6b 31 00 76 31 00")


def start(*words):
    return subprocess.Popen([sys.executable, edge_peer.__file__, *words], stdout=subprocess.PIPE, text=True)


def lines_of(process):
    out, _ = process.communicate(timeout=SECONDS)
    if process.returncode:
        raise AssertionError(f"{process.args} returned {process.returncode}")
    return [json.loads(line) for line in out.splitlines()]


def listening(*words):
    process = start(*words)
    return process, f"127.0.0.1:{process.stdout.readline().split()[1]}"


class Bytes(unittest.TestCase):
    def test_messages(self):
        self.assertEqual(edge_peer.encode_message(2088, edge_peer.HOST_INFO, CLIENT_ID, [b"127.0.0.1:4101\0"]), HOST_INFO)
        self.assertEqual(edge_peer.encode_message(2088, edge_peer.TRANSFER_DATA, CLIENT_ID, [b"\1\2\3\4", b"xyz"],
                                                  [["client_id", str(CLIENT_ID)]]), TRANSFER_DATA)

    def test_greeting_of_0_2_2(self):
        head = bytes.fromhex("ed fe ed fe 03 00 00 00 61 64 54 42 00 00 00 00 01 00 00 00 00 00 00 00 32")
        message = edge_peer.encode_message(160, edge_peer.CAPABILITY, 0x42546461, [bytes(50)])
        self.assertEqual(message[:len(head)], head)
        self.assertEqual(len(message), 160 + 50)

    def test_payload_of_mqtt(self):
        metadata = [["k2", "v2"], ["k1", "v1"]]
        self.assertEqual(len(MQTT), 2100)
        self.assertEqual(edge_peer.encode_mqtt(2080, [b"\1\2\3\4"], metadata), MQTT)
        self.assertEqual(edge_peer.decode_mqtt(MQTT), (2080, [b"\1\2\3\4"], metadata))

    def test_damaged_bytes_are_refused(self):
        for damaged in (MQTT[:-1], MQTT + b"\0", MQTT[:4], b""):
            with self.assertRaises(edge_peer.Fault):
                edge_peer.decode_mqtt(damaged)
        for blob in (b"\1\0\0", b"\2\0\0\0k\0v\0", b"\1\0\0\0k\0v", b"\0\0\0\0k\0v\0"):
            with self.assertRaises(edge_peer.Fault):
                edge_peer.decode_metadata(blob)


class Roles(unittest.TestCase):
    def test_each_frame_comes_back(self):
        for greeting, client, form in ((0, 0, 2088), (0, 168, 168), (2088, 0, 2088), (168, 168, 168), (168, 0, 168), (160, 160, 160),
                                       (160, 0, 160)):
            with self.subTest(greeting=greeting, client=client):
                server, address = listening("server", "--form", str(greeting), "--src-caps", "A", "--sink-caps", "B")
                hello, *responses = lines_of(start("client", "--form", str(client), "--connect", address, "01020304,78797a", "ff"))
                requests = lines_of(server)
                self.assertEqual(hello, {"form": form, "capability": "@query_server_src_caps@A@query_server_sink_caps@B"})
                self.assertEqual([response["memories"] for response in responses], [["01020304", "78797a"], ["ff"]])
                self.assertEqual(requests, responses)

    def test_each_subscriber_receives_each_frame(self):
        publisher, address = listening("publisher", "--subscribers", "2", "--caps", "A", "0102", "03,04")
        subscribers = [start("subscriber", "--frames", "2", "--connect", address) for _ in range(2)]
        for subscriber in subscribers:
            hello, *frames = lines_of(subscriber)
            self.assertEqual(hello, {"form": 2088, "capability": "@edge_sink_caps@A"})
            self.assertEqual([(frame["memories"], frame["metadata"]) for frame in frames], [(["0102"], []), (["03", "04"], [])])
        self.assertEqual(lines_of(publisher), [])


if __name__ == "__main__":
    tap_runner.main()
