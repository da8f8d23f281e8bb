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
from weir_case import DECOY, HAS_ONNX, MODEL, PLUGIN, SOURCE, Case, weir


class Usage(Case):
    def test_help_names_the_subcommands(self):
        said = self.good(weir("--help"))
        for name in ("doctor", "inspect", "run"):
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
    def plugins_of(self, *folders):
        """Variables for a GStreamer that finds the plug-ins of these folders alone, and looks anew."""
        return {"GST_PLUGIN_PATH": ":".join(map(str, folders)), "GST_PLUGIN_SYSTEM_PATH_1_0": str(self.folder / "none"),
                "GST_REGISTRY": str(self.folder / f"registry-{folders[0].name}")}

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

    def test_a_module_that_cannot_be_used_is_named(self):
        (self.folder / "libweir-engine-onnxruntime.so").write_text("no module")
        said = self.good(weir("doctor", WEIR_MODULE_PATH=str(self.folder)))
        self.assertIn("onnxruntime is refused", said)
        self.assertIn(str(self.folder / "libweir-engine-onnxruntime.so"), said)

    def test_a_missing_plugin_is_an_error_with_its_fix(self):
        self.refused(weir("doctor", **self.plugins_of(self.folder)), 1, "not found", str(self.folder), "make install")

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

    def test_another_plugin_with_the_same_elements_is_a_conflict(self):
        def conflicts(*folders):
            """By the plug-in that tensor_filter comes from: the one that GStreamer reads last."""
            variables = self.plugins_of(*folders)
            told = json.loads(self.good(weir("doctor", "--json", **variables)))
            owner = {e["name"]: e["plugin"] for e in told["elements"]}["tensor_filter"]
            return owner, told["conflicts"], self.good(weir("doctor", **variables))

        results = {r[0]: r for r in (conflicts(DECOY.parent, PLUGIN.parent), conflicts(PLUGIN.parent, DECOY.parent))}
        self.assertEqual(set(results), {"weir", "decoy"})
        self.assertEqual(results["weir"][1], [])
        _, found, said = results["decoy"]
        self.assertEqual([(c["plugin"], c["file"]) for c in found], [("decoy", str(DECOY))])
        self.assertIn("GStreamer takes tensor_filter from it, not from Weir", found[0]["reason"])
        for words in (f"plug-in decoy: {DECOY}", found[0]["reason"], "fix: remove the package"):
            self.assertIn(words, said)


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
        self.assertIn("note: the model leaves sizes open", said)
        self.assertEqual(told["inputs"][0], {
            "name": "picture", "type": "uint8", "dimension": "3:?:?:1", "shape": [1, None, None, 3], "layout": "NHWC",
            "quantisation": {"scale": 0.0078125, "zero_point": 128}})
        self.assertIsNone(told["outputs"][0]["quantisation"])
        self.assertEqual(told["engine"]["version"], "3.1")

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

    def test_several_inputs_get_a_line_that_runs(self):
        said, told = self.inspected("several.bin")
        self.assertRegex(said, r"1 +weights +float64 +4 +\(4,\)")
        self.assertIn("input-dim=3:2,4 input-type=int16,float64", told["launch"])
        self.assertTrue(any("zeros" in note for note in told["notes"]))

    def test_a_name_that_a_shell_would_take_apart_is_quoted(self):
        _, told = self.inspected("a quantised \"one\" isn't $HOME.bin")
        self.assertIn("model='", told["launch"])

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
