#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Tests of the command `weir` and of `weir doctor`: output for people and for programs."""

import json
import os
import pathlib
import re
import shutil
import subprocess
import unittest

import tap_runner
from weir_case import HAS_ONNX, PLUGIN, SOURCE, Case, weir


class Usage(Case):
    def test_the_name_alone_help_and_the_option_list_the_commands(self):
        output = self.good(weir("help"))
        self.assertEqual(self.good(weir()), output)
        self.assertEqual(self.good(weir("--help")), output)
        commands = re.findall(r"^  ([a-z]+) {2,}\S", output, re.MULTILINE)
        self.assertEqual(commands[:5], ["try", "run", "inspect", "models", "doctor"])
        self.assertLessEqual({"bench", "card", "check", "evaluate", "explain", "new", "pbtxt", "pki", "serve"}, set(commands))
        self.assertNotIn("bench-case", output)

    def test_help_of_a_command_is_that_of_its_option(self):
        for words in (("run",), ("pki", "issue"), ("new", "filter")):
            output = self.good(weir("help", *words))
            self.assertEqual(self.good(weir(*words, "--help")), output)
            self.assertIn(f"Usage: weir {' '.join(words)} ", output)

    def test_unknown_commands_and_options_get_a_suggestion(self):
        for words, text in (
                (("rnu",), "weir has no command 'rnu'. Did you mean 'run'?\nweir help lists the commands.\n"),
                (("help", "docter"), "weir has no command 'docter'. Did you mean 'doctor'?\nweir help lists the commands.\n"),
                (("pki", "isue"), "weir pki has no command 'isue'. Did you mean 'issue'?\nweir help pki lists the commands.\n"),
                (("xyzzy",), "weir has no command 'xyzzy'.\nweir help lists the commands.\n"),
                (("doctor", "--jsn"), "weir doctor has no option '--jsn'. Did you mean '--json'?\nweir help doctor shows the options.\n"),
                (("--hlp",), "weir has no option '--hlp'. Did you mean '--help'?\nweir help shows the options.\n"),
                (("new",), "weir new needs a command: filter, engine, decoder, converter, nnstreamer-filter\nweir help new shows them.\n"),
                (("run",), "weir run: PIPELINE is required\nweir help run shows the options.\n")):
            done = weir(*words)
            self.assertEqual((done.returncode, done.stdout, done.stderr), (2, "", text), words)

    def test_output_that_cannot_be_written_is_an_error(self):
        for words in (("explain",), ("help",), ("models", "list"), ("doctor", "--json")):
            with open("/dev/full", "w") as full:
                done = subprocess.run([os.environ["WEIR_COMMAND"], *words], stdout=full, stderr=subprocess.PIPE, text=True, timeout=60,
                                      check=False, env={**os.environ, "WEIR_CARD_PATH": str(SOURCE / "models" / "cards")})
            self.assertEqual((done.returncode, done.stderr),
                             (1, "weir: standard output cannot be written; is the disk full?\n"), words)

    def test_a_number_out_of_range_is_refused_with_the_range(self):
        for words, text in ((("run", "--timeout", "abc", "fakesrc"), "'abc' is not a number from 0.001 to 1000000\n"),
                            (("run", "--serve-clock", "65536", "fakesrc"), "'65536' is not a number from 0 to 65535\n"),
                            (("serve", "--batch", "-1", "x"), "'-1' is not a number from 1 to 1024\n"),
                            (("bench", "-t", "1,x", "model"), "'x' is not a number from 1 to 1024\n")):
            self.refused(weir(*words), 2, text)

    def test_help_has_the_names_of_values_and_nothing_of_the_parser(self):
        self.assertRegex(self.good(weir("help", "run")), r"--timeout SECONDS +End the stream")
        self.assertRegex(self.good(weir("help", "serve")), r"--metrics\[=ADDRESS\] +Serve metrics")
        self.assertRegex(self.good(weir("help", "bench")), r"MODEL TEXT REQUIRED +A model file")
        for command in ("run", "inspect", "bench", "evaluate", "serve"):
            self.assertNotRegex(self.good(weir("help", command)), r"Excludes|:INT|:FLOAT|:UINT|:POSITIVE|\{", command)

    def test_every_command_has_a_manual_page_and_weir_1_lists_them_in_the_order_of_help(self):
        commands = re.findall(r"^  ([a-z]+) {2,}\S", self.good(weir("help")), re.MULTILINE)
        pages = SOURCE / "apps" / "weir"
        listed = (pages / "weir.1").read_text().partition(".SH DESCRIPTION")[2].partition(".SH OPTIONS")[0]
        self.assertEqual(re.findall(r"^\.B (\w+)$", listed, re.MULTILINE), commands)
        installed = (pages / "meson.build").read_text()
        for command in commands:
            if command == "help":
                continue
            self.assertIn(f".BR weir\\-{command} (1).", listed)
            self.assertTrue((pages / f"weir-{command}.1").exists(), command)
            self.assertIn(f"'weir-{command}.1'", installed)

    def completed(self, *words):
        """What bash offers for the last of the words."""
        script = ('source apps/weir/completion.bash; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _weir; '
                  'printf "%s\\n" "${COMPREPLY[@]}"')
        done = subprocess.run(["bash", "-c", script, "bash", os.environ["WEIR_COMMAND"], *words], cwd=SOURCE, capture_output=True,
                              text=True, timeout=60)
        self.assertEqual(done.stderr, "")
        return done.stdout.split()

    def test_bash_completes_commands_and_options(self):
        self.assertEqual(self.completed("ru"), ["run"])
        self.assertEqual(self.completed("pki", ""), ["init", "issue"])
        self.assertEqual(self.completed("help", "pki", "is"), ["issue"])
        self.assertEqual(self.completed("bench", "model.onnx", "--th"), ["--threads"])
        self.assertEqual(self.completed("xyzzy"), [])
        self.assertEqual(self.completed("try", "mod"), [])  # bash completes the file name

    def test_version(self):
        self.assertRegex(self.good(weir("--version")), r"^weir \d+\.\d+\.\d+\n$")

    def test_wrong_arguments_are_usage_errors(self):
        for words in (("docter",), ("inspect",), ("run",), ("doctor", "--jsn")):
            self.refused(weir(*words), 2)

    def test_manual_pages_render(self):
        for page in sorted((SOURCE / "apps/weir").glob("*.1")):
            done = subprocess.run(["groff", "-man", "-ww", "-z", page], capture_output=True, text=True)
            self.assertEqual(done.stderr, "", page.name)


