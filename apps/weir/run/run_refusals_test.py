#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""weir run: pipelines that it refuses, each with its place and a fix."""

import json
import re
import socket
import subprocess

import tap_runner
from weir_case import PLUGIN, Case, weir


class RunRefusals(Case):
    def place(self, *words):
        """The output for a pipeline, and the pipeline's text from the caret on."""
        done = weir("run", *words)
        self.assertEqual((done.returncode, done.stdout), (1, ""))
        text, caret = re.search(r"\n    (.*)\n    ( *)\^", done.stderr).groups()
        if not text.startswith("... "):
            self.assertIn(f"at character {len(caret) + 1}:\n", done.stderr)
        return done.stderr, text[len(caret):]

    def test_a_pipeline_that_cannot_be_read_is_refused_with_its_place(self):
        output, rest = self.place('videotestsrc ! queue name="a b" ! ! fakesink')
        self.assertIn("WEIR-1001: the pipeline cannot be read", output)
        self.assertIn("needed: elements with ! between them", output)
        self.assertEqual(rest, "! fakesink")
        self.assertEqual(self.place("! fakesink")[1], "! fakesink")
        self.assertEqual(self.place("fakesrc", "!", "!", "fakesink")[1], "! fakesink")
        self.assertEqual(self.place("videotestsrc name=ü\n ! queue !")[1], "!")

    def test_an_empty_pipeline_is_refused(self):
        self.refused(weir("run", " "), 1, "the pipeline is empty", "fix: weir run")

    def test_a_pipeline_that_cannot_be_read_is_refused_in_json_too(self):
        done = weir("run", "--json", "videotestsrc ! ! fakesink")
        error = json.loads(done.stdout)["error"]
        self.assertEqual((done.returncode, error["id"], done.stderr), (1, "WEIR-1001", ""))
        self.assertIn("syntax error at character 16", error["difference"])

    def test_unknown_properties_and_values_are_refused_with_their_place(self):
        output, rest = self.place("videotestsrc ! fakesink nosuch=1")
        self.assertEqual(rest, "nosuch=1")
        self.assertIn("fix: gst-inspect-1.0 fakesink", output)
        self.assertEqual(self.place("fakesrc ! queue leaky=maybe ! fakesink")[1], "leaky=maybe ! fakesink")

    def test_an_unknown_property_value_is_reported_with_the_known_ones(self):
        line = "videotestsrc ! video/x-raw,format=RGB ! tensor_preprocess name=p width=8 height=8 "
        output, rest = self.place(line + "layout=NHCW ! fakesink")
        self.assertEqual(rest, "layout=NHCW ! fakesink")
        for words in ("WEIR-1004: tensor_preprocess does not accept this value for layout", "offered: layout=NHCW",
                      "needed: one of: auto, NHWC, NCHW\n", "did you mean NHWC? at character",
                      f"fix: {line}layout=NHWC ! fakesink\n"):
            self.assertIn(words, output)
        # Another element has a property of this name, and the value is quoted.
        output, rest = self.place('audiotestsrc ! audio/x-raw,layout=interleaved ! fakesink ' + line + 'layout = "NH WC" ! fakesink')
        self.assertEqual(rest, 'layout = "NH WC" ! fakesink')
        self.assertIn("offered: layout=NH WC\n", output)
        output, rest = self.place(*line.split(), "fit=leterbox", "!", "fakesink")
        self.assertEqual(rest, "fit=leterbox ! fakesink")
        self.assertIn("did you mean letterbox?", output)
        self.good(weir("run", line.replace("videotestsrc", "videotestsrc num-buffers=1") + "layout=NCHW fit=letterbox ! fakesink"))

    def test_an_unknown_property_comes_with_the_nearest_one(self):
        output, rest = self.place("videotestsrc ! tensor_converter ! tensor_transform mode=typecast optoin=int8 ! fakesink")
        self.assertEqual(rest, "optoin=int8 ! fakesink")
        for words in ("WEIR-1004: tensor_transform has no such property", "offered: optoin\n", "did you mean option?",
                      "fix: videotestsrc ! tensor_converter ! tensor_transform mode=typecast option=int8 ! fakesink\n"):
            self.assertIn(words, output)

    def test_a_fix_is_the_line_with_the_word_replaced_also_in_quotes(self):
        output, rest = self.place('fakesrc ! queue leaky="downstram" ! fakesink')
        self.assertEqual(rest, 'leaky="downstram" ! fakesink')
        self.assertIn('fix: fakesrc ! queue leaky="downstream" ! fakesink\n', output)
        output, _ = self.place("fakesrc ! queue leaky = downstram ! fakesink")
        self.assertIn("did you mean downstream?", output)
        self.assertIn("fix: gst-inspect-1.0 queue\n", output, "the word cannot be replaced in the line")

    def test_numbers_are_named_with_their_range(self):
        output, rest = self.place("fakesrc num-buffers=many ! fakesink")
        self.assertEqual(rest, "num-buffers=many ! fakesink")
        self.assertIn("needed: a whole number from -1 to 2147483647\n", output)

    def test_an_open_quote_and_a_lone_parenthesis_have_their_place(self):
        output, rest = self.place('fakesrc num-buffers="a ! fakesink')
        self.assertEqual(rest, '"a ! fakesink')
        self.assertIn("a quote is not closed", output)
        self.assertEqual(self.place("fakesrc ! fakesink )")[1], ")")

    def test_a_name_that_no_element_has_is_refused_with_its_place(self):
        for line, at in (("fakesrc ! a. fakesink", "a. fakesink"), ("tee name=t ! fakesink e. ! fakesink", "e. ! fakesink")):
            output, rest = self.place(line)
            self.assertEqual(rest, at)
            self.assertIn(f"no element has the name {at[0]}\n  needed: an element with name={at[0]}\n", output)

    def test_what_cannot_be_linked_is_refused(self):
        for pipeline in ("videotestsrc ! audio/x-raw ! fakesink", "videotestsrc ! audioconvert ! fakesink", "videotestsrc ! videotestsrc"):
            done = weir("run", pipeline)
            self.refused(done, 1, "WEIR-1001: videotestsrc cannot be linked to ", "first difference: could not link videotestsrc0 to ")
            self.assertNotIn("fix:", done.stderr, "no element converts this stream")

    def test_what_cannot_be_linked_comes_with_the_line_that_can(self):
        sink = "queue name=q ! tensor_converter ! fakesink videotestsrc num-buffers=2 ! video/x-raw,format=NV12 ! "
        sound = "queue name=q ! audio/x-raw,format=U8,rate=8000 ! fakesink audiotestsrc num-buffers=2 ! audio/x-raw,format=S16LE ! "
        for begin, end, converter in (
                ("videotestsrc num-buffers=2 ! ", "tensor_sink", "tensor_converter"),
                ("audiotestsrc num-buffers=2 ! ", "tensor_sink name=out", "tensor_converter"),
                ("videotestsrc num-buffers=2 ! tensor_converter ! ", "videoconvert ! fakesink", "tensor_decoder mode=direct_video"),
                (sink, "q.", "videoconvert ! videoscale"),
                (sound, "q.", "audioconvert ! audioresample")):
            output, rest = self.place(begin + end)
            self.assertEqual(rest, end)
            self.assertIn(f"  fix: {begin}{converter} ! {end}\n", output)
            self.assertEqual(weir("run", f"{begin}{converter} ! {end}").returncode, 0)

    def test_a_pad_that_an_element_cannot_have_is_refused_with_the_nearest_that_it_can(self):
        tensors = "videotestsrc num-buffers=2 ! tensor_converter ! "
        for line, element, kind, pad, name in (
                ("tensor_mux name=m ! fakesink " + tensors + "m.sinkx", "tensor_mux", "sink", "sinkx", "sink_0"),
                ("tensor_mux name=m ! fakesink " + tensors + "m.sink_0 " + tensors + "m.x", "tensor_mux", "sink", "x", "sink_1"),
                # GStreamer takes any name for pads that appear while a pipeline plays.
                (tensors + "tensor_demux name=d d.src_0z ! fakesink", "tensor_demux", "source", "src_0z", "src_0"),
                (tensors + "tee name=t ! queue ! fakesink t.sink ! queue ! fakesink", "tee", "source", "sink", "src_1"),
                ("videotestsrc num-buffers=2 name=v v.srcc ! fakesink", "videotestsrc", "source", "srcc", "src")):
            with self.subTest(line):
                output, rest = self.place(line)
                self.assertTrue(rest.startswith(pad), rest)
                self.assertIn(f"WEIR-1001: {element} has no {kind} pad with the name {pad}\n  needed: a {kind} pad of {element}: ", output)
                fix = re.search(r"(?m)^  fix: (.*)$", output)[1]
                self.assertEqual(fix, line[:-len(rest)] + name + rest[len(pad):])
                self.good(weir("run", fix))

    def test_a_pad_name_that_fits_none_while_the_only_pad_is_linked(self):
        for element in ("videoconvert", "tensor_transform mode=typecast option=float32"):
            output, rest = self.place(f"videotestsrc ! {element} name=o ! fakesink videotestsrc ! o.result")
            self.assertEqual(rest, "result")
            self.assertIn(f"  needed: a sink pad of {element.split()[0]}: sink; it is linked already\n", output)
            self.assertNotIn("fix:", output)

    def test_pads_that_elements_can_have_are_accepted(self):
        tensors = "videotestsrc num-buffers=2 ! tensor_converter ! "
        for line in (tensors + "m.sink_%u tensor_mux name=m ! fakesink", tensors + "m.sink_7 tensor_mux name=m m.src ! fakesink",
                     tensors + "tensor_demux name=d d.src_0 ! fakesink",
                     "videotestsrc num-buffers=2 ! pngenc ! decodebin name=d d.src_0 ! fakesink"):
            with self.subTest(line):
                self.good(weir("run", line))

    def test_an_address_that_cannot_be_opened_is_named_without_its_password(self):
        with socket.socket() as bound:
            bound.bind(("127.0.0.1", 0))  # and does not listen
            port = bound.getsockname()[1]
            for source, offered in ((f"tcpclientsrc host=127.0.0.1 port={port}", f"host=127.0.0.1 port={port}"),
                                    (f"rtspsrc location=rtsp://me:secret@127.0.0.1:{port}/a?token=secret", f"location=rtsp://127.0.0.1:{port}/a")):
                done = weir("run", f"{source} ! fakesink")
                self.refused(done, 1, "WEIR-6001: the address cannot be opened\n", f"offered: {offered}\n", "needed: a server that listens there")
                self.assertNotIn("secret", done.stderr)
                self.assertNotRegex(done.stderr, r"\.c\(\d+\)")

    def test_an_unknown_element_is_refused_with_its_place_and_a_guess(self):
        output, rest = self.place("videotestsrc ! tensor_convertr ! fakesink")
        self.assertEqual(rest, "tensor_convertr ! fakesink")
        for words in ("WEIR-1001: the element tensor_convertr is not installed", "did you mean tensor_converter?",
                      "fix: videotestsrc ! tensor_converter ! fakesink\n"):
            self.assertIn(words, output)

    def test_an_unknown_element_is_found_as_a_word_of_its_own(self):
        output, rest = self.place("filesrc location=foo.mp4 ! foo ! fakesink")
        self.assertEqual(rest, "foo ! fakesink")
        self.assertNotIn("fix:", output, "no element has a name like it")

    def test_elements_of_a_plugin_that_is_not_installed_come_with_its_install_command(self):
        (self.folder / "libgstweir.so").symlink_to(PLUGIN)
        environment = {"GST_PLUGIN_PATH": str(self.folder), "GST_REGISTRY": str(self.folder / "registry")}
        for name, text in (("edgesink", "the plug-in weiredge"), ("tensor_query_serversrc", "the plug-in weiredge"),
                           ("tensor_sink_grpc", "apt-get install libgrpc")):
            done = weir("run", f"videotestsrc ! {name}", **environment)
            self.refused(done, 1, f"WEIR-1001: the element {name} is not installed", text)
            self.assertRegex(done.stderr, "(?m)fix: .*make install$")

    def test_suggestions_are_related_elements(self):
        self.assertNotIn("did you mean", self.place("tensor_grpc_ssl ! fakesink")[0])
        self.assertIn("did you mean tensor_demux?", self.place("tensor_dmux ! fakesink")[0])

    def test_elements_of_nnstreamer_that_weir_lacks_are_named_with_an_alternative(self):
        for name, alternative in (("tensor_src_iio", "appsrc in a program that reads the sensor"),
                                  ("tensor_trainer", "tensor_filter, with a model that was trained elsewhere")):
            if subprocess.run(["gst-inspect-1.0", "--exists", name]).returncode == 0:
                continue  # this build has it
            output, rest = self.place(f"fakesrc ! {name} ! fakesink")
            self.assertEqual(rest, f"{name} ! fakesink")
            self.assertIn(f"WEIR-1001: Weir has no element {name} of NNStreamer\n  needed: {alternative}", output)
            self.assertNotIn("fix:", output)

    def test_the_caret_is_below_caps_that_the_source_does_not_make(self):
        self.assertEqual(self.place("videotestsrc ! audio/x-raw ! fakesink")[1], "audio/x-raw ! fakesink")
        self.assertEqual(self.place("videotestsrc ! queue ! videotestsrc")[1], "videotestsrc")

    def test_a_fix_is_offered_although_a_second_mistake_follows(self):
        output, _ = self.place("videotestsrc ! tensor_filter ! videoconvert ! fakesink")
        self.assertIn("fix: videotestsrc ! tensor_converter ! tensor_filter ! videoconvert ! fakesink", output)


if __name__ == "__main__":
    tap_runner.main()
