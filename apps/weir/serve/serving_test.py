#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""`weir serve` at work: tools/check-oip and a client's pipeline ask it, and signals end it."""

import contextlib
import os
import pathlib
import re
import select
import shutil
import signal
import socket
import ssl
import subprocess
import time
import unittest
import urllib.error
import urllib.request

import numpy as np

import onnx_writer
import tap_runner
from built_modules import has_engine
from weir_case import COMMAND, HAS_ONNX, MODEL, SOURCE, Case, sanitized, weir

HAS_NET = "weirnet" in os.environ.get("WEIR_NET_PLUGIN", "")
HAS_GRPCIO = os.environ.get("WEIR_INFERENCE_CLASSES", "") != ""
if HAS_GRPCIO:
    from served_pipeline import Client, pb, request, status_of
PEERS = SOURCE / "tests/support/peers"
FAILED = ("ABORTED", "UNAVAILABLE")  # by the element that fails, or by the pipeline that stops
CLOCK_LINE = "input float32 1:192:32:1 +output float32 13:12:1\n"


@unittest.skipUnless(HAS_NET and HAS_ONNX, "the plug-in weirnet or the engine onnxruntime is not built")
class Serving(Case):
    def serve(self, *arguments, line=CLOCK_LINE):
        """A server with one model, and its address."""
        process = subprocess.Popen([COMMAND, "serve", "--listen", "127.0.0.1:0", *map(str, arguments)], stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, text=True, stdin=subprocess.DEVNULL, env={**os.environ, **sanitized()})
        self.addCleanup(process.stderr.close)
        self.addCleanup(process.stdout.close)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        first = process.stdout.readline()
        match = re.fullmatch(r"(\S+) +(grpcs?://(\S+)/\S+) +" + line, first)
        self.assertTrue(match, first or process.stderr.read())
        return process, match[2], match[3]

    def end(self, process, number=signal.SIGTERM):
        process.send_signal(number)
        out, errors = process.communicate(timeout=60)
        return process.returncode, out, errors

    def check(self, address, *options):
        return subprocess.run([SOURCE / "tools/check-oip", address, *map(str, options)], capture_output=True, text=True, timeout=200)

    @unittest.skipUnless(HAS_GRPCIO, "grpcio is not installed")
    def test_it_does_what_the_protocol_demands(self):
        process, _, address = self.serve(f"digits={MODEL}")
        done = self.check(address, "--model", "digits")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertEqual(done.stdout.splitlines()[-1], "21 passed, 0 failed")
        self.assertIn("skipped repository lists the model: the server has no model control\n", done.stdout)
        status, out, errors = self.end(process)
        self.assertEqual((status, errors), (0, ""))
        self.assertRegex(out, r"digits-filter +[1-9]")
        _, _, address = self.serve(f"digits={MODEL}", "--model-control")
        self.assertIn("\n22 passed, 0 failed\n", self.check(address, "--model", "digits").stdout)

    @unittest.skipUnless(HAS_GRPCIO, "grpcio is not installed")
    def test_certificates_and_tokens_let_clients_in(self):
        pki, tokens = self.folder / "pki", self.folder / "tokens"
        self.good(weir("pki", "init", pki))
        for name in ("localhost", "client"):
            self.good(weir("pki", "issue", name, "--dir", pki, "--san", "127.0.0.1"))
        tokens.write_text("secret\n")
        _, url, address = self.serve(f"digits={MODEL}", "--tls-cert", pki / "localhost.pem", "--tls-key", pki / "localhost.key", "--tls-ca",
                                     pki / "ca.pem", "--token-file", tokens)
        self.assertTrue(url.startswith("grpcs://"))
        certificate = ("--ca", pki / "ca.pem", "--cert", pki / "client.pem", "--key", pki / "client.key")
        for options, passes in (((*certificate, "--token-file", tokens), True), (certificate, False),
                                (("--ca", pki / "ca.pem", "--token-file", tokens), False), ((), False)):
            done = self.check(address, *options)
            self.assertEqual(done.returncode == 0, passes, f"{options}: {done.stdout}")

    @unittest.skipUnless(HAS_GRPCIO, "grpcio is not installed")
    def test_a_new_certificate_is_used_without_a_restart(self):
        pki = self.folder / "pki"
        self.good(weir("pki", "init", pki))
        self.good(weir("pki", "issue", "old.example", "--dir", pki, "--san", "127.0.0.1"))
        _, _, address = self.serve(f"digits={MODEL}", "--tls-cert", pki / "old.example.pem", "--tls-key", pki / "old.example.key")
        host, port = address.split(":")
        context = ssl.create_default_context(cafile=pki / "ca.pem")
        context.set_alpn_protocols(["h2"])

        def names():
            try:
                with socket.create_connection((host, int(port)), 10) as plain, context.wrap_socket(plain, server_hostname=host) as connection:
                    return [value for _, value in connection.getpeercert()["subjectAltName"]]
            except (ssl.SSLError, ConnectionError):  # between the key and the certificate
                return []
        self.assertIn("old.example", names())
        self.good(weir("pki", "issue", "new.example", "--dir", pki, "--san", "127.0.0.1"))
        for extension in ("key", "pem"):
            (pki / f"new.example.{extension}").rename(pki / f"old.example.{extension}")
        end = time.monotonic() + 60
        while "new.example" not in names():
            self.assertLess(time.monotonic(), end)
        self.assertEqual(self.check(address, "--ca", pki / "ca.pem").returncode, 0)

    def test_a_path_is_read_as_it_is(self):
        path = self.folder / "it's \"a\" model.onnx"
        path.write_bytes(MODEL.read_bytes())
        self.assertEqual(self.end(self.serve(f"digits={path}")[0])[0], 0)

    @unittest.skipUnless(has_engine("oip"), "the engine oip is not built")
    def test_requests_of_an_open_axis_share_batches(self):
        path = self.folder / "double.onnx"
        path.write_bytes(onnx_writer.model([("Mul", ["x", "two"], "y")], {"two": np.full((1,), 2, np.float32)}, [("x", ("n", 4))],
                                           [("y", ("n", 4))]))
        process, url, _ = self.serve(path, "--batch", 4, "--batch-wait", 50000, "--metrics=127.0.0.1:0", line="input float32 4:1 +output float32 4:1\n")
        figures = process.stdout.readline().split()[1]
        frames = np.random.default_rng(1).normal(size=(40, 4)).astype(np.float32)
        (self.folder / "in").write_bytes(frames.tobytes())
        self.good(weir("run", f"filesrc location={self.folder}/in blocksize=16 ! application/octet-stream,framerate=30/1 ! "
                              "tensor_converter input-dim=4:1 input-type=float32 ! "
                              f"tensor_filter framework=oip model={url} workers=4 ! filesink location={self.folder}/out"))
        np.testing.assert_array_equal(np.fromfile(self.folder / "out", np.float32).reshape(-1, 4), 2 * frames)
        with urllib.request.urlopen(figures, timeout=60) as response:
            batches = re.search(r'weir_batches_total\{model="double",element="tensor_filter"\} (\d+)', response.read().decode())
        self.assertLess(int(batches[1]), len(frames))
        self.assertEqual(self.end(process)[0], 0)

    def test_a_model_that_cannot_run_in_batches_is_served_without_them(self):
        path = self.folder / "open.onnx"
        path.write_bytes(onnx_writer.model([("Mul", ["x", "two"], "y")], {"two": np.full((1,), 2, np.float32)}, [("x", ("n", 4))],
                                           [("y", ("n", 4))]))
        process, _, _ = self.serve(f"digits={MODEL}", f"open={path}", "--batch", 8, "--metrics=127.0.0.1:0")
        self.assertIn("input float32 4:1", process.stdout.readline())
        page = process.stdout.readline().split()[1]
        batched, end = [], time.monotonic() + 60
        while not batched:  # the figures come with the caps of the requests
            self.assertLess(time.monotonic(), end)
            with urllib.request.urlopen(page, timeout=60) as response:
                batched = re.findall(r'weir_batches_total\{model="(\w+)"', response.read().decode())
        self.assertEqual(batched, ["open"])
        status, _, errors = self.end(process)
        self.assertEqual(status, 0, errors)
        self.assertIn("warning from digits-filter: WEIR-3013: the model cannot run 8 frames at once; digits is served without batches\n", errors)
        self.assertIn(f"fix: weir serve digits={MODEL}\n", errors)

    def script(self, name, body, start="pass"):
        """A model in Python that begins with `start`, and answers each number with its double, after `body` has seen the numbers."""
        path = self.folder / name
        path.write_text(f"""
import os
import time
import numpy as np
from weir import TensorShape
HERE = {str(self.folder)!r}
{start}
class CustomFilter:
    def getInputDim(self):
        return [TensorShape([4, 1], np.float32)]
    def getOutputDim(self):
        return [TensorShape([4, 1], np.float32)]
    def invoke(self, inputs):
        x = inputs[0]
        {body}
        return [x * 2]
""")
        return path

    def client(self, address, model):
        client = Client(address)
        self.addCleanup(client.close)
        client.wait_until_ready(model)
        return client

    @unittest.skipUnless(HAS_GRPCIO and has_engine("python3"), "grpcio or the engine python3 is not there")
    def test_a_model_whose_pipeline_fails_comes_back_and_is_unavailable_until_then(self):
        stopped = self.folder / "stopped"  # while it is there, the model does not start
        picky = self.script("picky.py", "assert x[0] != 13, 'unlucky'", "assert not os.path.exists(HERE + '/stopped')")
        calm = self.script("calm.py", "pass")
        process, _, address = self.serve(picky, calm, line="input float32 4:1.* +output float32 4:1.*\n")
        client = self.client(address, "picky")
        client.wait_until_ready("calm")
        health, whole = (client.channel.unary_stream("/grpc.health.v1.Health/Watch")(service, timeout=240) for service in (b"\x0a\x05picky", b""))
        self.assertEqual([next(health), next(whole)], [b"\x08\x01"] * 2)
        one = np.ones((1, 4), np.float32)
        stopped.touch()
        self.assertIn(status_of(lambda: client.infer(request("picky", 13 * one)))[0], FAILED)
        self.assertEqual([next(health), next(whole)], [b"\x08\x02"] * 2)
        self.assertEqual(status_of(lambda: client.infer(request("picky", one))),
                         ("UNAVAILABLE", "the pipeline of the model picky does not run"))
        self.assertEqual(client.infer(request("calm", one)).raw_output_contents[0], (2 * one).tobytes())
        stopped.unlink()
        self.assertEqual([next(health), next(whole)], [b"\x08\x01"] * 2)
        self.assertEqual(client.infer(request("picky", one)).raw_output_contents[0], (2 * one).tobytes())
        status, _, errors = self.end(process)
        self.assertEqual(status, 0, errors)
        self.assertIn("unlucky", errors)
        self.assertIn("weir: the model picky is started again in 1 s\n", errors)

    def health_client(self, address, service):
        """The lines of a client of grpc-js and grpc-health-check."""
        node = shutil.which("node")
        if not node or not (PEERS / "node_modules/grpc-health-check").is_dir():
            self.skipTest("the clients of other projects are not installed: tools/setup --peers")
        process = subprocess.Popen([node, PEERS / "health_client.js", address, service], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        for undo in (process.stdout.close, process.wait, process.stdin.close):
            self.addCleanup(undo)
        return process.stdout

    @unittest.skipUnless(HAS_GRPCIO and has_engine("python3"), "grpcio or the engine python3 is not there")
    def test_a_health_client_of_another_project_follows_a_model(self):
        picky = self.script("picky.py", "assert x[0] != 13, 'unlucky'")
        _, _, address = self.serve(picky, self.script("calm.py", "pass"), line="input float32 4:1.* +output float32 4:1.*\n")
        client = self.client(address, "picky")
        other, calm, model = (self.health_client(address, service) for service in ("other", "calm", "picky"))
        self.assertEqual([other.readline(), other.readline()], ["check code 5\n", "watch SERVICE_UNKNOWN\n"])
        for lines in (calm, model):
            self.assertEqual([lines.readline(), lines.readline()], ["check SERVING\n", "watch SERVING\n"])
        self.assertIn(status_of(lambda: client.infer(request("picky", np.full((1, 4), 13, np.float32))))[0], FAILED)
        self.assertEqual([model.readline(), model.readline()], ["watch NOT_SERVING\n", "watch SERVING\n"])

    @unittest.skipUnless(HAS_GRPCIO and has_engine("python3"), "grpcio or the engine python3 is not there")
    def test_a_server_whose_only_model_fails_keeps_its_address(self):
        picky = self.script("picky.py", "assert x[0] != 13, 'unlucky'")
        process, _, address = self.serve(picky, line="input float32 4:1.* +output float32 4:1.*\n")
        client = self.client(address, "picky")
        one = np.ones((1, 4), np.float32)
        self.assertIn(status_of(lambda: client.infer(request("picky", 13 * one)))[0], FAILED)
        while "is started again" not in process.stderr.readline():
            self.assertIsNone(process.poll())
        host, port = address.split(":")
        end = time.monotonic() + 60
        while time.monotonic() < end:  # until it listens again: gRPC's clients wait long after a refusal
            with contextlib.suppress(ConnectionRefusedError), socket.create_connection((host, int(port)), 10):
                break
        response = self.client(address, "picky").infer(request("picky", one))
        self.assertEqual(response.raw_output_contents[0], (2 * one).tobytes())
        self.assertEqual(self.end(process)[0], 0)

    @unittest.skipUnless(HAS_GRPCIO and has_engine("python3"), "grpcio or the engine python3 is not there")
    def test_waits_grow_while_a_model_fails(self):
        fragile = self.script("fragile.py", "os.rename(os.path.join(HERE, 'fragile.py'), os.path.join(HERE, 'gone')); raise ValueError('gone')")
        process, _, address = self.serve(fragile, line="input float32 4:1.* +output float32 4:1.*\n")
        client = self.client(address, "fragile")
        self.assertIn(status_of(lambda: client.infer(request("fragile", np.ones((1, 4), np.float32))))[0], FAILED)
        lines = []
        health = client.channel.unary_unary("/grpc.health.v1.Health/Check")
        while sum("is started again" in line for line in lines) < 3:
            lines.append(process.stderr.readline())
            self.assertTrue(lines[-1], lines)
            if "is started again" in lines[-1]:  # the connection stays
                self.assertEqual(status_of(lambda: client.infer(request("fragile", np.ones((1, 4), np.float32)))),
                                 ("UNAVAILABLE", "the pipeline of the model fragile does not run"))
                self.assertEqual([health(service, timeout=30) for service in (b"", b"\x0a\x07fragile")], [b"\x08\x02"] * 2)
                self.assertFalse(client.call("ServerReady", pb.ServerReadyRequest()).ready)
        waits = [line for line in lines if "started again" in line]
        self.assertEqual(waits, [f"weir: the model fragile is started again in {seconds} s\n" for seconds in (1, 2, 4)])
        self.assertIn("ValueError: gone", "".join(lines))
        self.assertEqual(self.end(process)[0], 0)  # while it waits

    def in_flight(self, figures):
        with urllib.request.urlopen(figures, timeout=60) as response:
            return int(re.search(r"weir_requests_in_flight\{[^}]*\} (\d+)", response.read().decode())[1])

    @unittest.skipUnless(HAS_GRPCIO and has_engine("python3"), "grpcio or the engine python3 is not there")
    def test_a_signal_lets_the_request_in_work_end_and_refuses_those_that_wait(self):
        for name in ("begun", "gate"):
            os.mkfifo(self.folder / name)
        slow = self.script("slow.py", "open(os.path.join(HERE, 'begun'), 'w').close(); open(os.path.join(HERE, 'gate')).close()")
        process, _, address = self.serve(slow, "--metrics=127.0.0.1:0", line="input float32 4:1.* +output float32 4:1.*\n")
        figures = process.stdout.readline().split()[1]
        client = self.client(address, "slow")
        one = np.ones((1, 4), np.float32)
        calls = [client.stub.ModelInfer.future(request("slow", one), timeout=60) for _ in range(5)]
        with open(self.folder / "begun", encoding="ascii"):  # the first is in the model
            pass
        end = time.monotonic() + 60
        while self.in_flight(figures) < len(calls):
            self.assertLess(time.monotonic(), end, "not all requests have come")
        process.send_signal(signal.SIGTERM)
        while status_of(lambda: client.infer(request("slow", one), timeout=1))[0] != "UNAVAILABLE":
            self.assertLess(time.monotonic(), end, "a new request is not refused")
        with open(self.folder / "gate", "w", encoding="ascii"):
            pass
        ends = [status_of(call.result) for call in calls]
        self.assertEqual([code for code, _ in ends].count("OK"), 1, ends)
        self.assertEqual(next(end[1] for end in ends if end[0] == "OK").raw_output_contents[0], (2 * one).tobytes())
        self.assertEqual({end for end in ends if end[0] != "OK"}, {("UNAVAILABLE", "the pipeline of the model slow was stopped")})
        out, errors = process.communicate(timeout=60)
        self.assertEqual((process.returncode, errors), (0, ""), out)

    @unittest.skipUnless(HAS_GRPCIO and has_engine("python3"), "grpcio is not installed, or the engine python3 not built")
    def test_a_model_that_does_not_end_keeps_no_server(self):
        """It waits for a pipe that has no writer. The signals: one, whose time is up, and two."""
        for count in (1, 2):
            with self.subTest(signals=count):
                for name in ("begun", "gate"):
                    (self.folder / name).unlink(missing_ok=True)
                    os.mkfifo(self.folder / name)
                hung = self.script("hung.py", "open(os.path.join(HERE, 'begun'), 'w').close(); open(os.path.join(HERE, 'gate')).close()")
                process, _, address = self.serve(hung, line="input float32 4:1.* +output float32 4:1.*\n")
                client, message = self.client(address, "hung"), request("hung", np.ones((1, 4), np.float32))
                call = client.stub.ModelInfer.future(message, timeout=120)
                with open(self.folder / "begun", encoding="ascii"):
                    pass
                process.send_signal(signal.SIGTERM)
                while count == 2 and status_of(lambda: client.infer(message, timeout=1))[0] != "UNAVAILABLE":  # it has seen the first
                    pass
                if count == 2:
                    process.send_signal(signal.SIGTERM)
                out, errors = process.communicate(timeout=60)
                self.assertIn("weir: a model did not end its request in time, which is aborted\n", errors)
                self.assertIn("Ledger\n", out)
                self.assertGreater(process.returncode, 0)
                self.assertEqual(status_of(call.result)[0], "UNAVAILABLE")

    @unittest.skipUnless(HAS_GRPCIO and has_engine("python3"), "grpcio is not installed, or the engine python3 not built")
    def test_a_model_that_fails_while_another_request_does_not_end_keeps_no_server(self):
        for name in ("begun", "gate"):
            os.mkfifo(self.folder / name)
        model = self.script("model.py", "assert x[0] != 13, 'unlucky'; "
                            "open(os.path.join(HERE, 'begun'), 'w').close(); open(os.path.join(HERE, 'gate')).close()")
        process, _, address = self.serve(model, "--workers", 2, line="input float32 4:1.* +output float32 4:1.*\n")
        client, one = self.client(address, "model"), np.ones((1, 4), np.float32)
        hung = client.stub.ModelInfer.future(request("model", one), timeout=120)
        with open(self.folder / "begun", encoding="ascii"):
            pass
        self.assertIn(status_of(lambda: client.infer(request("model", 13 * one)))[0], FAILED)
        self.assertIn("unlucky", process.stderr.readline())  # it stops the pipeline, which waits for the other request
        process.send_signal(signal.SIGTERM)
        _, errors = process.communicate(timeout=60)
        self.assertIn("weir: a model did not end its request in time, which is aborted\n", errors)
        self.assertGreater(process.returncode, 0)
        self.assertEqual(status_of(hung.result)[0], "UNAVAILABLE")

    @unittest.skipUnless(HAS_GRPCIO, "grpcio is not installed")
    def test_clients_unload_and_load_models_where_that_is_allowed(self):
        process, _, address = self.serve(f"digits={MODEL}", "--model-control")
        client = self.client(address, "digits")
        named = b"\x12\x06digits"  # field 2

        def call(method, message):
            return status_of(lambda: client.channel.unary_unary(f"/inference.GRPCInferenceService/{method}")(message, timeout=30))
        message = request("digits", np.zeros((1, 32, 192, 1), np.float32))
        tensor = client.call("ModelMetadata", pb.ModelMetadataRequest(name="digits")).inputs[0]
        message.inputs[0].name, message.inputs[0].shape[:] = tensor.name, tensor.shape
        before = client.infer(message).raw_output_contents[0]
        self.assertIn("model_repository", client.call("ServerMetadata", pb.ServerMetadataRequest()).extensions)
        self.assertEqual(call("RepositoryIndex", b""), ("OK", b"\x0a\x12\x0a\x06digits\x12\x011\x1a\x05READY"))
        self.assertEqual(call("RepositoryModelUnload", named), ("OK", b""))
        self.assertEqual(status_of(lambda: client.infer(message)), ("UNAVAILABLE", "the model digits is unloaded"))
        self.assertFalse(client.call("ModelReady", pb.ModelReadyRequest(name="digits")).ready)
        self.assertIn(b"UNAVAILABLE\x22\x08unloaded", call("RepositoryIndex", b"")[1])
        self.assertEqual(call("RepositoryIndex", b"\x10\x01"), ("OK", b""))  # those that are ready
        code, text = call("RepositoryModelLoad", named + b"\x1a\x04\x0a\x02ab")
        self.assertEqual((code, text), ("INVALID_ARGUMENT", "the server loads models with its own settings and does not accept parameters"))
        self.assertEqual(call("RepositoryModelLoad", b"\x12\x05other")[0], "NOT_FOUND")
        self.assertEqual(call("RepositoryModelLoad", b"\x12\xff")[0], "INVALID_ARGUMENT")
        self.assertEqual(call("RepositoryModelLoad", named), ("OK", b""))
        self.assertEqual(client.infer(message).raw_output_contents[0], before)
        self.assertEqual(self.end(process)[0], 0)

    @unittest.skipUnless(HAS_GRPCIO, "grpcio is not installed")
    def test_clients_control_no_model_by_default(self):
        _, _, address = self.serve(f"digits={MODEL}")
        client = self.client(address, "digits")
        for method in ("RepositoryIndex", "RepositoryModelLoad", "RepositoryModelUnload"):
            call = client.channel.unary_unary(f"/inference.GRPCInferenceService/{method}")
            self.assertEqual(status_of(lambda call=call: call(b"\x12\x06digits", timeout=30)),
                             ("UNIMPLEMENTED", "clients may not load or unload models on this server: start it with weir serve --model-control, or set model-control=true of tensor_query_serversrc"))
        self.assertNotIn("model_repository", client.call("ServerMetadata", pb.ServerMetadataRequest()).extensions)

    def test_both_signals_end_it(self):
        for number in (signal.SIGINT, signal.SIGTERM):
            status, out, errors = self.end(self.serve(f"digits={MODEL}")[0], number)
            self.assertEqual((status, errors), (0, ""))
            self.assertIn("Ledger\n", out)

    def test_figures_are_served_to_this_machine(self):
        process, _, _ = self.serve(f"digits={MODEL}", f"other={MODEL}", "--metrics=127.0.0.1:0")
        process.stdout.readline()  # other
        address = re.fullmatch(r"metrics +(http://127\.0\.0\.1:\d+)/metrics\n", process.stdout.readline())[1]
        with urllib.request.urlopen(f"{address}/metrics", timeout=60) as response:
            self.assertEqual(response.headers["Content-Type"], "text/plain; version=0.0.4; charset=utf-8")
            page = response.read().decode()
        self.assertIn('# TYPE weir_requests_received_total counter\n'
                      'weir_requests_received_total{model="digits",element="tensor_query_serversrc"} 0\n', page)
        # Of the address: a sum over models would count each call several times.
        self.assertEqual(re.findall("^weir_calls_refused_total.*", page, re.MULTILINE), ["weir_calls_refused_total 0"])
        self.assertIn('weir_dropped_total{model="digits",element="tensor_filter",reason="error"} 0\n', page)
        for line in page.splitlines():
            self.assertRegex(line, r'^(# (HELP|TYPE) weir_\w+ .+|weir_\w+(\{(\w+="[^"]*",?)+\})? -?[\d.e+-]+)$')
        families = re.findall(r"^# TYPE (\S+)", page, re.MULTILINE)
        self.assertEqual(len(families), len(set(families)))
        with self.subTest("promtool"):
            self.check_with_promtool(page)
        for path, method, status in (("/", "GET", 404), ("/metrics", "POST", 405)):
            with self.assertRaises(urllib.error.HTTPError) as refused:
                urllib.request.urlopen(urllib.request.Request(address + path, method=method, data=b"" if method == "POST" else None), timeout=60)
            self.assertEqual(refused.exception.code, status)
            refused.exception.close()

    def test_slow_readers_of_the_figures_block_no_other(self):
        process, _, _ = self.serve(f"digits={MODEL}", "--metrics=127.0.0.1:0")
        page = process.stdout.readline().split()[1]
        port = int(re.search(r":(\d+)/", page)[1])
        def descriptors():
            """Of the page's port only: the server opens others while it starts."""
            rows = [line.split() for line in pathlib.Path("/proc/net/tcp").read_text().splitlines()[1:]]
            sockets = {f"socket:[{row[9]}]" for row in rows if int(row[1].split(":")[1], 16) == port}
            found = 0
            for descriptor in pathlib.Path(f"/proc/{process.pid}/fd").iterdir():
                with contextlib.suppress(OSError):  # it was closed meanwhile
                    found += os.readlink(descriptor) in sockets
            return found
        before = descriptors()
        self.assertEqual(before, 1)
        with contextlib.ExitStack() as opened:
            slow = [opened.enter_context(socket.create_connection(("127.0.0.1", port), 10)) for _ in range(40)]
            with urllib.request.urlopen(page, timeout=60) as response:
                self.assertIn(b"weir_build_info", response.read())
            self.assertLess(descriptors() - before, len(slow) // 2)
            for one in slow[:24]:
                self.assertEqual(one.recv(1), b"")
            begun, last = time.monotonic(), slow[-1]
            with contextlib.suppress(OSError):  # its time is that of the whole request, not of each byte
                while time.monotonic() < begun + 60 and not select.select([last], [], [], 0.5)[0]:
                    last.sendall(b"G")
            self.assertLess(time.monotonic(), begun + 60)

    def check_with_promtool(self, page):
        if not shutil.which("promtool"):
            self.skipTest("promtool is not installed: apt-get install prometheus")
        done = subprocess.run(["promtool", "check", "metrics"], input=page, capture_output=True, text=True, timeout=60)
        self.assertEqual((done.returncode, done.stdout, done.stderr), (0, "", ""))
        # The same for a page that is wrong.
        broken = page.replace("counter", "gauge")
        self.assertNotEqual(subprocess.run(["promtool", "check", "metrics"], input=broken, capture_output=True, text=True, timeout=60).returncode, 0)

    def test_addresses_of_figures_that_others_reach_are_refused(self):
        for address in ("0.0.0.0:0", "192.0.2.1:1", "unix:/tmp/x"):
            self.refused(weir("serve", MODEL, "--listen", "127.0.0.1:0", f"--metrics={address}"), 1,
                         "WEIR-1004: metrics are served to this machine only", f"offered: --metrics={address}")

    def test_an_address_in_use_and_a_file_that_is_no_model_are_errors(self):
        _, _, address = self.serve(f"digits={MODEL}")
        refused = weir("serve", MODEL, "--listen", address)
        self.refused(refused, 1, address.split(":")[1], "fix: --listen 127.0.0.1:0, which uses a free port")
        self.assertNotIn("port=0", refused.stderr)
        self.assertNotIn("chttp2", refused.stderr, "gRPC's own log")
        broken = self.folder / "broken.onnx"
        broken.write_text("no model")
        self.refused(weir("serve", broken, "--listen", "127.0.0.1:0"), 1, "WEIR-3004", str(broken))

    @unittest.skipUnless(has_engine("oip"), "the engine oip is not built")
    def test_a_pipeline_gets_the_results_of_the_model_itself(self):
        _, url, _ = self.serve(f"digits={MODEL}")
        source = "videotestsrc num-buffers=5 pattern=ball ! video/x-raw,format=GRAY8,width=192,height=32 ! tensor_converter ! " \
                 "tensor_transform mode=typecast option=float32 ! "
        for name, options in (("there", f"framework=oip model={url}"), ("here", f"model={MODEL}")):
            self.good(weir("run", f"{source} tensor_filter {options} ! filesink location={self.folder}/{name}"))
        self.assertEqual((self.folder / "there").read_bytes(), (self.folder / "here").read_bytes())
        self.assertGreater((self.folder / "here").stat().st_size, 0)


if __name__ == "__main__":
    tap_runner.main()
