#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Tests of `weir pki`: OpenSSL's command reads, verifies and uses what it makes."""

import concurrent.futures
import json
import os
import pathlib
import re
import socket
import stat
import subprocess

import tap_runner
from weir_case import Case, weir


def openssl(*arguments):
    return subprocess.run(["openssl", *map(str, arguments)], capture_output=True, text=True, timeout=60, stdin=subprocess.DEVNULL)


class Pki(Case):
    def authority(self, name="pki", *options):
        self.good(weir("pki", "init", self.folder / name, *options))
        return self.folder / name

    def issue(self, folder, name, *options):
        self.good(weir("pki", "issue", name, "--dir", folder, *options))
        return folder / f"{name}.pem"

    def text_of(self, certificate):
        done = openssl("x509", "-in", certificate, "-noout", "-text")
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def mode(self, path):
        return stat.S_IMODE(path.stat().st_mode)


class Certificates(Pki):
    def test_an_authority_is_one_by_openssl(self):
        folder = self.authority()
        self.assertEqual(openssl("verify", "-x509_strict", "-CAfile", folder / "ca.pem", folder / "ca.pem").returncode, 0)
        text = self.text_of(folder / "ca.pem")
        for part in ("Version: 3", "ASN1 OID: prime256v1", "ecdsa-with-SHA256", "CA:TRUE, pathlen:0", "Certificate Sign, CRL Sign"):
            self.assertIn(part, text)
        self.assertRegex(text, r"X509v3 Basic Constraints: critical\n")
        self.assertRegex(text, r"Subject: CN ?= ?Weir CA [0-9A-F]{8}\n")

    def test_a_certificate_verifies_for_servers_and_clients(self):
        folder = self.authority()
        certificate = self.issue(folder, "server.example", "--san", "10.0.0.5,*.farm.example", "--san", "::1")
        for purpose in ("sslserver", "sslclient"):
            done = openssl("verify", "-x509_strict", "-purpose", purpose, "-CAfile", folder / "ca.pem", certificate)
            self.assertEqual(done.returncode, 0, done.stderr)
        for kind, name, status in (("hostname", "server.example", 0), ("hostname", "a.farm.example", 0), ("ip", "10.0.0.5", 0),
                                   ("ip", "::1", 0), ("hostname", "other.example", 2), ("ip", "10.0.0.6", 2)):
            done = openssl("verify", f"-verify_{kind}", name, "-CAfile", folder / "ca.pem", certificate)
            self.assertEqual(done.returncode, status, f"{name}: {done.stderr}")
        text = self.text_of(certificate)
        self.assertIn("DNS:server.example, IP Address:10.0.0.5, DNS:*.farm.example, IP Address:0:0:0:0:0:0:0:1", text)
        for part in ("ASN1 OID: prime256v1", "CA:FALSE", "Digital Signature\n",
                     "TLS Web Server Authentication, TLS Web Client Authentication"):
            self.assertIn(part, text)
        self.assertRegex(text, r"Subject: CN ?= ?server\.example\n")

    def test_it_is_valid_for_90_days_or_as_many_as_asked_for(self):
        folder = self.authority()
        for name, options, days in (("one", (), 90), ("two", ("--days", 7), 7)):
            certificate = self.issue(folder, name, *options)
            for seconds, status in ((days * 86400 - 600, 0), (days * 86400 + 600, 1)):
                self.assertEqual(openssl("x509", "-in", certificate, "-noout", "-checkend", seconds).returncode, status)

    def test_an_address_as_the_name_is_an_address_in_the_certificate(self):
        folder = self.authority()
        text = self.text_of(self.issue(folder, "192.168.1.7"))
        self.assertRegex(text, r"Subject Alternative Name: *\n +IP Address:192\.168\.1\.7\n")

    def test_serial_numbers_and_keys_differ(self):
        folder = self.authority()
        texts = [self.text_of(self.issue(folder, name)) for name in ("one", "two")]
        serials = {re.search(r"Serial Number:\s+([0-9a-f:]+)", text)[1] for text in texts}
        keys = {re.search(r"pub:\s+([0-9a-f:\s]+)", text)[1] for text in texts}
        self.assertEqual((len(serials), len(keys)), (2, 2))

    def test_a_certificate_of_another_authority_is_not_verified(self):
        folder, other = self.authority(), self.authority("other")
        done = openssl("verify", "-CAfile", other / "ca.pem", self.issue(folder, "server"))
        self.assertEqual(done.returncode, 2)
        self.assertIn("unable to get local issuer certificate", done.stderr)

    def test_a_certificate_cannot_sign_another(self):
        folder = self.authority()
        leaf = self.issue(folder, "leaf")
        below = self.folder / "below"
        below.mkdir()
        (below / "ca.pem").write_bytes(leaf.read_bytes())
        (below / "ca.key").write_bytes(leaf.with_suffix(".key").read_bytes())
        self.refused(weir("pki", "issue", "server", "--dir", below), 1, "WEIR-4001: the certificate is not that of a certificate authority")

    def test_json_names_the_files(self):
        folder = self.authority()
        out = json.loads(self.good(weir("pki", "issue", "server", "--dir", folder, "--san", "10.0.0.5", "--json")))
        self.assertEqual(out["certificate"], str(folder / "server.pem"))
        self.assertEqual(out["key"], str(folder / "server.key"))
        self.assertEqual(out["names"], ["server", "10.0.0.5"])
        self.assertRegex(out["valid_until"], r"^\d{4}-\d\d-\d\d$")


