#!/usr/bin/python3
"""The command `weir`, `weir doctor` and `weir inspect` as people and programs use them."""

import json
import os
import pathlib
import re
import shutil
import subprocess
import unittest

import tap_runner
from weir_case import HAS_ONNX, MODEL, PLUGIN, SOURCE, WITHOUT_LEAKS, Case, weir


SHARED = pathlib.Path(os.environ.get("WEIR_DATA") or SOURCE / "../shared")
LENET = SHARED / "models/torchscript/pytorch_lenet5.pt"


class Usage(Case):
    def test_help_names_the_subcommands(self):
        said = self.good(weir("--help"))
        for name in ("check", "doctor", "inspect", "new", "pbtxt", "run"):
            self.assertIn(name, said)

    def test_version(self):
        self.assertRegex(self.good(weir("--version")), r"^weir \d+\.\d+\.\d+\n$")

    def test_wrong_words_are_usage_errors(self):
        for words in ((), ("docter",), ("inspect",), ("run",), ("doctor", "--jsn")):
            self.refused(weir(*words), 2)

    def test_manual_pages_render(self):
        for page in sorted((SOURCE / "apps/weir").glob("*.1")):
            done = subprocess.run(["groff", "-man", "-ww", "-z", page], capture_output=True, text=True)
            self.assertEqual(done.stderr, "", page.name)


