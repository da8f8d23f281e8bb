#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""weir models: the catalogue, and files that are fetched from a server of this test."""

import functools
import hashlib
import http.server
import json
import os
import shutil
import ssl
import subprocess
import threading

import tap_runner
from weir_case import COMMAND, SOURCE, Case, weir

CATALOGUE = json.loads((SOURCE / "models" / "catalogue.json").read_text())
CARDS = SOURCE / "models" / "cards"


class Quiet(http.server.SimpleHTTPRequestHandler):
    """Serves files; the handlers of a test come first."""
    protocol_version = "HTTP/1.1"
    handlers = {}

    def log_message(self, *_):
        pass

    def do_GET(self):
        self.handlers.get(self.path, lambda _: super(Quiet, self).do_GET())(self)


class Catalogue(Case):
    def run_models(self, *words, cards=CARDS):
        return weir("models", *words, WEIR_CARD_PATH=str(cards), WEIR_MODELS=str(self.folder / "models"))

    def test_lists_every_model_with_task_size_and_licence(self):
        text = self.good(self.run_models("list"))
        for model in CATALOGUE["models"]:
            line = next(line for line in text.splitlines() if line.startswith(model["name"] + " "))
            self.assertIn(model["task"], line)
            self.assertIn(model["licence"], line)
            self.assertNotIn("downloaded", line)

    def test_small_models_have_a_size_too(self):
        text = self.good(self.run_models("list"))
        self.assertRegex(text, r"mnist .* 26 kB ")
        self.assertNotIn(" 0.0 MB", text)

    def test_has_at_least_25_models_without_copyleft(self):
        self.assertGreaterEqual(len(CATALOGUE["models"]), 25)
        names = [model["name"] for model in CATALOGUE["models"]]
        self.assertEqual(len(names), len(set(names)))
        for model in CATALOGUE["models"]:
            self.assertNotRegex(model["licence"], "GPL")
            for file in model["files"]:
                self.assertRegex(file["sha256"], "^[0-9a-f]{64}$")
                self.assertTrue(file.get("url", "").startswith("https://") or file.get("npm"))

    def test_cards_belong_to_the_files(self):
        for model in CATALOGUE["models"]:
            if "card" in model:
                card = json.loads((CARDS / model["card"]).read_text())
                self.assertIn(card["sha256"], [file["sha256"] for file in model["files"]], model["name"])
                self.assertEqual(card["model"], model["files"][0]["name"], model["name"])

    def test_info_shows_address_and_digest(self):
        text = self.good(self.run_models("info", "yolox-nano"))
        file = next(m for m in CATALOGUE["models"] if m["name"] == "yolox-nano")["files"][0]
        self.assertIn(file["url"], text)
        self.assertIn(file["sha256"], text)
        self.assertIn("weir try yolox-nano", text)
        info = json.loads(self.good(self.run_models("info", "--json", "yolox-nano")))
        self.assertEqual(info["files"][0]["sha256"], file["sha256"])
        self.assertFalse(info["fetched"])

    def test_the_command_fits_what_the_model_takes(self):
        commands = {model["name"]: model["command"] for model in json.loads(self.good(self.run_models("list", "--json")))["models"]}
        file = self.folder / "models" / "yamnet" / "yamnet.tflite"
        self.assertIn(f" filesrc location=sound.wav ! decodebin ! audioconvert ! ", commands["yamnet"])
        self.assertIn(f" ! tensor_filter model={file} ! ", commands["yamnet"])
        for model in CATALOGUE["models"]:
            name, takes_photos = model["name"], model["task"] in ("classification", "detection", "pose", "segmentation", "text")
            self.assertEqual(commands[name] == f"weir try {name} photo.jpg", takes_photos, name)
            if not takes_photos and "line" not in model:
                self.assertEqual(commands[name], f"weir inspect {self.folder}/models/{name}/{model['files'][0]['name']}")
        self.assertIn(commands["yamnet"], self.good(self.run_models("info", "yamnet")))

    def test_an_unknown_name_gets_the_nearest(self):
        self.refused(self.run_models("info", "yolox-nan"), 1, "WEIR-4001", "did you mean yolox-nano?")
        self.refused(self.run_models("get", "zzz"), 1, "weir models list")
        self.refused(self.run_models(), 2)

    def test_a_missing_or_damaged_catalogue_is_an_error(self):
        cards = self.folder / "cards"
        cards.mkdir()
        for text in ("", "[]", '{"models": [{"name": "x"}]}', '{"models": [{"name": "../x", "files": [{}]}]}',
                     *('{"models": [{"name": "x", "files": [{"name": "%s", "url": "%s", "sha256": "%s", "bytes": %s}]}]}' %
                       (name, url, "0" * 64, size)
                       for name, url, size in (("../y", "https://x", 1), ("y", "http://x", 1), ("y", "https://x", 0)))):
            (self.folder / "catalogue.json").write_text(text)
            self.refused(self.run_models("list", cards=cards), 1, "WEIR-3009", "catalogue.json")