class Files(Pki):
    def test_keys_are_their_owners_alone(self):
        for mask in (0, 0o077):
            before = os.umask(mask)
            try:
                folder = self.authority(f"mask{mask}")
                self.issue(folder, "server")
            finally:
                os.umask(before)
            self.assertEqual(self.mode(folder), 0o700)
            for name, mode in (("ca.key", 0o600), ("server.key", 0o600), ("ca.pem", 0o644), ("server.pem", 0o644)):
                self.assertEqual(self.mode(folder / name), mode, name)

    def test_existing_files_are_not_replaced(self):
        folder = self.authority()
        self.issue(folder, "server")
        before = {path: path.read_bytes() for path in folder.iterdir()}
        self.refused(weir("pki", "init", folder), 1, "WEIR-4010: a file with this name already exists and is not replaced", "ca.key",
                     f"fix: mv {folder}/ca.key {folder}/ca.key.old")
        self.refused(weir("pki", "issue", "server", "--dir", folder), 1, "WEIR-4010", "server.key")
        self.assertEqual({path: path.read_bytes() for path in folder.iterdir()}, before)

    def test_a_key_is_not_left_without_its_certificate(self):
        folder = self.authority()
        (folder / "server.pem").write_text("mine")
        self.refused(weir("pki", "issue", "server", "--dir", folder), 1, "server.pem")
        self.assertEqual(sorted(path.name for path in folder.iterdir()), ["ca.key", "ca.pem", "server.pem"])
        self.assertEqual((folder / "server.pem").read_text(), "mine")

    def test_of_many_at_once_one_writes_the_files(self):
        folder = self.authority()
        with concurrent.futures.ThreadPoolExecutor(8) as threads:
            done = list(threads.map(lambda _: weir("pki", "issue", "server", "--dir", folder), range(8)))
        self.assertEqual(sorted(one.returncode for one in done), [0] + [1] * 7)
        key = openssl("pkey", "-in", folder / "server.key", "-pubout").stdout
        self.assertEqual(openssl("x509", "-in", folder / "server.pem", "-noout", "-pubkey").stdout, key)
        self.assertEqual(len(list(folder.iterdir())), 4)

    def test_folders_that_cannot_be_written_to_are_errors(self):
        (self.folder / "file").write_text("")
        for place in (self.folder / "file", self.folder / "file" / "pki", pathlib.Path("/proc/pki")):
            self.refused(weir("pki", "init", place), 1, "WEIR-4010: the folder cannot be created", str(place))
        self.refused(weir("pki", "init", "/proc"), 1, "WEIR-4010: a file cannot be written", "/proc/ca.key")
        folder = self.authority()
        if os.geteuid() != 0:
            folder.chmod(0o500)
            self.addCleanup(folder.chmod, 0o700)
            self.refused(weir("pki", "issue", "server", "--dir", folder), 1, "WEIR-4010", "server.key")

    def test_an_authority_that_cannot_be_read_is_an_error(self):
        self.refused(weir("pki", "issue", "server", "--dir", self.folder), 1,
                     "WEIR-4001: a file of the certificate authority cannot be read", f"offered: {self.folder}/ca.pem",
                     f"fix: weir pki init {self.folder}")
        folder, other = self.authority(), self.authority("other")
        (folder / "ca.key").write_bytes((other / "ca.key").read_bytes())
        self.refused(weir("pki", "issue", "server", "--dir", folder), 1, "the key of the authority belongs to another certificate")
        (folder / "ca.key").write_text("no key")
        self.refused(weir("pki", "issue", "server", "--dir", folder), 1, "the authority cannot be read")
        self.assertEqual(len(list(folder.iterdir())), 2)

    def test_an_encrypted_key_is_not_asked_for_its_passphrase(self):
        folder = self.authority()
        done = openssl("pkey", "-in", folder / "ca.key", "-aes256", "-passout", "pass:secret", "-out", folder / "new.key")
        self.assertEqual(done.returncode, 0, done.stderr)
        (folder / "new.key").replace(folder / "ca.key")
        self.refused(weir("pki", "issue", "server", "--dir", folder), 1, "the authority cannot be read")

    def test_names_that_certificates_cannot_have_are_refused(self):
        folder = self.authority()
        for name in ("", "../server", "a/b", ".hidden", "a..b", "a b", "-a" * 40, "x" * 65, "ä", "a,DNS:b", "*.example", "1.2.3.4/8",
                     "a\nb", "a."):
            self.refused(weir("pki", "issue", "--dir", folder, "--", name), 1, "WEIR-1004: a certificate cannot have this name")
        self.refused(weir("pki", "issue", "ca", "--dir", folder), 1, "WEIR-1004: this name is the authority's own")
        for name in ("a b", "*", "a.*", "http://a", "a:8001", "email:x", "fe80::1%eth0"):
            self.refused(weir("pki", "issue", "server", "--dir", folder, "--san", name), 1,
                         "WEIR-1004: --san has a name that a certificate cannot have", f"offered: '{name}'")
        self.assertEqual(len(list(folder.iterdir())), 2)

    def test_days_beyond_the_authority_are_refused_with_how_many_there_are(self):
        folder = self.authority("short", "--days", 10)
        done = weir("pki", "issue", "server", "--dir", folder)
        self.refused(done, 1, "WEIR-1004: the certificate would be valid for longer than its authority", "offered: --days 90")
        days = re.search(r"fix: --days (\d+)", done.stderr)[1]
        self.assertEqual(days, "9")
        self.issue(folder, "server", "--days", days)
        for wrong in ("0", "-1", "x", "40000"):
            self.refused(weir("pki", "issue", "b", "--dir", folder, "--days", wrong), 2)
        for words in (("pki",), ("pki", "init"), ("pki", "issue"), ("pki", "renew", "a")):
            self.refused(weir(*words), 2)