class Doctor(Case):
    def test_it_tells_what_is_there(self):
        said = self.good(weir("doctor"))
        for words in ("GStreamer 1.", str(PLUGIN), "tensor_filter", "Conflicts\n  none", "Engines"):
            self.assertIn(words, said)
        self.assertRegex(said, r"fake +usable +1 +\S*/libweir-engine-fake.so\n")
        self.assertRegex(said, r"Decoders\n  decoder +state +place\n  direct_video +usable +\S*/libweir-decoder-direct_video.so\n")
        self.assertRegex(said, r"Converters\n  converter +state +place\n  python3 +usable +\S*/libweir-converter-python3.so\n")
        for folder in os.environ["WEIR_MODULE_PATH"].split(":"):
            self.assertIn(f"\n  {folder}\n", said)

    @unittest.skipUnless(HAS_ONNX, "the engine onnxruntime is not built")
    def test_an_engine_comes_with_the_version_and_place_of_its_library(self):
        engines = {e["name"]: e for e in json.loads(self.good(weir("doctor", "--json")))["engines"]}
        onnx = engines["onnxruntime"]
        self.assertEqual(onnx["state"], "usable")
        self.assertRegex(onnx["version"], r"^1\.\d+\.\d+$")
        self.assertTrue(pathlib.Path(onnx["library"]).is_file())
        self.assertTrue(pathlib.Path(onnx["module"]).is_file())
        self.assertRegex(self.good(weir("doctor")),
                         rf"onnxruntime +usable +{onnx['version']} +onnx +{re.escape(onnx['library'])}\n")

    def test_json(self):
        told = json.loads(self.good(weir("doctor", "--json")))
        self.assertTrue(told["usable"])
        self.assertEqual(told["plugin"]["file"], str(PLUGIN))
        self.assertIn("tensor_converter", [e["name"] for e in told["elements"]])
        states = {e["name"]: e["state"] for e in told["engines"]}
        self.assertEqual(states["fake"], "usable")
        self.assertEqual(states["bad-version"], "refused")
        self.assertEqual(states["openvino"], "not available")
        decoders = {d["name"]: d for d in told["decoders"]}
        self.assertEqual(set(decoders), {"direct_video", "image_labeling", "octet_stream"})
        self.assertEqual([(c["name"], c["state"]) for c in told["converters"]], [("python3", "usable")])
        self.assertTrue(pathlib.Path(told["converters"][0]["module"]).is_file())

    def test_a_decoder_and_a_converter_that_cannot_be_opened_are_told(self):
        for kind in ("decoder", "converter"):
            (self.folder / f"libweir-{kind}-broken.so").write_text("no library")
        said = self.good(weir("doctor", WEIR_MODULE_PATH=str(self.folder)))
        for kind in ("decoder", "converter"):
            self.assertRegex(said, rf"broken +refused +\S*/libweir-{kind}-broken.so\n")
        self.assertRegex(said, r"broken is refused\n    reason: .*(invalid ELF header|file too short)")
        told = json.loads(self.good(weir("doctor", "--json", WEIR_MODULE_PATH=str(self.folder))))
        self.assertEqual(told["converters"][0]["state"], "refused")
        self.assertNotEqual(told["decoders"][0]["problem"], "")

    def test_missing_engines_come_with_their_command(self):
        said = self.good(weir("doctor", WEIR_MODULE_PATH=str(self.folder)))
        for name in ("onnxruntime", "tensorflow-lite"):
            self.assertIn(f"{name} is not installed", said)
            self.assertIn(f"tools/setup --engine {name}", said)

    def test_an_engine_that_says_nothing_of_a_library_is_usable(self):
        engines = {e["name"]: e for e in json.loads(self.good(weir("doctor", "--json")))["engines"]}
        self.assertEqual((engines["adder"]["state"], engines["adder"]["problem"]), ("usable", ""))

    def test_a_module_that_cannot_be_used_is_named(self):
        (self.folder / "libweir-engine-onnxruntime.so").write_text("no module")
        said = self.good(weir("doctor", WEIR_MODULE_PATH=str(self.folder)))
        self.assertIn("onnxruntime is refused", said)
        self.assertIn(str(self.folder / "libweir-engine-onnxruntime.so"), said)

    def test_a_missing_plugin_is_an_error_with_its_fix(self):
        self.refused(weir("doctor", **self.plugins_of(self.folder)), 1, "not found", str(self.folder), "make install")

    def ini(self, text):
        path = self.folder / "weir.ini"
        path.write_text(text)
        return path

    def test_doctor_says_which_file_and_which_variable_decided(self):
        path = self.ini("[filter]\npriority_onnx=a, b\nenable_symlink=yes\n")
        variables = {"WEIR_CONFIG": str(path), "WEIR_FILTER_ENABLE_SYMLINK": "no"}
        said = self.good(weir("doctor", **variables))
        self.assertIn(f"{path}: read", said)
        self.assertRegex(said, rf"\[filter\] priority_onnx +a, b +{re.escape(str(path))}:2\n")
        self.assertRegex(said, r"\[filter\] enable_symlink +no +WEIR_FILTER_ENABLE_SYMLINK\n")
        told = json.loads(self.good(weir("doctor", "--json", **variables)))["configuration"]
        self.assertEqual(told["files"], [{"path": str(path), "state": "read"}])
        self.assertIn({"group": "filter", "key": "priority_onnx", "value": "a, b", "origin": f"{path}:2"}, told["settings"])
        self.assertEqual(told["problems"], [])

    def test_doctor_lives_through_a_module_that_crashes(self):
        shutil.copy(pathlib.Path(os.environ["WEIR_CRASHING_MODULES"]) / "libweir-engine-crashing.so", self.folder)
        shutil.copy(self.folder / "libweir-engine-crashing.so", self.folder / "libweir-decoder-crashing.so")
        path = f"{self.folder}:{os.environ['WEIR_MODULE_PATH']}"
        told = json.loads(self.good(weir("doctor", "--json", WEIR_MODULE_PATH=path)))
        engines = {engine["name"]: engine for engine in told["engines"]}
        self.assertEqual(engines["crashing"]["state"], "refused")
        self.assertRegex(engines["crashing"]["problem"], r"the module cannot be loaded: it ends the process: (signal (6|11)|exit\()")
        self.assertEqual(engines["scaling"]["state"], "usable", "the others are looked at as ever")
        self.assertIn("it ends the process", self.good(weir("doctor", WEIR_MODULE_PATH=path)))

    def test_doctor_names_lines_of_the_configuration_that_are_wrong(self):
        path = self.ini("[filter]\nhello\npriorty_onnx=a\n")
        said = self.good(weir("doctor", WEIR_CONFIG=str(path)))
        self.assertIn(f"problem: {path}:2: the line is neither a group nor a key with its value: hello", said)
        self.assertIn(f"problem: {path}:3: no setting has this name: [filter] priorty_onnx "
                      "(did you mean [filter] priority_onnx?)", said)
        self.assertIn("problem: the configuration file cannot be read: /no/such.ini", self.good(weir("doctor", WEIR_CONFIG="/no/such.ini")))
        home = {"HOME": str(self.folder), "XDG_CONFIG_HOME": str(self.folder / "x")}
        without = {name: value for name, value in os.environ.items() if name != "WEIR_CONFIG"}
        done = subprocess.run([os.environ["WEIR_COMMAND"], "doctor"], env={**without, **home}, text=True, capture_output=True,
                              timeout=60, check=True)
        self.assertIn(f"{self.folder}/x/weir/weir.ini: not there", done.stdout)
        self.assertIn("/etc/weir/weir.ini: ", done.stdout)

    def test_doctor_shows_every_place_of_nnstreamers_configuration(self):
        path, extra = self.folder / "nns.ini", self.folder / "extra.ini"
        path.write_text("[common]\nenable_envvar=1\nenable_symlink=perhaps\n"
                        f"extra_config_path={extra}\n[filter]\nframework_priority_onnx=a\nfilters={self.folder}\n")
        extra.write_text("[decoder]\ndecoders=here\n[own]\nkey=1\n[pytorch]\nenable_use_gpu=1\n")
        variables = {"NNSTREAMER_CONF": str(path), "NNSTREAMER_TRAINERS": "/no/trainers",
                     "WEIR_FILTER_PRIORITY_ONNX": "b", "WEIR_NNSTREAMER_ENABLE": "yes"}
        said = self.good(weir("doctor", **variables))
        self.assertIn(f"{path} (NNSTREAMER_CONF): read\n", said)
        self.assertIn(f"{extra} (extra_config_path): read\n", said)
        # Built for that path, it stands there once.
        self.assertRegex(said, r"/etc/nnstreamer\.ini \((hard-coded|built for)\): not needed: a file above was read\n")
        self.assertRegex(said, rf"\[filter\] framework_priority_onnx +a +{re.escape(str(path))}:6 +"
                               r"overridden by \[filter\] priority_onnx \(WEIR_FILTER_PRIORITY_ONNX\)\n")
        self.assertRegex(said, rf"\[pytorch\] enable_use_gpu +1 +{re.escape(str(extra))}:6 +"
                               r"without effect: Weir's engine pytorch runs on the processor\n")
        self.assertRegex(said, rf"\[own\] key +1 +{re.escape(str(extra))}:4")
        self.assertRegex(said, rf"filters +{re.escape(str(self.folder))} +{re.escape(str(path))}:7 +there\n")
        self.assertRegex(said, r"trainers +/no/trainers +NNSTREAMER_TRAINERS +not there\n")
        self.assertIn(f"problem: {path}:3: neither true nor false: [common] enable_symlink=perhaps", said)
        self.assertIn(f"problem: {extra}:2: the path is not absolute and is passed over: [decoder] decoders=here", said)
        told = json.loads(self.good(weir("doctor", "--json", **variables)))["nnstreamer"]
        self.assertEqual(told["files"][0], {"path": str(path), "source": "NNSTREAMER_CONF", "state": "read"})
        self.assertEqual(len(told["problems"]), 2)
        self.assertEqual({s["key"]: s["without_effect"] for s in told["settings"] if s["without_effect"]},
                         {"enable_use_gpu": "Weir's engine pytorch runs on the processor"})
        self.assertIn({"kind": "filters", "path": "/usr/lib/nnstreamer/filters", "origin": "hard-coded",
                       "found": os.path.isdir("/usr/lib/nnstreamer/filters")}, told["folders"])
        off = self.good(weir("doctor", **{**variables, "WEIR_NNSTREAMER_ENABLE": "no"}))
        self.assertIn("not used: enable=false in [nnstreamer]\n", off)
        self.assertNotIn(str(path), off)

    def test_doctor_lists_sub_plugins_for_nnstreamer(self):
        (self.folder / "libnnstreamer_decoder_text.so").write_text("no shared object")
        (self.folder / "libnnstreamer_trainer_linked.so").symlink_to("libnnstreamer_decoder_text.so")
        path = self.folder / "nns.ini"
        path.write_text(f"[decoder]\ndecoders={self.folder}\n[trainer]\ntrainer={self.folder}\n")
        variables = {"NNSTREAMER_CONF": str(path), "WEIR_NNSTREAMER_ENABLE": "yes", "WEIR_NNSTREAMER_LIBRARY": "/no/lib.so"}
        said = self.good(weir("doctor", **variables))
        self.assertIn("their functions: /no/lib.so: not there\n", said)
        self.assertRegex(said, rf"decoder +text +refused +{re.escape(str(self.folder))}/libnnstreamer_decoder_text.so\n")
        self.assertIn("the decoder text is refused\n    reason: the library with the functions that sub-plugins", said)
        self.assertNotIn("linked", said, "links are passed over")
        told = json.loads(self.good(weir("doctor", "--json", **variables)))["sub_plugins"]
        self.assertEqual([(f["kind"], f["name"], f["state"]) for f in told["files"] if f["file"].startswith(str(self.folder))],
                         [("decoder", "text", "refused")])
        self.assertEqual((told["library"], told["found"]), ("/no/lib.so", False))

    def test_inspect_explains_the_choice_of_the_engine(self):
        model = self.folder / "a.scl"
        model.write_text("x")
        path = self.ini("[filter]\npriority_scl=nobody, scaling, fake\n")
        told = json.loads(self.good(weir("inspect", "--json", model, WEIR_CONFIG=str(path))))["engine"]
        self.assertEqual(told["name"], "scaling")
        self.assertEqual(told["reason"],
                         f"the file's name ends in .scl; first that is installed of priority_scl ({path}:2)")
        self.assertEqual(told["others"], ["fake"])
        said = self.good(weir("inspect", model, WEIR_CONFIG=str(path), WEIR_FILTER_PRIORITY_SCL="fake"))
        self.assertIn("Engine  fake 1: the file's name ends in .scl; first that is installed of priority_scl "
                      "(WEIR_FILTER_PRIORITY_SCL)", said)
        self.refused(weir("inspect", model), 1, "WEIR-3001: no engine claims this model file by its name")

    def test_modules_are_looked_for_in_folders_of_the_configuration(self):
        path = self.ini(f"[module]\npath={self.folder}:{os.environ['WEIR_MODULE_PATH']}\n")
        without = {name: value for name, value in os.environ.items() if name != "WEIR_MODULE_PATH"}
        done = subprocess.run([os.environ["WEIR_COMMAND"], "inspect", "--framework", "scaling"], text=True, capture_output=True,
                              env={**without, "WEIR_CONFIG": str(path)}, timeout=60, check=False)
        self.assertIn("Engine  scaling", done.stdout + done.stderr)

    def test_a_plugin_that_cannot_be_loaded_is_an_error_with_its_reason(self):
        (self.folder / PLUGIN.name).write_text("no plug-in")
        paths = self.plugins_of(self.folder)
        self.refused(weir("doctor", **paths), 1, f"cannot be loaded: {self.folder / PLUGIN.name}", "reason: ")
        done = weir("doctor", "--json", **paths)
        told = json.loads(done.stdout)
        self.assertEqual((done.returncode, told["usable"], told["plugin"]["found"]), (1, False, False))
        self.assertIn("file too short", told["plugin"]["load_error"])

    def test_a_second_copy_is_a_conflict(self):
        copy = pathlib.Path(shutil.copy(PLUGIN, self.folder))
        said = self.good(weir("doctor", **self.plugins_of(PLUGIN.parent, self.folder)))
        self.assertIn("another copy of Weir's plug-in", said)
        self.assertIn(str(copy), said)


