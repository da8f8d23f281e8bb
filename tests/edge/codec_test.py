#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""The code of core/wire and the Python peer read each other's bytes, and write the same ones."""

import json
import os
import random
import subprocess
import unittest

import edge_peer
import tap_runner

CODEC = os.environ["WEIR_EDGE_CODEC"]
SECONDS = 60
SEED = 20261126


def codec(*words, given=b"", fails=False):
    done = subprocess.run([CODEC, *words], input=given, capture_output=True, timeout=SECONDS, check=False)
    if (done.returncode != 0) != fails:
        raise AssertionError(f"{words}: {done.returncode}, {done.stderr.decode()}")
    return done.stderr.decode() if fails else done.stdout


def lines_of(out):
    return [json.loads(line) for line in out.decode().splitlines()]


def as_lines(records):
    return "".join(json.dumps(record) + "\n" for record in records).encode()


def random_memories(source, most):
    sizes = [source.choice((1, 2, 127, 128, 4096, 70000)) for _ in range(source.randint(1, most))]
    return [source.randbytes(size if len(sizes) < 20 else 3).hex() for size in sizes]


def random_metadata(source):
    return [[f"key{i}", "v" * source.randint(1, 30)] for i in range(source.randint(0, 4))]


def random_frames(source, form):
    table = edge_peer.TABLE[form]
    for most in (1, 3, 15, table - 1):
        yield {"form": form, "command": "TRANSFER_DATA", "client_id": source.randrange(-2 ** 47 if form == 160 else -2 ** 63, 2 ** 47),
               "memories": random_memories(source, most), "metadata": random_metadata(source)}
    yield {"form": form, "command": "TRANSFER_DATA", "client_id": 1, "memories": ["07"] * (table - 1), "metadata": []}
    yield {"form": form, "command": "ERROR", "client_id": 0, "memories": [], "metadata": []}


def text_message(form, command, text):
    return {"form": form, "command": command, "client_id": 4611686018427387903, "memories": [(text + "\0").encode().hex()],
            "metadata": []}


def conversation(form, seed=SEED):
    """What a client sends on A, or a publisher, in one form."""
    source = random.Random(seed)
    greeting = text_message(form, source.choice(("HOST_INFO", "CAPABILITY")), "localhost:3001")
    return [greeting, *random_frames(source, form)]


class Messages(unittest.TestCase):
    def test_each_reads_what_the_other_writes(self):
        for form in edge_peer.LAYOUTS:
            with self.subTest(form=form):
                records = conversation(form)
                by_peer = b"".join(edge_peer.encode_line("message", json.dumps(record)) for record in records)
                by_weir = codec("encode", "message", given=as_lines(records))
                self.assertEqual(by_weir, by_peer)
                for piece in ("1000000", "1021", "17"):
                    self.assertEqual(lines_of(codec("decode", "message", piece, given=by_peer)), records)
                done = subprocess.run(["/usr/bin/python3", edge_peer.__file__, "decode", "message"], input=by_weir, capture_output=True,
                                      timeout=SECONDS, check=True)
                self.assertEqual(lines_of(done.stdout), records)

    def test_the_greeting_for_both_forms_is_that_of_the_newest_for_weir(self):
        text = b"@query_server_src_caps@A@query_server_sink_caps@B\0"
        [message] = lines_of(codec("decode", "message", given=edge_peer.greet_both(5, text)))
        self.assertEqual((message["form"], message["memories"]), (2088, [text.hex()]))

    def test_what_is_damaged_is_refused_by_both(self):
        whole = edge_peer.encode_message(2088, edge_peer.TRANSFER_DATA, 1, [b"abc"], [["k", "v"]])
        for at, value, says in ((0, 0, "does not begin with an nnstreamer-edge message"), (26, 1, "more memories than its header"),
                                (37, 1, "larger than allowed"), (2084, 1, "the metadata of a message is too long")):
            damaged = whole[:at] + bytes([value]) + whole[at + 1:]
            self.assertIn(says, codec("decode", "message", given=damaged, fails=True))
            with self.assertRaises(edge_peer.Fault):
                edge_peer.read_message(edge_peer.reader_of(Piece(damaged)), 2088)
        self.assertIn("in the middle of a message", codec("decode", "message", given=whole[:-1], fails=True))
        with self.assertRaises(EOFError):
            edge_peer.read_message(edge_peer.reader_of(Piece(whole[:-1])), 2088)


class Piece:
    """A file of these bytes."""

    def __init__(self, data):
        self.data = data

    def read(self, size):
        part, self.data = self.data[:size], self.data[size:]
        return part


class Mqtt(unittest.TestCase):
    def test_each_reads_the_frames_of_the_other(self):
        source = random.Random(SEED)
        for form, table in edge_peer.MQTT_TABLE.items():
            for most in (1, 3, table - 1):
                record = {"form": form, "memories": random_memories(source, most), "metadata": random_metadata(source)}
                with self.subTest(form=form, most=most):
                    by_peer = edge_peer.encode_line("mqtt", json.dumps(record))
                    by_weir = codec("encode", "mqtt", given=as_lines([record]))
                    self.assertEqual(by_weir, by_peer)
                    self.assertEqual(lines_of(codec("decode", "mqtt", given=by_peer)), [record])
                    found_form, memories, metadata = edge_peer.decode_mqtt(by_weir)
                    self.assertEqual((found_form, [memory.hex() for memory in memories], metadata),
                                     (form, record["memories"], record["metadata"]))

    def test_each_reads_the_header_of_the_other(self):
        source = random.Random(SEED)
        for count in (0, 1, 2, 16):
            record = {"sizes": [source.randrange(2 ** 64) for _ in range(count)], "base_time_epoch": source.randrange(-2 ** 63, 2 ** 63),
                      "sent_time_epoch": source.randrange(2 ** 63), "duration": source.choice((None, 0, 33333333)),
                      "dts": source.choice((None, source.randrange(2 ** 63))), "pts": source.randrange(2 ** 64 - 1),
                      "caps": "c" * source.choice((0, 20, 511))}
            with self.subTest(count=count):
                by_peer = edge_peer.encode_mqtt_header(record)
                by_weir = codec("encode", "mqtt-header", given=as_lines([record]))
                self.assertEqual(by_weir, by_peer)
                self.assertEqual(lines_of(codec("decode", "mqtt-header", given=by_peer)), [record])
                self.assertEqual(edge_peer.decode_mqtt_header(by_weir), record)

    def test_payloads_that_are_cut_are_refused(self):
        record = {"form": 2080, "memories": ["01020304"], "metadata": [["k", "v"]]}
        payload = edge_peer.encode_line("mqtt", json.dumps(record))
        self.assertIn("does not have the length", codec("decode", "mqtt", given=payload[:-1], fails=True))
        self.assertIn("is too short for its header", codec("decode", "mqtt-header", given=payload[:1023], fails=True))
        with self.assertRaises(edge_peer.Fault):
            edge_peer.decode_mqtt(payload[:-1])


if __name__ == "__main__":
    tap_runner.main()
