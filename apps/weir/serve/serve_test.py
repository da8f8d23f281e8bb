#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Tests of the options of `weir serve`, and of its pipelines."""

import tap_runner
from weir_case import MODEL, SOURCE, Case, weir

BASE = f"framework=auto model={MODEL}"


class Options(Case):
    def pipelines(self, *arguments):
        return self.good(weir("serve", "--dry-run", *arguments)).splitlines()

    def test_each_model_has_a_pipeline_with_its_name(self):
        one, two = self.pipelines(MODEL, f"other={MODEL}")
        self.assertEqual(one, "tensor_query_serversrc protocol=oip id=1 name=clock_digits-source model-name=clock_digits host=127.0.0.1 "
                              f"port=8001 ! tensor_filter name=clock_digits-filter {BASE} ! "
                              "tensor_query_serversink name=clock_digits-sink id=1")
        self.assertIn("id=2 name=other-source model-name=other host=127.0.0.1 port=8001 !", two)
        self.assertTrue(two.endswith("tensor_query_serversink name=other-sink id=2"))

    def test_options_become_properties(self):
        line, = self.pipelines(MODEL, "--listen", "0.0.0.0:9", "--tls-cert", "c.pem", "--tls-key", "c.key", "--tls-ca", "ca.pem",
                               "--token-file", "a b", "--batch", "8", "--batch-wait", "500", "--custom", "threads:2")
        self.assertIn("host=0.0.0.0 port=9 tls-cert=c.pem tls-key=c.key tls-ca=ca.pem token-file='\"a b\"' !", line)
        self.assertIn(f"{BASE} custom=threads:2 batch-size=8 batch-timeout=500000 !", line)
        self.assertIn("unix-path=/run/weir.sock !", self.pipelines(MODEL, "--listen", "unix:/run/weir.sock")[0])
        self.assertIn(" insecure=true !", self.pipelines(MODEL, "--listen", "0.0.0.0:9", "--insecure")[0])
        self.assertIn(" model-control=true !", self.pipelines(MODEL, "--model-control")[0])
        self.assertIn(" workers=3 !", self.pipelines(MODEL, "--workers", "3")[0])
        self.assertIn(f"-filter framework=onnxruntime model={MODEL} !", self.pipelines(MODEL, "--engine", "onnxruntime")[0])
        self.assertIn(" max-connections=0 max-connections-per-address=64 !",
                      self.pipelines(MODEL, "--max-connections", "0", "--max-connections-per-address", "64")[0])
        self.assertNotIn("max-connections", self.pipelines(MODEL)[0])
        self.assertIn("host=::1 port=0", self.pipelines(MODEL, "--listen", "[::1]:0")[0])

    def test_a_file_with_an_equals_sign_keeps_its_name(self):
        path = self.folder / "a=b.onnx"
        path.write_bytes(MODEL.read_bytes())
        self.assertIn(f"model={path} ", self.pipelines(f"ab={path}")[0] + " ")
        self.refused(weir("serve", "--dry-run", path), 1, "WEIR-1004: the model needs a name that fits into an address",
                     "fix: weir serve my-model=")

    def test_models_that_are_not_there_or_have_no_usable_name_are_errors(self):
        self.refused(weir("serve", "/no/model.onnx"), 1, "WEIR-3003: the model file does not exist", "offered: /no/model.onnx",
                     "fix: weir serve /path/to/model.onnx")
        self.refused(weir("serve", "a="), 1, "WEIR-1004: the model needs a name")
        self.refused(weir("serve", MODEL, MODEL), 1, "WEIR-1004: two models have the same name", "offered: clock_digits",
                     f"fix: weir serve clock_digits-2={MODEL}")
        path = self.folder / "a b.onnx"
        path.write_bytes(b"")
        self.refused(weir("serve", path), 1, f"fix: weir serve my-model='{path}'")

    def test_names_of_the_catalogue_are_models_too(self):
        places = {"WEIR_CARD_PATH": str(SOURCE / "models" / "cards"), "WEIR_MODELS": str(self.folder)}
        for model in ("mnist", "digits=mnist"):
            self.refused(weir("serve", model, **places), 1, "WEIR-3003: the model has not been downloaded", "fix: weir models get mnist\n")
        file = self.downloaded("mnist")
        one, two = self.good(weir("serve", "--dry-run", "mnist", "digits=mnist", **places)).splitlines()
        self.assertIn(f" model-name=mnist host=127.0.0.1 port=8001 ! tensor_filter name=mnist-filter framework=auto model={file} !", one)
        self.assertIn(f" model-name=digits host=127.0.0.1 port=8001 ! tensor_filter name=digits-filter framework=auto model={file} !", two)

    def test_addresses_that_cannot_be_read_are_errors(self):
        for address in ("8001", "host", ":8001", "host:", "host:70000", "host:-1", "::1:8001", "a b:1", "unix:", ""):
            self.refused(weir("serve", MODEL, "--listen", address), 1, "WEIR-1004: the address of --listen cannot be read",
                         f"offered: '{address}'", "fix: --listen 127.0.0.1:8001")

    def test_other_machines_need_tls(self):
        for address in ("0.0.0.0:8001", "[::]:8001", "192.0.2.1:8001", "127.0.0.1.example:8001"):
            self.refused(weir("serve", MODEL, "--listen", address), 1, "WEIR-6003: other machines could connect without encryption",
                         f"offered: --listen {address}", "fix: --tls-cert server.pem --tls-key server.key")

    def test_options_that_contradict_each_other_are_errors(self):
        for options, what, offered in (
                (("--tls-cert", "a"), "WEIR-1004: a certificate and its key belong together", "--tls-cert without --tls-key"),
                (("--tls-key", "a"), "WEIR-1004: a certificate and its key belong together", "--tls-key without --tls-cert"),
                (("--tls-ca", "a"), "WEIR-1004: client certificates need a connection with TLS", "--tls-ca without --tls-cert"),
                (("--token-file", "a"), "WEIR-6003: clients would send their tokens without TLS", "--token-file without --tls-cert"),
                (("--batch", "8", "--workers", "2"), "WEIR-1004: batches run one at a time", "--batch 8 with --workers 2")):
            self.refused(weir("serve", MODEL, *options), 1, what, f"offered: {offered}")

    def test_wrong_arguments_are_usage_errors(self):
        for words in ((), (MODEL, "--batch", "0"), (MODEL, "--workers", "x"), (MODEL, "--batch-wait", "-1"), (MODEL, "--port", "1")):
            self.refused(weir("serve", *words), 2)


if __name__ == "__main__":
    tap_runner.main()
