#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Who may use a pipeline that is served: TLS, certificates of clients, tokens. Certificates are made by the command openssl."""

import pathlib
import re
import shutil
import socket
import subprocess
import tempfile
import time
import unittest

import grpc
import numpy as np

import tap_runner
from served_pipeline import Client, Pipeline, request, status_of

X = np.array([[1, 2, 3, 4]], np.float32)
CAPS = "caps=other/tensor,dimension=(string)4:1,type=(string)float32,framerate=0/1"


@unittest.skipUnless(shutil.which("openssl"), "openssl is not installed")
class Security(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name)
        for authority in ("ca", "other"):
            cls.openssl("req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-days", "1",
                        "-subj", f"/CN={authority}", "-keyout", f"{authority}.key", "-out", f"{authority}.pem")
        for name, authority in (("server", "ca"), ("camera", "ca"), ("guest", "ca"), ("stranger", "other")):
            cls.issue(name, authority)
        help_text = subprocess.run(["openssl", "x509", "-help"], check=True, capture_output=True, text=True).stderr
        # From OpenSSL 3.4 on, -days is 0 or more, and x509 has dates.
        past = ("-not_before", "20200101000000Z", "-not_after", "20200102000000Z") if "-not_after" in help_text else ("-days", "-1")
        cls.issue("late", "ca", validity=past)
        cls.issue("elsewhere", "ca", address="192.0.2.7")

    @classmethod
    def openssl(cls, *words):
        subprocess.run(["openssl", *words], cwd=cls.folder, check=True, capture_output=True)

    @classmethod
    def issue(cls, name, authority, validity=("-days", "1"), address="127.0.0.1"):
        cls.openssl("req", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-subj", f"/CN={name}",
                    "-keyout", f"{name}.key", "-out", f"{name}.csr")
        (cls.folder / f"{name}.ext").write_text(f"subjectAltName=DNS:{name},IP:{address}\n")
        cls.openssl("x509", "-req", "-in", f"{name}.csr", "-CA", f"{authority}.pem", "-CAkey", f"{authority}.key", "-CAcreateserial",
                    *validity, "-extfile", f"{name}.ext", "-out", f"{name}.pem")

    def read(self, name):
        return (self.folder / name).read_bytes()

    def serve(self, options="", name="server"):
        options = options.replace("@", f"{self.folder}/")
        pipeline = Pipeline(f"tensor_query_serversrc protocol=oip port=0 model-name=same tls-cert={self.folder}/{name}.pem "
                            f"tls-key={self.folder}/{name}.key {options} {CAPS} ! tensor_query_serversink")
        self.addCleanup(pipeline.stop)
        self.assertTrue(pipeline.port, "".join(pipeline.lines))
        return pipeline.port

    def client(self, port, authority="ca.pem", name=None, token=None):
        files = (self.read(f"{name}.key"), self.read(f"{name}.pem")) if name else (None, None)
        metadata = [("authorization", f"Bearer {token}")] if token else ()
        client = Client(f"127.0.0.1:{port}", grpc.ssl_channel_credentials(self.read(authority), *files), metadata)
        self.addCleanup(client.close)
        return client

    def code(self, client):
        return status_of(lambda: client.infer(request("same", X), 10))[0]

    def test_tls_is_used_and_plain_connections_fail(self):
        port = self.serve()
        client = self.client(port)
        client.wait_until_ready("same")
        self.assertEqual(client.infer(request("same", X)).raw_output_contents[0], X.tobytes())
        plain = Client(f"127.0.0.1:{port}")
        self.addCleanup(plain.close)
        self.assertEqual(self.code(plain), "UNAVAILABLE")
        self.assertEqual(self.code(self.client(port, "other.pem")), "UNAVAILABLE")

    def test_clients_need_a_certificate_of_the_authority(self):
        port = self.serve("tls-ca=@ca.pem")
        self.client(port, name="camera").wait_until_ready("same")
        self.assertEqual(self.code(self.client(port, name="camera")), "OK")
        self.assertEqual(self.code(self.client(port)), "UNAVAILABLE")
        self.assertEqual(self.code(self.client(port, name="stranger")), "UNAVAILABLE")

    def test_an_expired_certificate_lets_no_client_in(self):
        port = self.serve("tls-ca=@ca.pem")
        self.assertEqual(self.code(self.client(port, name="late")), "UNAVAILABLE")
        self.client(port, name="camera").wait_until_ready("same")
        self.assertEqual(self.code(self.client(port, name="camera")), "OK")

    def test_clients_trust_no_expired_certificate_and_none_of_another_address(self):
        for name, reason in (("late", "(?i)expired|certificate"), ("elsewhere", "(?i)peer name|certificate")):
            code, text = status_of(lambda: self.client(self.serve(name=name)).infer(request("same", X), 10))
            self.assertEqual(code, "UNAVAILABLE", text)
            self.assertRegex(text, reason)

    def handshake(self, port, *options):
        done = subprocess.run(["openssl", "s_client", "-connect", f"127.0.0.1:{port}", "-CAfile", str(self.folder / "ca.pem"), "-alpn", "h2",
                               "-verify_return_error", "-cipher", "DEFAULT@SECLEVEL=0", *options],
                              capture_output=True, text=True, errors="replace", timeout=60, stdin=subprocess.DEVNULL)
        return done.returncode, done.stdout + done.stderr

    def test_old_versions_of_tls_are_refused(self):
        port = self.serve()
        for version in ("-tls1", "-tls1_1"):
            status, text = self.handshake(port, version)
            self.assertNotEqual(status, 0, text)
            self.assertIn("New, (NONE), Cipher is (NONE)", text)
        for version, name in (("-tls1_2", "TLSv1.2"), ("-tls1_3", "TLSv1.3")):
            status, text = self.handshake(port, version)
            self.assertEqual(status, 0, text)
            self.assertRegex(text, rf"New, {name}, Cipher is (?!\(NONE\))")
        self.assertIn("TLSv1.3", self.handshake(port)[1])

    def test_a_server_that_allows_old_versions_of_tls_is_reached(self):
        """That it is the server that refuses them in the test above."""
        other = subprocess.Popen(["openssl", "s_server", "-accept", "127.0.0.1:0", "-cert", "server.pem", "-key", "server.key", "-tls1_1",
                                  "-cipher", "DEFAULT@SECLEVEL=0"], cwd=self.folder, stdout=subprocess.PIPE, stdin=subprocess.PIPE, text=True)
        self.addCleanup(other.wait)
        self.addCleanup(other.stdin.close)
        self.addCleanup(other.stdout.close)
        self.addCleanup(other.kill)
        port = None
        while port is None:
            line = other.stdout.readline()
            self.assertTrue(line, "openssl s_server ended")
            port = re.fullmatch(r"ACCEPT \S+:(\d+)\n", line)
        status, text = self.handshake(port[1], "-tls1_1")
        self.assertEqual(status, 0, text)
        self.assertRegex(text, r"Protocol  : TLSv1\.1")

    def test_others_are_served_while_handshakes_stall_and_these_are_ended(self):
        port = self.serve()
        begins = [b"", b"\x16", b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03"]  # parts of a ClientHello
        stalled, begin = [], time.monotonic()
        for i in range(30):
            stalled.append(socket.create_connection(("127.0.0.1", port), 10))
            self.addCleanup(stalled[-1].close)
            stalled[-1].sendall(begins[i % len(begins)])
        client = self.client(port)
        client.wait_until_ready("same")
        for _ in range(10):
            self.assertEqual(client.infer(request("same", X)).raw_output_contents[0], X.tobytes())
        self.assertLess(time.monotonic() - begin, 15)
        for each in stalled:
            each.settimeout(30)
            try:
                while each.recv(4096):
                    pass
            except ConnectionResetError:
                pass
        # Two seconds, and what a busy machine adds.
        self.assertGreater(time.monotonic() - begin, 1.5)
        self.assertLess(time.monotonic() - begin, 20)
        self.assertEqual(self.code(client), "OK")

    def test_only_named_clients_may_connect(self):
        port = self.serve("tls-ca=@ca.pem tls-peers=camera,door")
        self.client(port, name="camera").wait_until_ready("same")
        self.assertEqual(self.code(self.client(port, name="camera")), "OK")
        self.assertEqual(status_of(lambda: self.client(port, name="guest").infer(request("same", X))),
                         ("PERMISSION_DENIED", "no name of the client's certificate is allowed (tls-peers)"))

    def test_a_token_is_needed(self):
        (self.folder / "tokens").write_text("first-token\nsecond-token\n")
        port = self.serve("token-file=@tokens")
        self.client(port, token="first-token").wait_until_ready("same")
        for token in ("first-token", "second-token"):
            self.assertEqual(self.code(self.client(port, token=token)), "OK")
        for token in (None, "first-tokem", "first-token2", "first", "first-token second-token"):
            self.assertEqual(status_of(lambda: self.client(port, token=token).infer(request("same", X))),
                             ("UNAUTHENTICATED", "a token is needed: metadata authorization: Bearer TOKEN"), token)

    def test_a_key_of_another_certificate_is_an_error(self):
        done = subprocess.run(["gst-launch-1.0", *f"tensor_query_serversrc protocol=oip port=0 tls-cert={self.folder}/server.pem "
                               f"tls-key={self.folder}/camera.key {CAPS} ! tensor_query_serversink".split()],
                              capture_output=True, text=True, timeout=60, stdin=subprocess.DEVNULL)
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("WEIR-1004: the certificate and the key do not belong together", done.stderr)
        self.assertIn(f"offered: tls-cert={self.folder}/server.pem tls-key={self.folder}/camera.key", done.stderr)

    def test_files_that_are_no_certificate_and_no_key_are_errors(self):
        for cert, key, wanted in (("server.key", "server.key", "tls-cert has no certificate"), ("server.pem", "server.pem", "tls-key has no key, or the key has a password")):
            done = subprocess.run(["gst-launch-1.0", *f"tensor_query_serversrc protocol=oip port=0 tls-cert={self.folder}/{cert} "
                                   f"tls-key={self.folder}/{key} {CAPS} ! tensor_query_serversink".split()],
                                  capture_output=True, text=True, timeout=60, stdin=subprocess.DEVNULL)
            self.assertIn(f"WEIR-1004: the file of the property {wanted}", done.stderr)

    def replace(self, **files):
        """Files appear whole: each is renamed into its place."""
        for name, source in files.items():
            (self.folder / "new").write_bytes(self.read(source))
            (self.folder / "new").rename(self.folder / name.replace("_", "."))

    def serial(self, port):
        """The number of the certificate that the server shows."""
        out = subprocess.run(["openssl", "s_client", "-connect", f"127.0.0.1:{port}", "-alpn", "h2"], capture_output=True, input=b"", check=False).stdout
        return subprocess.run(["openssl", "x509", "-noout", "-serial"], input=out, capture_output=True, check=False).stdout

    def test_certificates_are_read_again_when_their_files_change(self):
        self.replace(live_pem="server.pem", live_key="server.key", live_ca="ca.pem")
        port = self.serve("tls-cert=@live.pem tls-key=@live.key tls-ca=@live.ca")
        first = self.client(port, name="camera")
        first.wait_until_ready("same")
        self.assertEqual(self.code(self.client(port, name="stranger")), "UNAVAILABLE")
        before = self.serial(port)
        self.issue("server2", "ca")
        (self.folder / "both.pem").write_bytes(self.read("ca.pem") + self.read("other.pem"))
        self.replace(live_ca="both.pem", live_key="server2.key", live_pem="server2.pem")
        end = time.monotonic() + 60
        while self.serial(port) in (before, b""):  # b"": between the key and the certificate
            self.assertLess(time.monotonic(), end)
        self.assertEqual(self.code(self.client(port, name="stranger")), "OK")
        self.assertEqual(self.code(first), "OK")  # its connection is as it was

    def test_tokens_are_read_again_when_their_file_changes(self):
        (self.folder / "changing").write_text("first-token\n")
        port = self.serve("token-file=@changing")
        first = self.client(port, token="first-token")
        first.wait_until_ready("same")
        (self.folder / "changing").write_text("another-token\n")
        self.assertEqual(self.code(first), "UNAUTHENTICATED")
        self.assertEqual(self.code(self.client(port, token="another-token")), "OK")

    def test_a_token_file_without_a_token_is_an_error(self):
        (self.folder / "empty").write_text("\n")
        done = subprocess.run(["gst-launch-1.0", *f"tensor_query_serversrc protocol=oip port=0 tls-cert={self.folder}/server.pem tls-key="
                               f"{self.folder}/server.key token-file={self.folder}/empty {CAPS} ! tensor_query_serversink".split()],
                              capture_output=True, text=True, timeout=60, stdin=subprocess.DEVNULL)
        self.assertIn("WEIR-1004: the file of the property token-file has no token", done.stderr)


if __name__ == "__main__":
    tap_runner.main()