class Explain(Case):
    def test_it_prints_the_page_of_a_code(self):
        page = (SOURCE / "docs/errors/WEIR-2001.md").read_text(encoding="utf-8")
        for code in ("WEIR-2001", "weir-2001", "2001"):
            self.assertEqual(self.good(weir("explain", code)), page)

    def test_each_code_has_a_page(self):
        codes = re.findall(r"^WEIR-\d{4}", self.good(weir("explain")), re.MULTILINE)
        self.assertEqual(codes, [page.stem for page in sorted((SOURCE / "docs/errors").glob("WEIR-*.md"))])
        for code in codes:
            self.assertTrue(self.good(weir("explain", code)).startswith(f"# {code}: "))

    def test_an_unknown_code_gets_a_suggestion(self):
        self.refused(weir("explain", "2009"), 1, "WEIR-1004: there is no such error code", "offered: 2009", "fix: weir explain WEIR-200")
        self.refused(weir("explain", "segfault"), 1, "WEIR-1004: there is no such error code", "fix: weir explain\n")


class Doctor(Case):
    def test_it_begins_with_a_verdict_and_the_machine(self):
        output = self.good(weir("doctor", WEIR_MODULE_PATH=str(self.folder)))
        self.assertRegex(output, r"^Weir works\n\nVersions     Weir 3\.\d+\.\d+, GStreamer 1\.\d+\.\d+\nCPU          .+, \d+ cores?\n"
                                 r"GPU          .+\nMemory       [\d.]+ GiB, [\d.]+ GiB available\nPlug-in      .+/libgstweir.so\nElements     \d+ of the plug-in weir")
        self.assertLess(len(output.splitlines()), 30, "what works takes a line for each kind")
        (self.folder / "libweir-decoder-broken.so").write_text("no library")
        output = self.good(weir("doctor", WEIR_MODULE_PATH=str(self.folder)))
        self.assertTrue(output.startswith("Weir works, with 1 problem\n  the decoder broken cannot be used\n    reason: "), output)
        report = json.loads(self.good(weir("doctor", "--json", WEIR_MODULE_PATH=str(self.folder))))
        self.assertEqual((report["verdict"], [p["what"] for p in report["problems"]]),
                         ("Weir works, with 1 problem", ["the decoder broken cannot be used"]))
        self.assertEqual(report["machine"]["memory_bytes"] // 1024,
                         int(re.search(r"MemTotal: +(\d+)", pathlib.Path("/proc/meminfo").read_text())[1]))
        done = weir("doctor", **self.plugins_of(self.folder))
        self.refused(done, 1, "fix: make install")
        self.assertTrue(done.stdout.startswith("Weir does not work\n  the plug-in libgstweir.so was not found\n"), done.stdout)

    def test_it_lists_what_is_installed(self):
        output = self.good(weir("doctor", "--all"))
        for words in ("GStreamer 1.", str(PLUGIN), "tensor_filter", "Engines"):
            self.assertIn(words, output)
        self.assertRegex(output, r"fake +usable +1 +\S*/libweir-engine-fake.so\n")
        self.assertRegex(output, r"Decoders\n  decoder +state +place\n(  \S+ +usable.*\n)*?  direct_video +usable +\S*/libweir-decoder-direct_video.so\n")
        self.assertRegex(output, r"Converters\n  converter +state +place\n(?:  \w+ +usable .*\n)*  python3 +usable +\S*/libweir-converter-python3.so\n")
        for folder in os.environ["WEIR_MODULE_PATH"].split(":"):
            self.assertIn(f"\n  {folder}\n", output)

    @unittest.skipUnless(HAS_ONNX, "the engine onnxruntime is not built")
    def test_an_engine_comes_with_the_version_and_place_of_its_library(self):
        engines = {e["name"]: e for e in json.loads(self.good(weir("doctor", "--json")))["engines"]}
        onnx = engines["onnxruntime"]
        self.assertEqual(onnx["state"], "usable")
        self.assertRegex(onnx["version"], r"^1\.\d+\.\d+$")
        self.assertTrue(pathlib.Path(onnx["library"]).is_file())
        self.assertTrue(pathlib.Path(onnx["module"]).is_file())
        self.assertRegex(self.good(weir("doctor", "--all")),
                         rf"onnxruntime +usable +{onnx['version']} +onnx +{re.escape(onnx['library'])}\n")

    def test_json(self):
        report = json.loads(self.good(weir("doctor", "--json")))
        self.assertTrue(report["usable"])
        self.assertEqual(report["plugin"]["file"], str(PLUGIN))
        self.assertIn("tensor_converter", [e["name"] for e in report["elements"]])
        states = {e["name"]: e["state"] for e in report["engines"]}
        self.assertEqual(states["fake"], "usable")
        self.assertEqual(states["bad-version"], "refused")
        self.assertEqual(states["openvino"], "not available")
        decoders = {d["name"]: d for d in report["decoders"]}
        messages = {"flatbuf", "flexbuf", "protobuf"}  # a build may lack their libraries
        results = {"classification", "depth", "detection", "pose", "segmentation", "text", "coco", "json", "mot", "webvtt"}
        self.assertEqual(set(decoders) - messages - results, {"bounding_boxes", "direct_video", "image_labeling", "image_segment",
                                                              "octet_stream", "pose_estimation", "python3", "tensor_region"})
        self.assertLessEqual(results, set(decoders))
        converters = {c["name"]: c["state"] for c in report["converters"]}
        self.assertEqual(set(converters) - messages, {"python3"})
        self.assertEqual(set(converters.values()), {"usable"})
        self.assertEqual(set(decoders) & messages, set(converters) & messages)
        self.assertTrue(pathlib.Path(report["converters"][0]["module"]).is_file())

    def library(self, **environment):
        return next(f for f in json.loads(self.good(weir("doctor", "--json", **environment)))["libraries"] if f["name"] == "libmosquitto")

    def test_doctor_names_the_library_for_brokers(self):
        report = json.loads(self.good(weir("doctor", "--json")))
        elements = {e["name"] for e in report["elements"] if e["plugin"] == "weiredge"}
        fact = next(f for f in report["libraries"] if f["name"] == "libmosquitto")
        self.assertIn("connect-type=HYBRID", fact["needed_for"])
        output = self.good(weir("doctor"))
        if "edgesink" in elements and "mqttsink" not in elements:
            self.assertEqual((fact["state"], fact["install"]), ("not in this build", "apt-get install libmosquitto-dev && make install"))
            self.assertIn("libmosquitto is not in this build: without it there are no mqttsink, mqttsrc,", output)
        elif fact["state"] == "usable":
            self.assertRegex(fact["version"], r"^2\.\d+\.\d+$")
            self.assertTrue(pathlib.Path(fact["file"]).is_file())
            self.assertRegex(output, rf"\nLibraries    libmosquitto {fact['version']}\n")
            self.assertRegex(self.good(weir("doctor", "--all")), rf"libmosquitto +usable +{fact['version']} +mqttsink.* {fact['file']}\n")

    def test_doctor_says_what_is_missing_without_the_library_for_brokers(self):
        (self.folder / "libmosquitto.so.1").write_text("no library")
        hidden = {"LD_LIBRARY_PATH": f"{self.folder}:{os.environ.get('LD_LIBRARY_PATH', '')}", "GST_REGISTRY": str(self.folder / "registry")}
        fact = self.library(**hidden)
        self.assertEqual((fact["version"], fact["file"]), ("", ""))
        self.assertNotEqual(fact["state"], "usable")
        self.assertRegex(self.good(weir("doctor", **hidden)),
                         rf"\nlibmosquitto is {fact['state']}: without it there are no mqttsink, mqttsrc, connect-type=HYBRID and connect-type=MQTT\n"
                         rf"  {fact['install']}\n")

    def test_a_decoder_and_a_converter_that_cannot_be_opened_are_reported(self):
        for kind in ("decoder", "converter"):
            (self.folder / f"libweir-{kind}-broken.so").write_text("no library")
        output = self.good(weir("doctor", "--all", WEIR_MODULE_PATH=str(self.folder)))
        for kind in ("decoder", "converter"):
            self.assertRegex(output, rf"broken +refused +\S*/libweir-{kind}-broken.so\n")
        self.assertRegex(output, r"the decoder broken cannot be used\n    reason: .*(invalid ELF header|file too short)")
        report = json.loads(self.good(weir("doctor", "--json", WEIR_MODULE_PATH=str(self.folder))))
        self.assertEqual(report["converters"][0]["state"], "refused")
        self.assertNotEqual({d["name"]: d for d in report["decoders"]}["broken"]["problem"], "")

    def test_missing_engines_come_with_their_command(self):
        output = self.good(weir("doctor", "--all", WEIR_MODULE_PATH=str(self.folder)))
        for name in ("onnxruntime", "tensorflow-lite"):
            self.assertRegex(output, rf"\n  {name} +tools/setup --engine {name}")
        self.assertTrue(output.startswith("Weir works\n"), output)

    def test_an_engine_without_a_library_version_is_usable(self):
        engines = {e["name"]: e for e in json.loads(self.good(weir("doctor", "--json")))["engines"]}
        self.assertEqual((engines["adder"]["state"], engines["adder"]["problem"]), ("usable", ""))

    def test_a_module_that_cannot_be_used_is_named(self):
        (self.folder / "libweir-engine-onnxruntime.so").write_text("no module")
        output = self.good(weir("doctor", "--all", WEIR_MODULE_PATH=str(self.folder)))
        self.assertIn("the engine onnxruntime cannot be used\n    reason: ", output)
        self.assertIn(str(self.folder / "libweir-engine-onnxruntime.so"), output)

    def test_a_missing_plugin_is_an_error_with_its_fix(self):
        self.refused(weir("doctor", **self.plugins_of(self.folder)), 1, "not found", str(self.folder), "make install")

    def ini(self, text):
        path = self.folder / "weir.ini"
        path.write_text(text)
        return path

    def test_doctor_names_the_file_and_the_variable_that_decided(self):
        path = self.ini("[filter]\npriority_onnx=a, b\nenable_symlink=yes\n")
        variables = {"WEIR_CONFIG": str(path), "WEIR_FILTER_ENABLE_SYMLINK": "no"}
        output = self.good(weir("doctor", "--all", **variables))
        self.assertIn(f"{path}: read", output)
        self.assertRegex(output, rf"\[filter\] priority_onnx +a, b +{re.escape(str(path))}:2\n")
        self.assertRegex(output, r"\[filter\] enable_symlink +no +WEIR_FILTER_ENABLE_SYMLINK\n")
        report = json.loads(self.good(weir("doctor", "--json", **variables)))["configuration"]
        self.assertEqual(report["files"], [{"path": str(path), "state": "read"}])
        self.assertIn({"group": "filter", "key": "priority_onnx", "value": "a, b", "origin": f"{path}:2"}, report["settings"])
        self.assertEqual(report["problems"], [])

    def test_doctor_lives_through_a_module_that_crashes(self):
        shutil.copy(pathlib.Path(os.environ["WEIR_CRASHING_MODULES"]) / "libweir-engine-crashing.so", self.folder)
        shutil.copy(self.folder / "libweir-engine-crashing.so", self.folder / "libweir-decoder-crashing.so")
        path = f"{self.folder}:{os.environ['WEIR_MODULE_PATH']}"
        report = json.loads(self.good(weir("doctor", "--json", WEIR_MODULE_PATH=path)))
        engines = {engine["name"]: engine for engine in report["engines"]}
        self.assertEqual(engines["crashing"]["state"], "refused")
        self.assertRegex(engines["crashing"]["problem"], r"the module cannot be loaded: it terminates the process: (signal (6|11)|exit\()")
        self.assertEqual(engines["scaling"]["state"], "usable", "the others are looked at as ever")
        self.assertIn("it terminates the process", self.good(weir("doctor", "--all", WEIR_MODULE_PATH=path)))

    def test_doctor_names_lines_of_the_configuration_that_are_wrong(self):
        path = self.ini("[filter]\nhello\npriorty_onnx=a\n")
        output = self.good(weir("doctor", "--all", WEIR_CONFIG=str(path)))
        self.assertIn(f"reason: {path}:2: the line is neither a group nor a key with its value: hello", output)
        self.assertIn(f"reason: {path}:3: unknown setting: [filter] priorty_onnx "
                      "(did you mean [filter] priority_onnx?)", output)
        self.assertIn("reason: the configuration file cannot be read: /no/such.ini", self.good(weir("doctor", "--all", WEIR_CONFIG="/no/such.ini")))
        home = {"HOME": str(self.folder), "XDG_CONFIG_HOME": str(self.folder / "x")}
        without = {name: value for name, value in os.environ.items() if name != "WEIR_CONFIG"}
        done = subprocess.run([os.environ["WEIR_COMMAND"], "doctor", "--all"], env={**without, **home}, text=True, capture_output=True,
                              timeout=60, check=True)
        self.assertIn(f"{self.folder}/x/weir/weir.ini: not found", done.stdout)
        self.assertIn("/etc/weir/weir.ini: ", done.stdout)

    def test_doctor_shows_every_place_of_nnstreamers_configuration(self):
        path, extra = self.folder / "nns.ini", self.folder / "extra.ini"
        path.write_text("[common]\nenable_envvar=1\nenable_symlink=perhaps\n"
                        f"extra_config_path={extra}\n[filter]\nframework_priority_onnx=a\nfilters={self.folder}\n")
        extra.write_text("[decoder]\ndecoders=here\n[own]\nkey=1\n[pytorch]\nenable_use_gpu=1\n")
        variables = {"NNSTREAMER_CONF": str(path), "NNSTREAMER_TRAINERS": "/no/trainers",
                     "WEIR_FILTER_PRIORITY_ONNX": "b", "WEIR_NNSTREAMER_ENABLE": "yes"}
        output = self.good(weir("doctor", "--all", **variables))
        self.assertIn(f"{path} (NNSTREAMER_CONF): read\n", output)
        self.assertIn(f"{extra} (extra_config_path): read\n", output)
        # If Weir was built for that path, it is listed only once.
        self.assertRegex(output, r"/etc/nnstreamer\.ini \((hard-coded|built for)\): not needed: an earlier file was read\n")
        self.assertRegex(output, rf"\[filter\] framework_priority_onnx +a +{re.escape(str(path))}:6 +"
                               r"overridden by \[filter\] priority_onnx \(WEIR_FILTER_PRIORITY_ONNX\)\n")
        self.assertRegex(output, rf"\[pytorch\] enable_use_gpu +1 +{re.escape(str(extra))}:6 +"
                               r"without effect: Weir's engine pytorch runs on the processor\n")
        self.assertRegex(output, rf"\[own\] key +1 +{re.escape(str(extra))}:4")
        self.assertRegex(output, rf"filters +{re.escape(str(self.folder))} +{re.escape(str(path))}:7 +found\n")
        self.assertRegex(output, r"trainers +/no/trainers +NNSTREAMER_TRAINERS +not found\n")
        self.assertIn(f"reason: {path}:3: neither true nor false: [common] enable_symlink=perhaps", output)
        self.assertIn(f"reason: {extra}:2: the path is not absolute and is ignored: [decoder] decoders=here", output)
        report = json.loads(self.good(weir("doctor", "--json", **variables)))["nnstreamer"]
        self.assertEqual(report["files"][0], {"path": str(path), "source": "NNSTREAMER_CONF", "state": "read"})
        self.assertEqual(len(report["problems"]), 2)
        self.assertEqual({s["key"]: s["without_effect"] for s in report["settings"] if s["without_effect"]},
                         {"enable_use_gpu": "Weir's engine pytorch runs on the processor"})
        self.assertIn({"kind": "filters", "path": "/usr/lib/nnstreamer/filters", "origin": "hard-coded",
                       "found": os.path.isdir("/usr/lib/nnstreamer/filters")}, report["folders"])
        off = self.good(weir("doctor", "--all", **{**variables, "WEIR_NNSTREAMER_ENABLE": "no"}))
        self.assertIn("not used: enable=false in [nnstreamer]\n", off)
        self.assertNotIn(str(path), off)

    def test_doctor_lists_sub_plugins_for_nnstreamer(self):
        (self.folder / "libnnstreamer_decoder_text.so").write_text("not a shared object")
        (self.folder / "libnnstreamer_trainer_linked.so").symlink_to("libnnstreamer_decoder_text.so")
        path = self.folder / "nns.ini"
        path.write_text(f"[decoder]\ndecoders={self.folder}\n[trainer]\ntrainer={self.folder}\n")
        variables = {"NNSTREAMER_CONF": str(path), "WEIR_NNSTREAMER_ENABLE": "yes", "WEIR_NNSTREAMER_LIBRARY": "/no/lib.so"}
        output = self.good(weir("doctor", "--all", **variables))
        self.assertIn("their functions: /no/lib.so: not found\n", output)
        self.assertRegex(output, rf"decoder +text +refused +{re.escape(str(self.folder))}/libnnstreamer_decoder_text.so\n")
        self.assertIn("the decoder text cannot be used\n    reason: the library with the functions that sub-plugins", output)
        self.assertNotIn("linked", output, "links are skipped")
        report = json.loads(self.good(weir("doctor", "--json", **variables)))["sub_plugins"]
        self.assertEqual([(f["kind"], f["name"], f["state"]) for f in report["files"] if f["file"].startswith(str(self.folder))],
                         [("decoder", "text", "refused")])
        self.assertEqual((report["library"], report["found"]), ("/no/lib.so", False))

    def test_inspect_explains_the_choice_of_the_engine(self):
        model = self.folder / "a.scl"
        model.write_text("x")
        path = self.ini("[filter]\npriority_scl=absent, scaling, fake\n")
        report = json.loads(self.good(weir("inspect", "--json", model, WEIR_CONFIG=str(path))))["engine"]
        self.assertEqual(report["name"], "scaling")
        self.assertEqual(report["reason"],
                         f"the file has the extension .scl; first installed engine of priority_scl ({path}:2)")
        self.assertEqual(report["others"], ["fake"])
        output = self.good(weir("inspect", model, WEIR_CONFIG=str(path), WEIR_FILTER_PRIORITY_SCL="fake"))
        self.assertIn("Engine  fake 1: the file has the extension .scl; first installed engine of priority_scl "
                      "(WEIR_FILTER_PRIORITY_SCL)", output)
        self.refused(weir("inspect", model), 1, "WEIR-3001: no engine can be selected for this model")

    def test_modules_are_looked_for_in_folders_of_the_configuration(self):
        path = self.ini(f"[module]\npath={self.folder}:{os.environ['WEIR_MODULE_PATH']}\n")
        without = {name: value for name, value in os.environ.items() if name != "WEIR_MODULE_PATH"}
        done = subprocess.run([os.environ["WEIR_COMMAND"], "inspect", "--engine", "scaling"], text=True, capture_output=True,
                              env={**without, "WEIR_CONFIG": str(path)}, timeout=60, check=False)
        self.assertIn("Engine  scaling", done.stdout + done.stderr)

    def test_a_plugin_that_cannot_be_loaded_is_an_error_with_its_reason(self):
        (self.folder / PLUGIN.name).write_text("no plug-in")
        paths = self.plugins_of(self.folder)
        self.refused(weir("doctor", **paths), 1, f"cannot be loaded: {self.folder / PLUGIN.name}", "reason: ")
        done = weir("doctor", "--json", **paths)
        report = json.loads(done.stdout)
        self.assertEqual((done.returncode, report["usable"], report["plugin"]["found"]), (1, False, False))
        self.assertIn("file too short", report["plugin"]["load_error"])

    def test_a_second_copy_is_a_conflict(self):
        copy = pathlib.Path(shutil.copy(PLUGIN, self.folder))
        output = self.good(weir("doctor", "--all", **self.plugins_of(PLUGIN.parent, self.folder)))
        self.assertIn("another copy of Weir's plug-in", output)
        self.assertIn(str(copy), output)


if __name__ == "__main__":
    tap_runner.main()