class Connections(Pki):
    """openssl s_server with a certificate of `weir pki`, and openssl s_client."""

    def setUp(self):
        super().setUp()
        self.mine, self.other = self.authority("mine"), self.authority("other")
        for folder in (self.mine, self.other):
            self.issue(folder, "localhost", "--san", "127.0.0.1")
            self.issue(folder, "client")

    def serve(self, *options):
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            port = free.getsockname()[1]
        server = subprocess.Popen(["openssl", "s_server", "-accept", f"127.0.0.1:{port}", "-cert", self.mine / "localhost.pem", "-key",
                                   self.mine / "localhost.key", "-tls1_3", "-www", *map(str, options)],
                                  stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        self.addCleanup(server.stdout.close)
        self.addCleanup(server.wait)
        self.addCleanup(server.kill)
        while "ACCEPT" not in (line := server.stdout.readline()):
            self.assertNotEqual(line, "", "openssl s_server did not start")
        return port

    def connect(self, port, *options):
        done = subprocess.run(["openssl", "s_client", "-connect", f"127.0.0.1:{port}", "-verify_return_error", "-quiet", "-no_ign_eof",
                               *map(str, options)], input="GET / HTTP/1.0\r\n\r\n", capture_output=True, text=True, timeout=60)
        return "HTTP/1.0 200" in done.stdout, done.stdout + done.stderr

    def test_a_chain_is_accepted_and_one_of_another_authority_is_not(self):
        port = self.serve()
        good, text = self.connect(port, "-ign_eof", "-CAfile", self.mine / "ca.pem", "-verify_hostname", "localhost")
        self.assertTrue(good, text)
        for options in (("-CAfile", self.other / "ca.pem"), ("-CAfile", self.mine / "ca.pem", "-verify_hostname", "elsewhere")):
            good, text = self.connect(port, "-ign_eof", *options)
            self.assertFalse(good, text)
            self.assertIn("verify error", text)

    def test_a_server_knows_its_clients(self):
        port = self.serve("-Verify", "1", "-verify_return_error", "-CAfile", self.mine / "ca.pem")
        trusted = ("-ign_eof", "-CAfile", self.mine / "ca.pem")
        good, text = self.connect(port, *trusted, "-cert", self.mine / "client.pem", "-key", self.mine / "client.key")
        self.assertTrue(good, text)
        for options in ((), ("-cert", self.other / "client.pem", "-key", self.other / "client.key")):
            good, text = self.connect(port, *trusted, *options)
            self.assertFalse(good, text)


if __name__ == "__main__":
    tap_runner.main()
