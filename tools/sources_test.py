#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Tests of tools/lint and tools/checks, which look at the sources, in folders of their own. The last line is
`N passed, N failed`.
"""

import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

from tools_test import TOOLS, main, write_program


class Lint(unittest.TestCase):
    """With a stand-in for clang-tidy, which finds `bad` in every file it reads."""

    SOURCES = {"src/one.cpp": '#include "one.hpp"\n', "src/one.hpp": '#include "deep.hpp"\n', "src/two.cpp": "bad\n", "src/deep.hpp": "bad\n",
               "src/one_test.cpp": "bad\n", "src/tests/harness.hpp": "bad\n", "benchmarks/cost.cpp": "bad\n", "src/off.cpp": ""}
    CLANG_TIDY = """#!/bin/bash
file=${@: -1} folder=$(dirname "${@: -1}")
echo "$(basename "$file") $*" >> "$FAKE/calls"
for each in "$file" $([[ $file != */one.cpp ]] || echo "$folder/one.hpp $folder/deep.hpp"); do
  ! grep -q bad "$each" || echo "../src/$(basename "$each"):1:1: warning: bad [bugprone-bad]"
done
"""

    def setUp(self):
        self.root = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory(prefix="weir-lint-")))
        for name, text in self.SOURCES.items():
            (self.root / name).parent.mkdir(exist_ok=True)
            (self.root / name).write_text(text)
        for name in ("lint", "sources"):
            (self.root / "tools").mkdir(exist_ok=True)
            shutil.copy(TOOLS / name, self.root / "tools")
        build = self.root / "build"
        build.mkdir()
        # one.cpp and two.cpp are compiled as one unit, as Meson writes it.
        (build / "x-unity0.cpp").write_text("".join(f"#include<{build}/../src/{name}.cpp>\n" for name in ("one", "two")))
        entries = [{"directory": str(build), "file": name, "output": "x.o", "command": "ccache c++ -I../src -fpch-preprocess -include "
                    f"std.hpp -O2 -fvect-cost-model=dynamic -g1 -o x.o -c {name}"} for name in ("x-unity0.cpp", "../src/one_test.cpp")]
        (build / "compile_commands.json").write_text(json.dumps(entries))
        programs = self.root / "programs"
        programs.mkdir()
        write_program(programs / "clang-tidy", self.CLANG_TIDY)
        self.environment = dict(os.environ, PATH=f"{programs}:/usr/bin:/bin", FAKE=str(self.root))
        (self.root / ".gitignore").write_text("build\nprograms\ncalls\n")
        self.git("init", "-q")

    def git(self, *arguments, where=None):
        subprocess.run(["git", "-c", "user.name=a", "-c", "user.email=a@b", *arguments], cwd=where or self.root, check=True,
                       capture_output=True)

    def commit(self, *names):
        self.git("add", *names)
        self.git("commit", "-q", "-m", "more")

    def lint(self, *options):
        done = subprocess.run([self.root / "tools" / "lint", *options, "build"], cwd=self.root, env=self.environment, text=True,
                              capture_output=True, check=False)
        return done.returncode, done.stdout.splitlines() + done.stderr.splitlines()

    def test_checks_the_product_without_its_tests(self):
        status, lines = self.lint()
        self.assertEqual((status, lines[-1]), (1, "2 passed, 2 failed"), lines)
        self.assertEqual([line for line in lines if line.startswith("FAILED")], ["FAILED src/deep.hpp", "FAILED src/two.cpp"])
        self.assertIn("   src/two.cpp:1:1: bad [bugprone-bad]", lines)
        self.assertIn("not compiled in build: src/off.cpp", lines)

    def test_a_header_is_checked_once_with_a_source_that_includes_it(self):
        self.lint()
        calls = (self.root / "calls").read_text()
        self.assertEqual(sorted(call.split()[0] for call in calls.splitlines()), ["one.cpp", "two.cpp"])
        self.assertIn("-clang-analyzer-*", calls)

    def test_clang_gets_no_argument_that_only_gcc_knows(self):
        self.lint()
        for entry in json.loads((self.root / "build/lint/compile_commands.json").read_text()):
            options = [argument for argument in entry["arguments"] if re.match("-[fgO]", argument)]
            self.assertEqual(options, ["-O2"], entry)
            self.assertNotIn("-include", entry["arguments"])

    def test_changed_files_are_those_of_the_last_commits_and_of_no_commit(self):
        self.commit(".")
        for name in ("two.cpp", "one.hpp", "one_test.cpp"):
            (self.root / "src" / name).write_text("// changed\n")
            self.commit("src")
        self.assertEqual(self.lint("--changed", "2"), (0, ["1 passed, 0 failed"]))
        self.assertEqual(self.lint("--changed", "3"), (0, ["2 passed, 0 failed"]))
        (self.root / "src" / "one.cpp").write_text('#include "one.hpp"\nbad\n')
        self.assertEqual(self.lint("--changed", "2")[1][-1], "1 passed, 1 failed")

    def test_of_many_changed_files_the_newest_are_checked(self):
        self.commit(".")
        (self.root / "src" / "one.cpp").write_text('#include "one.hpp"\n// changed\n')
        self.commit("src")
        self.assertEqual(self.lint("--changed", "9", "--most", "1", "--list")[1],
                         ["not compiled in build: src/off.cpp", "3 of 4 files are left out: --most 1", "src/one.cpp"])

    def test_a_shallow_clone_is_checked_as_far_as_git_knows_it(self):
        self.commit(".")
        for _ in range(2):
            with (self.root / "src" / "one.cpp").open("a") as file:
                file.write("// changed\n")
            self.commit("src")
        clone = self.root.parent / (self.root.name + "-clone")
        self.addCleanup(shutil.rmtree, clone, ignore_errors=True)
        self.git("clone", "-q", "--depth", "2", f"file://{self.root}", str(clone))
        shutil.copytree(self.root / "build", clone / "build")
        for name in ("compile_commands.json", "x-unity0.cpp"):
            copy = clone / "build" / name
            copy.write_text(copy.read_text().replace(str(self.root), str(clone)))
        self.root = clone
        self.assertEqual(self.lint("--changed", "1"), (0, ["1 passed, 0 failed"]))
        self.assertEqual(self.lint("--changed", "30"), (0, ["1 passed, 0 failed"]), "not every file for the oldest commit")

    def test_without_a_repository_nothing_has_changed(self):
        shutil.rmtree(self.root / ".git")
        self.assertEqual(self.lint("--changed", "30"), (0, ["0 passed, 0 failed"]))

    def test_a_source_that_clang_tidy_cannot_read_fails(self):
        write_program(self.root / "programs" / "clang-tidy", "#!/bin/bash\necho 'Error while processing' >&2\nexit 1\n")
        status, lines = self.lint()
        self.assertEqual(status, 1)
        self.assertIn("   src/two.cpp: Error while processing", lines)


def run_check(check, files):
    """The exit status and what a check of tools/checks finds in a tree of these files, {path: text}."""
    with tempfile.TemporaryDirectory(prefix="weir checks ") as folder:
        root = pathlib.Path(folder)
        for path, content in files.items():
            (root / path).parent.mkdir(parents=True, exist_ok=True)
            (root / path).write_text(content)
        (root / "tools").mkdir(exist_ok=True)
        for tool in ("checks", "sources"):
            shutil.copy(TOOLS / tool, root / "tools")
        result = subprocess.run([root / "tools/checks", check], text=True, capture_output=True, check=False)
    if result.stderr:
        raise AssertionError(result.stderr)
    return result.returncode, [line.strip() for line in result.stdout.splitlines() if line.startswith("   ")]


class Layers(unittest.TestCase):
    """tools/checks layers, small_headers and length."""

    ROOMS = {"src/core/meson.build": "core_rooms = {\n  'base': ['text'],\n  'results': ['draw'],\n}\n"}

    def test_an_include_of_a_lower_layer_is_no_finding(self):
        files = {"src/core/draw/one.hpp": '#include "core/text/text.hpp"\n', "src/edge/one.cpp": '#include "transport/x.hpp"\n',
                 "apps/weir/one.cpp": '#include "library/x.hpp"\n#include <nlohmann/json.hpp>\n'}
        self.assertEqual(run_check("layers", {**self.ROOMS, **files}), (0, []))

    def test_an_include_that_no_list_allows_is_found(self):
        for path, name in (("src/core/text/one.hpp", "core/draw/x.hpp"), ("src/core/text/one.hpp", "net/server/x.hpp"), ("src/net/client/one.hpp", "net/server/x.hpp"),
                           ("src/gstcpp/one.cpp", "transport/x.hpp"), ("apps/weir/one.cpp", "elements/x.hpp"),
                           ("src/modules/one.cpp", "core/text/x.hpp"), ("include/weir/one.hpp", "machine/x.hpp"),
                           ("src/transport/one.cpp", "nlohmann/json.hpp")):
            with self.subTest(f"{path}: {name}"):
                status, findings = run_check("layers", {**self.ROOMS, path: f'#include "{name}"\n'})
                self.assertEqual((status, len(findings)), (1, 1), findings)
                self.assertIn(f"{path}:1: ", findings[0])

    def test_a_room_that_is_compiled_nowhere_is_found(self):
        self.assertEqual(run_check("layers", {**self.ROOMS, "src/core/attic/one.cpp": "\n"}),
                         (1, ["src/core/attic/one.cpp: src/core/meson.build has no such room"]))

    def test_a_source_of_800_lines_passes_and_one_of_801_does_not(self):
        self.assertEqual(run_check("length", {"src/one.cpp": "\n" * 800})[0], 0)
        self.assertEqual(run_check("length", {"src/one.cpp": "\n" * 801})[0], 1)

    def test_one_more_small_header_with_one_user_is_found(self):
        def files(count):
            return {f"src/h{i}.hpp": "\n" for i in range(count)} | {f"src/u{i}.cpp": f'#include "h{i}.hpp"\n' for i in range(count)}

        left = int(re.search(r"SMALL_HEADERS_LEFT = 30, (\d+)", (TOOLS / "checks").read_text()).group(1))
        self.assertEqual(run_check("small_headers", files(left))[0], 0)
        self.assertEqual(run_check("small_headers", files(left + 1))[0], 1)
        shared = files(left + 1) | {"src/other.cpp": '#include "h0.hpp"\n'}
        self.assertEqual(run_check("small_headers", shared)[0], 0)


class Vocabulary(unittest.TestCase):
    """tools/checks vocabulary."""

    def check(self, text, name="src/one.cpp"):
        return run_check("vocabulary", {name: text})

    def test_terms_of_the_field_are_no_finding(self):
        for text in ("// Sends the event again. Nearest neighbour.\n", "class SourceMap source_map;\n", "int kNobody = 65534;\n",
                     "int retell, hearsay, crews_;\n", '// A file that "untold" names.\n', "auto x = not_in_vainness;\n"):
            with self.subTest(text):
                self.assertEqual(self.check(text), (0, []))

    def test_home_made_names_are_found_in_each_spelling(self):
        for name in ("PeerWish", "peer_wish", "kPeerWishes", "told", "tell_peer", "isToldOnce", "picture_map", "WayBack", "thread_crew",
                     "opened_model", "heard_", "lies_so", "gives_way", "nobody"):
            with self.subTest(name):
                status, findings = self.check(f"\nint {name} = 1;\n")
                self.assertEqual((status, len(findings)), (1, 1), findings)
                self.assertTrue(findings[0].startswith(f"src/one.cpp:2: '{name}': use "), findings)

    def test_home_made_words_are_found_in_comments_and_texts(self):
        for text, found in (("// It is sent anew.", "anew"), ("/* Sent\n in vain. */", "in vain"), ('f("nobody waits");', "nobody"),
                            ('f("a \\"quoted\\" element behind");', "element behind"), ("// the way back", "way back"),
                            ('f(R"(the script says why)");', "says why")):
            with self.subTest(text):
                status, findings = self.check(text + "\n")
                self.assertEqual((status, len(findings)), (1, 1), findings)
                self.assertIn(f"'{found}': use ", findings[0])

    def test_names_in_texts_and_words_in_names_are_no_finding(self):
        self.assertEqual(self.check('f("told", "tell");  // told() of a library\nint behind_it = a.by_itself();\n'), (0, []))

    def test_python_scripts_and_builds_are_checked_too(self):
        for name, text in (("a.py", "# anew\n"), ("tools/run", "#!/bin/bash\n# anew\n"), ("meson.build", "# anew\n"),
                           ("a.py", 'def f():\n  """Waits\n  in vain."""\n'), ("a.py", "told = 1  # 'x'\n")):
            with self.subTest(name):
                self.assertEqual(self.check(text, name)[0], 1)
        self.assertEqual(self.check("anew\n", "README"), (0, []))

    def test_a_finding_names_its_line(self):
        self.assertEqual(self.check('"""One\ntwo\n"""\n\nx = "a"  # b\ntold = 1\n', "a.py"), (1, ["a.py:6: 'told': use report, post, log"]))


class License(unittest.TestCase):
    """tools/checks license."""

    def test_a_source_of_each_language_names_its_license(self):
        line = "SPDX-License-Identifier: " + "LGPL-2.1-or-later"
        for name, comment in (("a.cpp", "//"), ("a.hh", "//"), ("a.lua", "--"), ("a.proto", "//"), ("a.fbs", "//"), ("a.py", "#")):
            with self.subTest(name):
                self.assertEqual(run_check("license", {name: f"{comment} {line}\n"}), (0, []))
                self.assertEqual(run_check("license", {name: f"{comment} A file.\n"}), (1, [f"{name}: no line '{line}'"]))


class Compatibility(unittest.TestCase):
    """tools/checks compatibility, over a tree with one page."""

    PAGE = "docs/" + "compatibility/muxing.md"  # written apart: it is no page of this checkout
    TEXT = ("# 6. Muxing\n\n## 6.1 Time `sync-mode`\n\nSee [6.2](#62-pads).\n\n## 6.2 Pads\n\n"
            "```text\n## 6.3 no heading\n```\n")

    def check(self, name, text):
        """The exit status and what is found where the tree has a file of this name and text."""
        return run_check("compatibility", {self.PAGE: self.TEXT, name: text})

    def test_pages_and_headings_that_exist_are_no_finding(self):
        for text in (f"// {self.PAGE} 6.1: pads.\n", f"// Rules ({self.PAGE} 6.1, 6.2 and 6.1).\n", f"// {self.PAGE}\n",
                     f"// By {self.PAGE}\n// 6.2.\n", "int x = 6.9;\n"):
            with self.subTest(text):
                self.assertEqual(self.check("src/mux.cpp", text), (0, []))

    def test_a_page_that_is_missing_is_reported_with_its_place(self):
        text = "\n// " + self.PAGE.replace("muxing", "mixing") + " 6.1\n"
        self.assertEqual(self.check("src/mux.cpp", text),
                         (1, ["src/mux.cpp:2: docs/compatibility has no page mixing.md"]))

    def test_a_heading_that_is_missing_is_reported_with_its_place(self):
        for text in (f"// {self.PAGE} 6.4\n", f"// {self.PAGE} 6.1, 6.4 and 6.2\n", f"// {self.PAGE} 6.1 and 6.4\n",
                     f"// {self.PAGE}\n// 6.4\n", f"# {self.PAGE}\n# 6.4\n"):
            with self.subTest(text):
                self.assertEqual(self.check("include/mux.h", text),
                                 (1, [f"include/mux.h:1: {self.PAGE} has no heading 6.4"]))

    def test_a_heading_in_a_code_block_is_none(self):
        self.assertEqual(self.check("a.py", f"# {self.PAGE} 6.3\n"), (1, [f"a.py:1: {self.PAGE} has no heading 6.3"]))

    def test_links_to_headings_that_exist_are_no_finding(self):
        for link in ("../compatibility/muxing.md#61-time-sync-mode", "../compatibility/muxing.md", "mux.md#anything"):
            with self.subTest(link):
                self.assertEqual(self.check("docs/guide/mux.md", f"[6.1]({link})\n"), (0, []))

    def test_a_link_to_a_heading_that_is_missing_is_reported_with_its_place(self):
        self.assertEqual(self.check("docs/guide/mux.md", "\n\n[6.1](../compatibility/muxing.md#61-time)\n"),
                         (1, [f"docs/guide/mux.md:3: {self.PAGE} has no heading #61-time"]))
        self.assertEqual(self.check(self.PAGE.replace("muxing", "loops"), "[6.1](muxing.md#61-time)\n"),
                         (1, [f"{self.PAGE.replace('muxing', 'loops')}:1: {self.PAGE} has no heading #61-time"]))


if __name__ == "__main__":
    sys.exit(main(sys.modules[__name__]))
