#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Tests of `weir pbtxt` and its NNStreamer name: exact output, without GStreamer elements."""

import os
import subprocess
import unittest

import tap_runner
from weir_case import COMMAND, Case, weir

CASCADE = ("videotestsrc ! videoconvert ! video/x-raw, format=RGB, width=8 ! tee name=t "
           "t. ! queue ! tensor_converter ! mux.sink_0 t. ! queue ! tensor_converter ! mux.sink_1 "
           "tensor_mux name=mux ! tensor_sink")
CASCADE_TEXT = """\
input_stream: "videotestsrc"
output_stream: "tensor_sink"

node: {
    calculator: "videoconvertCalculator"
    input_stream: "videotestsrc"
    output_stream: "videoconvert_0_0"
}

node: {
    calculator: "teeCalculator"
    input_stream: "videoconvert_0_0"
    output_stream: "tee_0_0"
    output_stream: "tee_0_1"
}

node: {
    calculator: "queueCalculator"
    input_stream: "tee_0_0"
    output_stream: "queue_0_0"
}

node: {
    calculator: "tensor_converterCalculator"
    input_stream: "queue_0_0"
    output_stream: "tensor_converter_0_0"
}

node: {
    calculator: "queueCalculator"
    input_stream: "tee_0_1"
    output_stream: "queue_1_0"
}

node: {
    calculator: "tensor_converterCalculator"
    input_stream: "queue_1_0"
    output_stream: "tensor_converter_1_0"
}

node: {
    calculator: "tensor_muxCalculator"
    input_stream: "tensor_converter_0_0"
    input_stream: "tensor_converter_1_0"
    output_stream: "tensor_sink"
}
""".replace("    ", "\t")


def parser(text, *words):
    """Runs nnstreamer-parser: the command under another name, with the pipeline on standard input."""
    return subprocess.run(["nnstreamer-parser", *words], executable=COMMAND, input=text, text=True, timeout=60,
                          capture_output=True, env={**os.environ, "GST_PLUGIN_PATH": "", "GST_REGISTRY": "/nowhere"})


class Pbtxt(Case):
    def gives(self, text, wanted):
        self.assertEqual(self.good(parser(text)), wanted)

    def test_branches_and_names_that_come_later(self):
        self.gives(CASCADE, CASCADE_TEXT)

    def test_the_command_line_is_read_too(self):
        self.assertEqual(self.good(weir("pbtxt", *CASCADE.split())), CASCADE_TEXT)
        self.assertEqual(self.good(weir("pbtxt", CASCADE)), CASCADE_TEXT)

    def test_the_second_of_a_type_has_its_number(self):
        self.gives("nosuchsrc ! nosuchsink nosuchsrc ! nosuchsink nosuchsrc ! nosuchsink",
                   'input_stream: "nosuchsrc"\ninput_stream: "nosuchsrc_2"\ninput_stream: "nosuchsrc_3"\n'
                   'output_stream: "nosuchsink"\noutput_stream: "nosuchsink_2"\noutput_stream: "nosuchsink_3"\n')

    def test_properties_are_no_elements(self):
        self.gives("""filesrc location="/a ! b/c d.raw" blocksize = 4 ! 'application/octet-stream' ! identity silent=false
                      ! (fakesink)""".replace("(fakesink)", "( fakesink sync=true )"),
                   'input_stream: "filesrc"\noutput_stream: "fakesink"\n\nnode: {\n\tcalculator: "identityCalculator"\n'
                   '\tinput_stream: "filesrc"\n\toutput_stream: "fakesink"\n}\n')

    def test_names_that_gstreamer_gives_are_known(self):
        self.gives("a ! b b0. ! c", 'input_stream: "a"\noutput_stream: "c"\n\nnode: {\n\tcalculator: "bCalculator"\n'
                                    '\tinput_stream: "a"\n\toutput_stream: "c"\n}\n')

    def test_a_pipeline_may_be_long(self):
        text = "src ! " + " ! ".join(["identity"] * 500) + " ! sink"
        output = self.good(parser(text))
        self.assertEqual(output.count("node: {"), 500)
        self.assertIn('\tinput_stream: "identity_498_0"\n\toutput_stream: "sink"\n}\n', output)

    def test_a_text_of_nearly_a_mebibyte_is_read_at_once(self):
        count = 30000
        text = " ".join(f"e name=n{i}" for i in range(count)) + " " + " ".join(f"n{i}. ! s" for i in range(count))
        self.assertGreater(len(text), 700000)
        output = self.good(parser(text)).splitlines()
        self.assertEqual((output[count - 1], output[-1]), (f'input_stream: "e_{count}"', f'output_stream: "s_{count}"'))

    def test_verbose_lists_elements_on_stderr(self):
        done = parser("a name=x ! b", "-v")
        self.assertEqual(self.good(done), 'input_stream: "a"\noutput_stream: "b"\n')
        self.assertEqual(done.stderr, "element x (a): 0 inputs, 1 outputs\nelement b0 (b): 1 inputs, 0 outputs\n"
                                      "link x ! b0\n")

    def test_the_other_way_is_not_there(self):
        self.assertIn("Converting pbtxt to a pipeline is not implemented", self.good(parser("", "--from-pbtxt")))

    def test_texts_that_cannot_be_read_say_where(self):
        for text, words in {"": "it is empty", "! a": "a link has no upstream element", "a ! ! b": "at character 5",
                            "a !": "a link has no downstream element", "a ! video/x-raw": "a link has no downstream element",
                            "a ! b location='x": "a quote is not closed", "x=1 a": "a property has no element before it",
                            "a ! b ! x=1": "at character 9", "a ! /b": "this is not an element",
                            "tee name=tea ! a te. ! b": "no element has the name te"}.items():
            with self.subTest(text):
                self.refused(parser(text), 1, words)
        self.refused(parser("tee name=tea ! a teb. ! b"), 1, "    tee name=tea ! a teb. ! b\n                     ^\n",
                     "fix: tea. in place of teb.")
        self.refused(parser("a" * ((1 << 20) + 1)), 1, "WEIR-2006", "at most 1 MiB")
        self.refused(parser("a", "--nosuch"), 2, "--nosuch")


if __name__ == "__main__":
    tap_runner.main()