class Inspect(Case):
    @unittest.skipUnless(HAS_ONNX, "the engine onnxruntime is not built")
    def test_it_describes_the_model_in_both_orders(self):
        said = self.good(weir("inspect", MODEL))
        for words in ("1:192:32:1", "(1, 32, 192, 1)", "13:12:1", "(1, 12, 13)", "float32", "onnxruntime"):
            self.assertIn(words, said)

    @unittest.skipUnless(HAS_ONNX, "the engine onnxruntime is not built")
    def test_json_and_the_line_it_gives_runs(self):
        told = json.loads(self.good(weir("inspect", "--json", MODEL)))
        self.assertEqual(told["inputs"][0]["shape"], [1, 32, 192, 1])
        self.assertEqual(told["inputs"][0]["dimension"], "1:192:32:1")
        self.assertEqual(told["engine"]["name"], "onnxruntime")
        self.assertIn(".onnx", told["engine"]["reason"])
        self.assertTrue(told["launch"].startswith("gst-launch-1.0 "))
        self.assertIn("option=typecast:float32,add:-127.5,mul:0.00784313725", told["launch"])  # as its card says
        self.assertEqual((pathlib.Path(told["card"]["path"]).name, told["notes"]), ("clock_digits.card.json", []))
        self.assertEqual((told["metadata"]["opset"], told["metadata"].get("model_version")), ({"ai.onnx": 11}, None))
        self.runs(told["launch"])

    def test_an_engine_by_name(self):
        model = self.folder / "model.bin"
        model.write_text("x")
        said = self.good(weir("inspect", "-f", "fake", model))
        self.assertIn("--framework fake", said)
        self.assertIn("4:?", said)

    def inspected(self, name):
        """What is said and told of a model of the engine fake-models, whose line must run."""
        model = self.folder / name
        model.write_text("the engine looks at the name alone")
        told = json.loads(self.good(weir("inspect", "--json", "-f", "fake-models", model)))
        self.assertIn("framework=fake-models", told["launch"])
        self.runs(told["launch"])
        return self.good(weir("inspect", "-f", "fake-models", model)), told

    def test_a_quantised_picture_of_any_size(self):
        said, told = self.inspected("quantised.bin")
        self.assertRegex(said, r"0 +picture +uint8 +3:\?:\?:1 +\(1, \?, \?, 3\) +NHWC +0\.0078125 \* \(value - 128\)\n")
        self.assertRegex(said, r"0 +classes +uint8 +5:1 +\(1, 5\) +none +the value\n")
        self.assertIn("note: the model leaves sizes open, and the line chose --input 3:224:224:1 --inputtype uint8; "
                      f"others: weir inspect --input DIMENSIONS --inputtype TYPES {told['model']}\n", said)
        self.assertFalse(any("does not take" in note for note in told["notes"]))
        self.assertEqual(told["inputs"][0], {
            "name": "picture", "type": "uint8", "dimension": "3:?:?:1", "shape": [1, None, None, 3], "layout": "NHWC",
            "quantisation": {"scale": 0.0078125, "zero_point": 128}})
        self.assertIsNone(told["outputs"][0]["quantisation"])
        self.assertEqual(told["engine"]["version"], "3.1")

    @unittest.skipUnless(LENET.is_file() and "pytorch" in os.environ["WEIR_MODULE_PATH"], "pytorch is not built, or ../shared is not there")
    def test_what_a_line_chose_and_the_model_does_not_take_is_told(self):
        told = json.loads(self.good(weir("inspect", "--json", LENET, **WITHOUT_LEAKS)))
        self.assertIn(f"the model leaves sizes open, and the line chose --input 1 --inputtype float32; others: weir inspect --input "
                      f"DIMENSIONS --inputtype TYPES {LENET}", told["notes"])
        refused = [note for note in told["notes"] if note.startswith("tried, and the model does not take what the line chose: ")]
        self.assertRegex(" ".join(refused), "Dimension out of range")
        told = json.loads(self.good(weir("inspect", "--json", "--input", "1:28:28:1", "--inputtype", "uint8", LENET, **WITHOUT_LEAKS)))
        self.assertFalse(any("chose" in note for note in told["notes"]))
        self.runs(told["launch"], **WITHOUT_LEAKS)

    def test_what_the_file_says_of_itself_is_shown(self):
        said, told = self.inspected("quantised.bin")
        block = said.partition("The file says\n")[2].partition("\n\n")[0]
        self.assertRegex(block, r"description +made for tests \[31m\n")
        self.assertRegex(block, r"classes +\[1,2\]\n")
        self.assertRegex(block, r"licence +a{120} \.\.\.$")
        self.assertNotIn("author", block)
        self.assertTrue(told["metadata"]["licence"].endswith("a end"))
        self.assertEqual(told["metadata"]["description"], "made for\ttests\033[31m")

    def test_metadata_that_are_none_are_left_out(self):
        said, told = self.inspected("planar.bin")
        self.assertNotIn("The file says", said)
        self.assertIsNone(told["metadata"])

    def test_pictures_of_other_layouts_and_types_get_lines_that_run(self):
        said, told = self.inspected("planar.bin")
        self.assertRegex(said, r"picture +float32 +24:16:3:1 +\(1, 3, 16, 24\) +NCHW")
        self.assertIn("option=1:2:0:3", told["launch"])
        said, told = self.inspected("signed.bin")
        self.assertRegex(said, r"0 +- +int8 +1:8:8:2 +\(2, 8, 8, 1\)")
        self.assertIn("frames-per-tensor=2", told["launch"])
        self.assertTrue(any("how pixels become numbers" in note for note in told["notes"]))

    def script(self, name, *words):
        """What is said and told of a script of the engine python3."""
        done = weir("inspect", "--json", *words, f"src/modules/engines/python3/{name}.py")
        if done.returncode == 1 and "WEIR-3002" in done.stdout:
            self.skipTest(json.loads(done.stdout)["error"]["what"])
        return self.good(weir("inspect", *words, f"src/modules/engines/python3/{name}.py")), json.loads(self.good(done))

    def test_a_script_that_takes_any_tensors_gets_a_line_that_runs(self):
        said, told = self.script("passthrough")
        self.assertIn("Inputs\n  as the stream decides\n\nOutputs\n  as the stream decides\n", said)
        self.assertEqual((told["inputs"], told["outputs"], told["engine"]["name"]), ([], [], "python3"))
        self.assertTrue(any("whatever tensors the stream has" in note for note in told["notes"]))
        self.runs(told["launch"])

    def test_a_script_that_fails_says_where(self):
        script = self.folder / "fails.py"
        script.write_text("class CustomFilter:\n    raise ValueError('not today')\n")
        done = weir("inspect", script)
        if "WEIR-3002" in done.stderr:
            self.skipTest("Python is not installed as a library")
        self.refused(done, 1, "the script failed: ValueError: not today", f"{script}:2 in CustomFilter")

    def test_several_inputs_get_a_line_that_runs(self):
        said, told = self.inspected("several.bin")
        self.assertRegex(said, r"1 +weights +float64 +4 +\(4,\)")
        self.assertIn("input-dim=3:2,4 input-type=int16,float64", told["launch"])
        self.assertTrue(any("zeros" in note for note in told["notes"]))

    def test_a_model_that_takes_what_the_stream_has(self):
        script = SOURCE / "src/modules/engines/python3/passthrough.py"
        done = weir("inspect", script)
        if "WEIR-3002" in done.stderr:
            self.skipTest("Python or NumPy is not installed")
        said = self.good(done)
        self.assertIn("Inputs\n  as the stream decides\n", said)
        self.assertIn("weir inspect --input 3:224:224:1 --inputtype uint8", said)
        told = json.loads(self.good(weir("inspect", "--json", "--input", "3:8:8:1,5", "--inputtype", "uint8,int32", script)))
        self.assertEqual([t["dimension"] for t in told["outputs"]], ["3:8:8:1", "5"])
        self.assertEqual([t["type"] for t in told["outputs"]], ["uint8", "int32"])
        self.assertIn("input=3:8:8:1,5 inputtype=uint8,int32", told["launch"])
        self.runs(told["launch"])
        self.refused(weir("inspect", "--input", "x:8", script), 1, "WEIR-1002", 'at "x:8"')

    def test_a_script_in_lua(self):
        script = SOURCE / "src/modules/engines/lua/halves.lua"
        done = weir("inspect", "--json", script)
        if "WEIR-3002" in done.stdout:
            self.skipTest("LuaJIT is not installed")
        told = json.loads(self.good(done))
        self.assertEqual(([t["dimension"] for t in told["inputs"]], told["outputs"][0]["type"]), (["3:8:8:1"], "float32"))
        self.assertEqual((told["engine"]["name"], told["metadata"]["language"]), ("lua", "Lua"))
        self.runs(told["launch"])
        broken = self.folder / "broken.lua"
        broken.write_text("inputTensorsInfo = {num = 2, dim = {{1}}, type = {'uint8'}}")
        self.refused(weir("inspect", broken), 1, "WEIR-3004", "inputTensorsInfo.dim has another length")

    def test_a_name_that_a_shell_would_take_apart_is_quoted(self):
        _, told = self.inspected("a quantised \"one\" isn't $HOME.bin")
        self.assertIn("model='", told["launch"])

    @unittest.skipUnless(HAS_ONNX, "the engine onnxruntime is not built")
    def test_options_of_the_engine_open_the_model_and_stand_in_the_line(self):
        told = json.loads(self.good(weir("inspect", "--json", "--custom", "NumThreads:1,GraphOptimization:none", MODEL)))
        self.assertIn("custom=NumThreads:1,GraphOptimization:none", told["launch"])
        self.refused(weir("inspect", "--custom", "GraphOptimization:much", MODEL), 1, "GraphOptimization")

    @unittest.skipUnless(HAS_ONNX, "the engine onnxruntime is not built")
    def test_a_damaged_model_is_refused(self):
        damaged = self.folder / "damaged.onnx"
        damaged.write_bytes(MODEL.read_bytes()[:5000])
        self.refused(weir("inspect", damaged), 1, "WEIR-3004", "damaged.onnx")
        self.assertEqual(json.loads(weir("inspect", "--json", damaged).stdout)["error"]["id"], "WEIR-3004")

    def test_an_engine_of_no_known_name_is_refused_with_a_guess(self):
        self.refused(weir("inspect", "-f", "onnxruntme", MODEL), 1, "WEIR-3001", "did you mean onnxruntime?")

    def test_a_missing_model_is_refused_with_a_guess(self):
        self.refused(weir("inspect", "-f", "fake", SOURCE / "models" / "clock_digit.onnx"), 1, "WEIR-3003",
                     "did you mean clock_digits.onnx?")

    def test_what_is_no_model_is_refused(self):
        self.refused(weir("inspect", SOURCE / "README.md"), 1, "WEIR-3001", "no engine claims")
        self.refused(weir("inspect", ""), 1, "WEIR-3003")

    def test_a_missing_engine_is_refused_with_its_command(self):
        self.refused(weir("inspect", MODEL, WEIR_MODULE_PATH=str(self.folder)), 1, "WEIR-3002",
                     "tools/setup --engine onnxruntime")

    def test_errors_are_json_too(self):
        done = weir("inspect", "--json", MODEL, WEIR_MODULE_PATH=str(self.folder))
        error = json.loads(done.stdout)["error"]
        self.assertEqual((done.returncode, error["id"]), (1, "WEIR-3002"))
        self.assertIn("fix", error)


if __name__ == "__main__":
    tap_runner.main()
