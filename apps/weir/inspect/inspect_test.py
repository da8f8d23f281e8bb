#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Tests of `weir inspect`: its output for people and for programs."""

import hashlib
import json
import os
import pathlib
import re
import shutil
import subprocess
import unittest

import numpy
import onnx_writer
import tap_runner
from weir_case import HAS_ONNX, MODEL, SOURCE, WITHOUT_LEAKS, Case, weir

SHARED = pathlib.Path(os.environ.get("WEIR_DATA") or SOURCE / "../shared")
LENET = SHARED / "models/torchscript/pytorch_lenet5.pt"


class Inspect(Case):
    @unittest.skipUnless(HAS_ONNX, "the engine onnxruntime is not built")
    def test_it_describes_the_model_in_both_orders(self):
        output = self.good(weir("inspect", MODEL))
        for words in ("1:192:32:1", "(1, 32, 192, 1)", "13:12:1", "(1, 12, 13)", "float32", "onnxruntime"):
            self.assertIn(words, output)

    @unittest.skipUnless(HAS_ONNX, "the engine onnxruntime is not built")
    def test_json_and_the_line_it_gives_runs(self):
        report = json.loads(self.good(weir("inspect", "--json", MODEL)))
        self.assertEqual(report["inputs"][0]["shape"], [1, 32, 192, 1])
        self.assertEqual(report["inputs"][0]["dimension"], "1:192:32:1")
        self.assertEqual(report["engine"]["name"], "onnxruntime")
        self.assertIn(".onnx", report["engine"]["reason"])
        self.assertTrue(report["launch"].startswith("gst-launch-1.0 "))
        self.assertIn("option=typecast:float32,add:-127.5,mul:0.00784313725", report["launch"])  # as in the model's card
        self.assertEqual((pathlib.Path(report["card"]["path"]).name, report["notes"]), ("clock_digits.card.json", []))
        self.assertEqual((report["metadata"]["opset"], report["metadata"].get("model_version")), ({"ai.onnx": 11}, None))
        self.runs(report["launch"])

    def test_an_engine_by_name(self):
        model = self.folder / "model.bin"
        model.write_text("x")
        output = self.good(weir("inspect", "-e", "fake", model))
        self.assertIn("--engine fake", output)
        self.assertIn("4:?", output)

    def test_the_former_name_of_the_engine_option_is_taken_but_not_with_the_present_one(self):
        for option in ("-f", "--framework"):
            self.assertIn("--engine fake", self.good(weir("inspect", option, "fake")))
        self.refused(weir("inspect", "-e", "fake", "-f", "fake"), 2, "excludes")
        self.assertNotIn("--framework", self.good(weir("help", "inspect")))
        self.refused(weir("inspect"), 2, "MODEL or --engine")

    def card(self, *words, copy_of=MODEL):
        model = self.folder / copy_of.name
        model.write_bytes(copy_of.read_bytes())
        return model, weir("card", model, *words)

    @unittest.skipUnless(HAS_ONNX, "the engine onnxruntime is not built")
    def test_a_card_has_what_weir_try_assumes(self):
        """1344 cells are those of 256 x 256. The card reads them as weir try did without it."""
        for metadata, decoder, resize, scale in (([("task", "detect")], "detection", "letterbox", [1 / 255]),
                                                 ([("task", "?")], "classification?", "stretch, crop or letterbox?", ["?"])):
            model, card_path = self.folder / "own.onnx", self.folder / "own.card.json"
            model.write_bytes(onnx_writer.model(
                [("ReduceMean", ("image",), "mean"), ("Add", ("mean", "a"), "out")], {"a": numpy.zeros((1, 1, 9, 1344), "f")},
                [("image", (1, 3, 256, 256))], [("out", (1, 1, 9, 1344))], metadata))
            places = {"WEIR_CARD_PATH": str(self.folder / "none"), **WITHOUT_LEAKS}
            done = weir("card", model, **places)
            card = json.loads(self.good(done))
            self.assertEqual(os.listdir(self.folder), ["own.onnx"])
            self.assertIn(f"weir card {model} --output {card_path}\n", done.stderr)
            by_engine = weir("card", model, "--engine", "onnxruntime", **places)
            self.assertEqual(json.loads(self.good(by_engine)), card)
            self.assertIn(f"weir card {model} --engine onnxruntime --output {card_path}\n", by_engine.stderr)
            self.assertEqual((card["decoder"], card["inputs"][0]["resize"]), (decoder, resize))
            self.assertEqual("WEIR-2001: the outputs can be read as " in done.stderr, scale == ["?"], done.stderr)
            if scale == ["?"]:
                self.assertEqual(card["inputs"][0]["scale"], scale)
                continue
            numpy.testing.assert_allclose(card["inputs"][0]["scale"], scale)
            assumed = weir("try", model, "test", "--json", **places)
            self.good(weir("card", model, "--output", card_path, **places))
            by_card = weir("try", model, "test", "--json", **places)
            self.assertEqual(self.good(by_card), self.good(assumed))
            self.assertIn(f"card={card_path}", by_card.stderr)
            again = weir("card", model, **places)
            self.good(again)
            self.assertNotIn("--output", again.stderr, "it refuses to replace the card")
            # The model is trained again: its card is corrected by the fix.
            model.write_bytes(model.read_bytes() + b"\x72\x00")
            refused = weir("try", model, "test", **places | {"WEIR_CARD_PATH": str(self.folder)})
            self.refused(refused, 1, "the card next to the model belongs to a different file", "if you trained the model again")
            subprocess.run(re.search("fix: (sed .*)", refused.stderr)[1], shell=True, check=True)
            self.good(weir("try", model, "test", "--json", **places))
            # The card of a model of the catalogue is right: the file is not.
            installed = self.folder / "installed"
            installed.mkdir()
            shutil.copy(card_path, installed)
            model.write_bytes(model.read_bytes() + b"\x72\x00")
            refused = weir("try", model, "test", **places | {"WEIR_CARD_PATH": str(installed)})
            self.refused(refused, 1, "the card next to the model belongs to a different file", ": download the model again\n")
            self.assertNotIn("sed", refused.stderr)
            shutil.rmtree(installed)
            card_path.unlink()

    @unittest.skipUnless(HAS_ONNX, "the engine onnxruntime is not built")
    def test_a_card_to_fill_in_is_written_and_its_open_fields_are_all_named(self):
        model = self.folder / MODEL.name
        path = model.with_suffix(".card.json")
        model, done = self.card("--output", path)
        self.assertIn(f"{path}\n\nReplace each \"?\", then: weir inspect {model}\n", self.good(done))
        card = json.loads(path.read_text())
        self.assertEqual((card["name"], card["model"]), ("clock_digits", "clock_digits.onnx"))
        self.assertEqual(card["sha256"], hashlib.sha256(model.read_bytes()).hexdigest())
        self.assertEqual(card["inputs"][0]["shape"], [1, 32, 192, 1])
        self.assertEqual((card["inputs"][0]["layout"], card["inputs"][0]["color"]), ("NHWC", "GRAY8"))
        self.assertIn("letterbox", card["inputs"][0]["resize"])
        self.assertEqual([output["shape"] for output in card["outputs"]], [[1, 12, 13]])
        for words in (("inspect", model), ("try", model, "test"), ("bench", "--seconds", "0.05", "-t", "1", "-b", "1", model)):
            output = weir(*words).stdout + weir(*words).stderr
            for field in ("inputs/0/mean", "inputs/0/scale", "inputs/0/resize", "decoder"):
                self.assertIn(f"{path}/{field}: ", output, words)
        filled = {"mean": [127.5], "scale": [1 / 127.5], "resize": "stretch"}
        card["inputs"][0].update(filled)
        card["decoder"] = "image_labeling"
        path.write_text(json.dumps(card))
        self.assertIn(f"Card    {path}: ", self.good(weir("inspect", model)))

    @unittest.skipUnless(HAS_ONNX, "the engine onnxruntime is not built")
    def test_a_card_that_is_a_folder_is_reported_as_one(self):
        model, done = self.card("--output", "-")
        self.good(done)
        model.with_suffix(".card.json").mkdir()
        output = self.good(weir("inspect", model))
        self.assertIn("Card\nWEIR-4001: the model card cannot be read\n", output)
        self.assertIn("first difference: it is a folder\n", output)
        self.assertNotIn("weir card prints one", output)

    @unittest.skipUnless(HAS_ONNX, "the engine onnxruntime is not built")
    def test_names_of_the_catalogue_are_models_too(self):
        places = {"WEIR_CARD_PATH": str(SOURCE / "models" / "cards"), "WEIR_MODELS": str(self.folder)}
        for words in (("inspect",), ("card", "-o", "-"), ("bench", "--seconds", "0.05")):
            self.refused(weir(*words, "mnist", **places), 1, "WEIR-3003: the model has not been downloaded", "fix: weir models get mnist\n")
        self.assertIn(str(self.downloaded("mnist")), weir("inspect", "mnist", **places).stderr)
        self.refused(weir("inspect", "mnisst", **places), 1, "WEIR-3003: the model file does not exist", "offered: mnisst")

    def test_a_model_without_pictures_needs_no_card(self):
        model = self.folder / "numbers.fake"
        model.write_text("x")
        self.assertNotIn("weir card", self.good(weir("inspect", "--engine", "fake", model)))

    @unittest.skipUnless(HAS_ONNX, "the engine onnxruntime is not built")
    def test_a_card_goes_where_it_is_asked_for_and_replaces_nothing(self):
        model, done = self.card("--output", "-")
        self.assertEqual(json.loads(self.good(done))["name"], "clock_digits")
        self.assertEqual(list(self.folder.iterdir()), [model])
        path = self.folder / "there.json"
        path.write_text("mine")
        self.refused(weir("card", model, "-o", path), 1, "WEIR-4010: a file with this name already exists", f"offered: {path}",
                     f"fix: weir card {model} --output new.card.json")
        self.assertEqual(path.read_text(), "mine")
        self.refused(weir("card", model, "-o", self.folder / "none" / "x.json"), 1, "WEIR-4010: the card cannot be written", "No such file")

    @unittest.skipUnless(LENET.exists() and "pytorch" in os.environ["WEIR_MODULE_PATH"], "needs the test data and the engine pytorch")
    def test_a_card_needs_the_dimensions_of_the_inputs(self):
        self.refused(weir("card", LENET, **WITHOUT_LEAKS), 1, "the file does not have the dimensions of its inputs, which a card needs",
                     f"fix: weir inspect {LENET}")

    def test_a_card_needs_a_model_with_a_picture(self):
        self.refused(weir("card", "/no/such.onnx"), 1, "WEIR-3003: the model file does not exist")
        model = self.folder / "numbers.bin"
        model.write_text("x")
        self.refused(weir("card", "--engine", "fake", model), 1, "the model has no input for pictures, and a card describes only these",
                     f"fix: weir inspect {model}")
        self.refused(weir("card"), 2, "MODEL")

    def test_an_engine_that_is_not_there_is_named_by_every_command(self):
        photo = self.folder / "cat" / "photo.png"
        photo.parent.mkdir()
        photo.write_bytes(b"")
        for words in (("inspect", MODEL), ("try", MODEL, photo), ("evaluate", MODEL, self.folder)):
            self.refused(weir(*words, "--engine", "no-such-engine"), 1, "no-such-engine")

    def inspected(self, name):
        """The text and the JSON output for a model of the engine fake-models, whose pipeline must run."""
        model = self.folder / name
        model.write_text("the engine only looks at the name")
        report = json.loads(self.good(weir("inspect", "--json", "-f", "fake-models", model)))
        self.assertIn("framework=fake-models", report["launch"])
        self.runs(report["launch"])
        return self.good(weir("inspect", "-f", "fake-models", model)), report

    def test_a_quantised_picture_of_any_size(self):
        output, report = self.inspected("quantised.bin")
        self.assertRegex(output, r"0 +picture +uint8 +3:\?:\?:1 +\(1, \?, \?, 3\) +NHWC +0\.0078125 \* \(value - 128\)\n")
        self.assertRegex(output, r"0 +classes +uint8 +5:1 +\(1, 5\) +none +the value\n")
        self.assertIn("note: the model leaves sizes open; the line uses --input 3:224:224:1 --inputtype uint8; "
                      f"for other sizes, run weir inspect --engine fake-models --input DIMENSIONS --inputtype TYPES {report['model']}\n", output)
        self.assertFalse(any("rejects the sizes" in note for note in report["notes"]))
        self.assertEqual(report["inputs"][0], {
            "name": "picture", "type": "uint8", "dimension": "3:?:?:1", "shape": [1, None, None, 3], "layout": "NHWC",
            "quantisation": {"scale": 0.0078125, "zero_point": 128}})
        self.assertIsNone(report["outputs"][0]["quantisation"])
        self.assertEqual(report["engine"]["version"], "3.1")

    @unittest.skipUnless(LENET.is_file() and "pytorch" in os.environ["WEIR_MODULE_PATH"], "pytorch is not built, or ../shared is not there")
    def test_a_model_without_declared_inputs_gets_no_line_that_fails(self):
        report = json.loads(self.good(weir("inspect", "--json", LENET, **WITHOUT_LEAKS)))
        self.assertEqual((report["launch"], report["notes"]), ("", [
            "the file does not have the dimensions of its inputs; with those of your model, weir inspect --input 3:224:224:1 --inputtype float32 "
            f"{LENET} prints a pipeline"]))
        self.assertIn("To run it\n  note: the file does not have", self.good(weir("inspect", LENET, **WITHOUT_LEAKS)))
        report = json.loads(self.good(weir("inspect", "--json", "--input", "1:28:28:1", "--inputtype", "uint8", LENET, **WITHOUT_LEAKS)))
        self.assertFalse(any("chose" in note for note in report["notes"]))
        self.runs(report["launch"], **WITHOUT_LEAKS)

    def test_metadata_of_the_file_is_shown(self):
        output, report = self.inspected("quantised.bin")
        block = output.partition("The file says\n")[2].partition("\n\n")[0]
        self.assertRegex(block, r"description +made for tests \[31m\n")
        self.assertRegex(block, r"classes +\[1,2\]\n")
        self.assertRegex(block, r"licence +a{120} \.\.\.$")
        self.assertNotIn("author", block)
        self.assertTrue(report["metadata"]["licence"].endswith("a end"))
        self.assertEqual(report["metadata"]["description"], "made for\ttests\033[31m")

    def test_metadata_that_are_none_are_left_out(self):
        output, report = self.inspected("planar.bin")
        self.assertNotIn("The file says", output)
        self.assertIsNone(report["metadata"])

    def test_pictures_of_other_layouts_and_types_get_lines_that_run(self):
        output, report = self.inspected("planar.bin")
        self.assertRegex(output, r"picture +float32 +24:16:3:1 +\(1, 3, 16, 24\) +NCHW")
        self.assertIn("option=1:2:0:3", report["launch"])
        output, report = self.inspected("signed.bin")
        self.assertRegex(output, r"0 +- +int8 +1:8:8:2 +\(2, 8, 8, 1\)")
        self.assertIn("frames-per-tensor=2", report["launch"])
        self.assertTrue(any("how pixels become numbers" in note for note in report["notes"]))

    def script(self, name, *words):
        """The text and the JSON output for a script of the engine python3."""
        done = weir("inspect", "--json", *words, f"src/modules/engines/python3/{name}.py")
        if done.returncode == 1 and "WEIR-3002" in done.stdout:
            self.skipTest(json.loads(done.stdout)["error"]["what"])
        return self.good(weir("inspect", *words, f"src/modules/engines/python3/{name}.py")), json.loads(self.good(done))

    def test_a_script_that_takes_any_tensors_gets_a_line_that_runs(self):
        output, report = self.script("passthrough")
        self.assertIn("Inputs\n  depend on the stream\n\nOutputs\n  depend on the stream\n", output)
        self.assertEqual((report["inputs"], report["outputs"], report["engine"]["name"]), ([], [], "python3"))
        self.assertTrue(any("the model accepts any tensors" in note for note in report["notes"]))
        self.runs(report["launch"])

    def test_a_failing_script_reports_where(self):
        script = self.folder / "fails.py"
        script.write_text("class CustomFilter:\n    raise ValueError('not today')\n")
        done = weir("inspect", script)
        if "WEIR-3002" in done.stderr:
            self.skipTest("Python is not installed as a library")
        self.refused(done, 1, "the script failed: ValueError: not today", f"{script}:2 in CustomFilter")

    def test_several_inputs_get_a_line_that_runs(self):
        output, report = self.inspected("several.bin")
        self.assertRegex(output, r"1 +weights +float64 +4 +\(4,\)")
        self.assertIn("input-dim=3:2,4 input-type=int16,float64", report["launch"])
        self.assertTrue(any("zeros" in note for note in report["notes"]))

    def test_a_model_that_takes_what_the_stream_has(self):
        script = SOURCE / "src/modules/engines/python3/passthrough.py"
        done = weir("inspect", script)
        if "WEIR-3002" in done.stderr:
            self.skipTest("Python or NumPy is not installed")
        output = self.good(done)
        self.assertIn("Inputs\n  depend on the stream\n", output)
        self.assertIn("weir inspect --input 3:224:224:1 --inputtype uint8", output)
        report = json.loads(self.good(weir("inspect", "--json", "--input", "3:8:8:1,5", "--inputtype", "uint8,int32", script)))
        self.assertEqual([t["dimension"] for t in report["outputs"]], ["3:8:8:1", "5"])
        self.assertEqual([t["type"] for t in report["outputs"]], ["uint8", "int32"])
        self.assertIn("input=3:8:8:1,5 inputtype=uint8,int32", report["launch"])
        self.runs(report["launch"])
        self.refused(weir("inspect", "--input", "x:8", script), 1, "WEIR-1002", 'at "x" of "x:8"')

    def test_a_script_in_lua(self):
        script = SOURCE / "src/modules/engines/lua/halves.lua"
        done = weir("inspect", "--json", script)
        if "WEIR-3002" in done.stdout:
            self.skipTest("LuaJIT is not installed")
        report = json.loads(self.good(done))
        self.assertEqual(([t["dimension"] for t in report["inputs"]], report["outputs"][0]["type"]), (["3:8:8:1"], "float32"))
        self.assertEqual((report["engine"]["name"], report["metadata"]["language"]), ("lua", "Lua"))
        self.runs(report["launch"])
        broken = self.folder / "broken.lua"
        broken.write_text("inputTensorsInfo = {num = 2, dim = {{1}}, type = {'uint8'}}")
        self.refused(weir("inspect", broken), 1, "WEIR-3004", "inputTensorsInfo.dim and inputTensorsInfo.num have different lengths")

    def test_a_name_that_a_shell_would_take_apart_is_quoted(self):
        _, report = self.inspected("a quantised \"one\" isn't $HOME.bin")
        self.assertIn("model='", report["launch"])

    @unittest.skipUnless(HAS_ONNX, "the engine onnxruntime is not built")
    def test_options_of_the_engine_open_the_model_and_stand_in_the_line(self):
        report = json.loads(self.good(weir("inspect", "--json", "--custom", "NumThreads:1,GraphOptimization:none", MODEL)))
        self.assertIn("custom=NumThreads:1,GraphOptimization:none", report["launch"])
        self.refused(weir("inspect", "--custom", "GraphOptimization:much", MODEL), 1, "GraphOptimization")

    @unittest.skipUnless(HAS_ONNX, "the engine onnxruntime is not built")
    def test_a_damaged_model_is_refused(self):
        damaged = self.folder / "damaged.onnx"
        damaged.write_bytes(MODEL.read_bytes()[:5000])
        self.refused(weir("inspect", damaged), 1, "WEIR-3004", "damaged.onnx")
        self.assertEqual(json.loads(weir("inspect", "--json", damaged).stdout)["error"]["id"], "WEIR-3004")

    def test_an_engine_of_no_known_name_is_refused_with_a_guess(self):
        self.refused(weir("inspect", "-f", "onnxruntme", MODEL), 1, "WEIR-3001", "did you mean onnxruntime?")

    def test_an_engine_is_named_by_the_option(self):
        self.refused(weir("inspect", "--engine", "onnxruntme", MODEL), 1, "offered: --engine onnxruntme", "fix: --engine onnxruntime")
        refused = weir("inspect", "--engine", "brighten")
        self.refused(refused, 1, "the file libweir-engine-brighten.so in a folder that WEIR_MODULE_PATH lists",
                     "fix: export WEIR_MODULE_PATH=/folder/of/the/module")
        self.assertNotIn("framework=", refused.stderr)
        self.refused(weir("inspect", "grpc://127.0.0.1:8001/boxes"), 1, "WEIR-3001: no engine can be selected for this model",
                     "needed: --engine oip, because the model is the address of a server", "fix: --engine oip")

    def test_a_missing_model_is_refused_with_a_guess(self):
        self.refused(weir("inspect", "-f", "fake", SOURCE / "models" / "clock_digit.onnx"), 1, "WEIR-3003",
                     "did you mean clock_digits.onnx?", f"fix: {SOURCE / 'models' / 'clock_digits.onnx'}")

    def test_what_is_no_model_is_refused(self):
        self.refused(weir("inspect", SOURCE / "README.md"), 1, "WEIR-3001", "no engine can be selected")
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