class Fetching(Case):
    def setUp(self):
        super().setUp()
        if not shutil.which("curl"):
            self.skipTest("curl is not installed")
        served = self.folder / "served"
        served.mkdir()
        (served / "net.onnx").write_bytes(b"the model" * 1000)
        pki = self.folder / "pki"
        self.good(weir("pki", "init", pki))
        self.good(weir("pki", "issue", "server", "--dir", pki, "--san", "127.0.0.1"))
        self.authority = pki / "ca.pem"
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        context.load_cert_chain(pki / "server.pem", pki / "server.key")
        self.handlers = {}
        handler = type("Handler", (Quiet,), {"handlers": self.handlers})
        server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(handler, directory=str(served)))
        server.daemon_threads = True
        server.socket = context.wrap_socket(server.socket, server_side=True)
        threading.Thread(target=server.serve_forever, daemon=True).start()
        self.addCleanup(server.server_close)
        self.addCleanup(server.shutdown)
        self.address = f"https://127.0.0.1:{server.server_port}"
        self.served = served

    def catalogue_of(self, path="net.onnx", digest=None, size=9000):
        digest = digest or hashlib.sha256(b"the model" * 1000).hexdigest()
        cards = self.folder / "cards"
        cards.mkdir(exist_ok=True)
        (self.folder / "catalogue.json").write_text(json.dumps({"version": 1, "models": [
            {"name": "net", "task": "test", "about": "a test", "licence": "MIT",
             "files": [{"name": "net.onnx", "url": f"{self.address}/{path}", "sha256": digest, "bytes": size}]}]}))
        return cards

    def environment(self, cards):
        return {"no_proxy": "127.0.0.1", "CURL_CA_BUNDLE": str(self.authority), "WEIR_CARD_PATH": str(cards),
                "WEIR_MODELS": str(self.folder / "models")}

    def get(self, cards, **environment):
        return weir("models", "get", "net", **{**self.environment(cards), **environment})

    def test_fetches_once_and_checks_the_digest(self):
        cards = self.catalogue_of()
        file = self.folder / "models" / "net" / "net.onnx"
        self.assertIn(str(file), self.good(self.get(cards)))
        self.assertEqual(file.read_bytes(), b"the model" * 1000)
        (self.served / "net.onnx").unlink()
        self.assertIn("already downloaded", self.good(self.get(cards)))
        listed = self.good(weir("models", "list", WEIR_CARD_PATH=str(cards), WEIR_MODELS=str(self.folder / "models")))
        self.assertRegex(listed, "net .*downloaded")
        self.assertEqual(os.listdir(file.parent), ["net.onnx"])

    def test_replaces_a_damaged_file(self):
        cards = self.catalogue_of()
        file = self.folder / "models" / "net" / "net.onnx"
        file.parent.mkdir(parents=True)
        file.write_bytes(b"half")
        self.good(self.get(cards))
        self.assertEqual(file.stat().st_size, 9000)

    def test_another_digest_is_an_error_and_leaves_nothing(self):
        cards = self.catalogue_of(digest="0" * 64)
        self.refused(self.get(cards), 1, "WEIR-4011", "not the expected one", "sha256 " + hashlib.sha256(b"the model" * 1000).hexdigest())
        self.assertEqual(os.listdir(self.folder / "models" / "net"), [])

    def test_an_answer_without_a_length_ends_at_the_size_of_the_catalogue(self):
        sent = []

        def endless(request):
            request.send_response(200)
            request.send_header("Transfer-Encoding", "chunked")
            request.end_headers()
            try:
                while len(sent) < 500:
                    request.wfile.write(b"100000\r\n" + b"x" * 0x100000 + b"\r\n")
                    sent.append(1)
                request.wfile.write(b"0\r\n\r\n")
            except OSError:
                pass
            request.close_connection = True

        self.handlers["/net.onnx"] = endless
        self.refused(self.get(self.catalogue_of()), 1, "WEIR-4011", "the file is larger than the 9000 bytes of the catalogue", self.address)
        self.assertLess(len(sent), 100)
        self.assertEqual(os.listdir(self.folder / "models" / "net"), [])

    def test_an_answer_that_leads_to_an_address_without_tls_is_refused(self):
        def elsewhere(request):
            request.send_response(302)
            request.send_header("Location", self.address.replace("https", "http") + "/net.onnx")
            request.send_header("Content-Length", "0")
            request.end_headers()

        self.handlers["/moved.onnx"] = elsewhere
        self.refused(self.get(self.catalogue_of(path="moved.onnx")), 1, "WEIR-4011", "curl failed", '"http"')

    def test_processes_that_fetch_the_same_model_wait_for_each_other(self):
        requests, begun, may_end = [], threading.Event(), threading.Event()

        def slow(request):
            requests.append(request.path)
            request.send_response(200)
            request.send_header("Content-Length", "9000")
            request.end_headers()
            request.wfile.write(b"the model" * 500)
            begun.set()
            may_end.wait(60)
            request.wfile.write(b"the model" * 500)

        self.addCleanup(may_end.set)
        self.handlers["/net.onnx"] = slow
        environment = {**os.environ, **self.environment(self.catalogue_of())}
        start = functools.partial(subprocess.Popen, [COMMAND, "models", "get", "net"], env=environment, text=True,
                                  stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        with start() as first:
            self.assertTrue(begun.wait(60))
            with start() as second:
                self.assertIn("waiting for another process", second.stderr.readline())
                may_end.set()
                self.assertIn("already downloaded", second.communicate(timeout=60)[0])
            self.assertEqual(first.wait(60), 0)
        self.assertEqual(requests, ["/net.onnx"])

    def test_a_package_ends_at_a_gibibyte(self):
        programs = self.folder / "programs"
        programs.mkdir()
        npm = programs / "npm"
        npm.write_text("#!/bin/sh\nLC_ALL=C exec truncate -s 1073741825 \"$4/package.tgz\"\n")
        npm.chmod(0o755)
        cards = self.catalogue_of()
        catalogue = json.loads((self.folder / "catalogue.json").read_text())
        file = catalogue["models"][0]["files"][0]
        del file["url"]
        file.update(npm="net@1.0.0", path="net.onnx")
        (self.folder / "catalogue.json").write_text(json.dumps(catalogue))
        self.refused(self.get(cards, PATH=f"{programs}:{os.environ['PATH']}"), 1, "WEIR-4011", "npm failed", "File too large", "net@1.0.0")

    def test_a_missing_file_shows_what_curl_says(self):
        self.refused(self.get(self.catalogue_of(path="nothing.onnx")), 1, "WEIR-4011", "curl failed", "404", self.address,
                     "fix: check the network, then repeat the command, or copy the file from another machine to "
                     f"{self.folder}/models/net/net.onnx\n")

    def test_a_missing_program_names_its_package(self):
        self.refused(self.get(self.catalogue_of(), PATH=str(self.folder)), 1, "WEIR-4011", "apt-get install curl")

    def test_a_folder_that_cannot_be_made_is_an_error(self):
        cards = self.catalogue_of()
        (self.folder / "models").write_text("a file")
        self.refused(self.get(cards), 1, "WEIR-4010", str(self.folder / "models"))


if __name__ == "__main__":
    tap_runner.main()
