#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Tests of `weir check` and of the commands that are links to `weir`: the lines that scripts read."""

import os
import re
import subprocess
import unittest

import tap_runner
from weir_case import COMMAND, PLUGIN, SANITIZED, Case, weir

BAR = "=" * 60


def called(name, text="", cwd=None, **environment):
    return subprocess.run([name], executable=COMMAND, input=text, text=True, timeout=60, capture_output=True, cwd=cwd,
                          env={**os.environ, "WEIR_NNSTREAMER_ENABLE": "yes", **environment})


@unittest.skipIf(SANITIZED, "the engines' libraries leak when they are opened")
class Check(Case):
    def test_the_lines_are_those_that_scripts_know(self):
        path = self.folder / "nns.ini"
        path.write_text(f"[common]\nenable_envvar=true\nenable_symlink=no\n[filter]\nfilters={self.folder}\n")
        output = self.good(called("nnstreamer-check", NNSTREAMER_CONF=str(path), NNSTREAMER_FILTERS="/some/where"))
        head, filters = output.split("NNStreamer registered sub-plugins:\n")
        version, rest = head.split("\n           loaded : TRUE\n")
        self.assertRegex(version, r"^NNStreamer version: \d+\.\d+\.\d+$")
        build_path = re.search(r"build-config: (.*)\n", rest).group(1)
        self.assertTrue(build_path.endswith("/nnstreamer.ini"), build_path)
        self.assertEqual(rest, f"""\
           path   : {PLUGIN}

NNStreamer configuration:
{BAR}
Configuration Loaded: TRUE
Configuration file path: {path}
    Candidates: envvar(NNSTREAMER_CONF): {path}
                build-config: {build_path}
                hard-coded: /etc/nnstreamer.ini
[Common]
  Enable envvar: TRUE
  Enable sym-linked subplugins: FALSE
[Filter]
  Filter paths from .ini: {self.folder}
             from envvar: /some/where
         from hard-coded: /usr/lib/nnstreamer/filters

{BAR}

""".replace("/usr/lib/nnstreamer/filters\n", re.search("from hard-coded: (.*\n)", rest).group(1)))
        self.assertIn("/usr/lib/nnstreamer/filters", rest)
        self.assertEqual(filters.splitlines()[0], BAR)
        sections = re.findall(r"^\[(\w+)\]$", filters, re.MULTILINE)
        self.assertEqual(sections, ["Filter", "Decoder", "Conterver", "Trainer"])
        self.assertRegex(filters, r"\n  custom-easy\n    - No custom property found\n")
        self.assertRegex(filters, r"\n  direct_video\n    - option1: ")
        for line in filters.splitlines()[1:]:
            self.assertRegex(line, r"^(\[\w+\]|  [\w-]+|    - No custom property found|    - [\w.*:-]+: .+)$")
        self.assertEqual(self.good(weir("check", NNSTREAMER_CONF=str(path), NNSTREAMER_FILTERS="/some/where",
                                        WEIR_NNSTREAMER_ENABLE="yes")), output)

    def test_without_the_plugin_it_fails(self):
        done = called("nnstreamer-check", GST_PLUGIN_PATH=str(self.folder), GST_PLUGIN_SYSTEM_PATH=str(self.folder),
                      GST_REGISTRY=str(self.folder / "registry"))
        self.refused(done, 1, "GStreamer does not find the plug-in", "fix: weir doctor")
        self.assertEqual(done.stdout, "")


class Generator(Case):
    def generated(self, answers, base):
        output = self.good(called("nnstreamerCodeGenCustomFilter", answers, cwd=self.folder))
        for question in ("Name of the filter, as in C: ", "Name of the file, after nnstreamer_customfilter_",
                         "Are the sizes of its tensors fixed? [yes]: ", "Does invoke allocate the outputs? [no]: "):
            self.assertIn(question, output)
        file = self.folder / f"nnstreamer_customfilter_{base}"
        self.assertTrue(output.endswith(f"{file.name}.c\n{file.name}.mk\n\nmake -f {file.name}.mk\n"), output)
        return file.with_suffix(".c").read_text(), file.with_suffix(".mk").read_text()

    def test_it_prompts_and_writes_the_callbacks_that_fit(self):
        both = {"initfunc", "exitfunc"}
        for name, answers, callbacks in (
                ("one", "\n\n\n", {"getInputDim", "getOutputDim", "invoke"}),
                ("two", "second\nno\n\n", {"setInputDim", "invoke"}),
                ("three", "\nYES\ny\n", {"getInputDim", "getOutputDim", "allocate_invoke", "destroy_notify"}),
                ("four", "\nn\nyes\n", {"setInputDim", "allocate_invoke", "destroy_notify"})):
            with self.subTest(name):
                base = "second" if name == "two" else name
                source, make = self.generated(f"{name}\n{answers}", base)
                self.assertEqual(set(re.findall(r"^  \.(\w+) = ", source, re.MULTILINE)), both | callbacks)
                self.assertIn(f"NNStreamer_custom_class *NNStreamer_custom = &{name}_callbacks;\n", source)
                self.assertIn(f"static void *{name}_init(", source)
                self.assertNotIn("NAME", source)
                self.assertIn(f"nnstreamer_customfilter_{base}.so: nnstreamer_customfilter_{base}.c\n\t$(CC)", make)

    def test_the_subcommand_writes_the_same(self):
        source, make = self.generated("bright\n\nno\nyes\n", "bright")
        self.good(subprocess.run([COMMAND, "new", "nnstreamer-filter", "--any-size", "--allocate", "--base", "b2", "bright"],
                                 cwd=self.folder, text=True, timeout=60, capture_output=True))
        other = self.folder / "nnstreamer_customfilter_b2.c"
        self.assertEqual(other.read_text().replace("customfilter_b2", "customfilter_bright"), source)
        self.assertEqual(other.with_suffix(".mk").read_text().replace("b2", "bright"), make)

    def test_answers_that_cannot_be_are_refused(self):
        for answers, words in (("1st\n\n\n\n", "this cannot be the name of a filter in C\n  offered: \"1st\""),
                               ("\n\n\n\n", "this cannot be the name of a filter in C"),
                               ("a-b\n\n\n\n", "letters, digits and _, not a digit first"),
                               ("good\n../x\n\n\n", "this cannot be part of a file name\n  offered: \"../x\""),
                               ("good\n\nperhaps\n\n", "the answer is neither yes nor no\n  offered: perhaps\n  needed: yes or no"),
                               ("good\n\nyes\n", "the input ended before every question was answered")):
            with self.subTest(answers):
                self.refused(called("nnstreamerCodeGenCustomFilter", answers, cwd=self.folder), 1, words)
                self.assertEqual(list(self.folder.iterdir()), [])

    def test_nothing_is_written_over(self):
        there = self.folder / "nnstreamer_customfilter_good.mk"
        there.write_text("mine")
        self.refused(called("nnstreamerCodeGenCustomFilter", "good\n\n\n\n", cwd=self.folder), 1, "it exists already")
        self.assertEqual([(f.name, f.read_text()) for f in self.folder.iterdir()], [(there.name, "mine")])


if __name__ == "__main__":
    tap_runner.main()
