#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Tests `weir new filter`: its output builds with the installed tools, runs, and its test can fail."""

import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest

import tap_runner
from built_modules import has_engine

COMMAND = pathlib.Path(os.environ["WEIR_COMMAND"])
FILES = {"Makefile", "README.md", "meson.build", "test.sh"}
SOURCES = {"c": "filter.c", "c++": "filter.cpp", "python": "filter.py", "lua": "filter.lua"}
ENGINES = {"python": "python3", "lua": "lua"}


def run(*command, **more):
    return subprocess.run([str(c) for c in command], capture_output=True, text=True, timeout=200, check=False, **more)


class NewFilter(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.root = pathlib.Path(tempfile.mkdtemp())
        cls.addClassCleanup(shutil.rmtree, cls.root)
        installed = run("meson", "install", "-C", os.environ["WEIR_BUILD"], "--destdir", cls.root, "--tags", "devel", "--no-rebuild")
        if installed.returncode:
            raise RuntimeError(installed.stdout + installed.stderr)
        config = next(cls.root.rglob("weir-module.pc")).parent
        cls.env = {**os.environ, "PKG_CONFIG_LIBDIR": str(config), "PKG_CONFIG_SYSROOT_DIR": str(cls.root), "GST_TRACERS": "",
                   "GST_DEBUG": "", "CFLAGS": "-O2 -Wall -Wextra -Wpedantic -Werror", "CXXFLAGS": "-O2 -Wall -Wextra -Wpedantic -Werror"}

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="weir new "))
        self.addCleanup(shutil.rmtree, self.folder)

    def write(self, *words):
        return run(COMMAND, "new", "filter", *words, cwd=self.folder)

    def good(self, done):
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done.stdout

    def refused(self, done, code, *output):
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        for words in output:
            self.assertIn(words, done.stdout + done.stderr)
        self.assertEqual(list(self.folder.iterdir()), self.there)

    def test_each_language_builds_runs_and_has_a_test(self):
        for language, source in SOURCES.items():
            with self.subTest(language):
                name = f"of-{language.replace('+', 'p')}_2"
                output = self.good(self.write("--language", language, name))
                made = self.folder / name
                self.assertEqual({path.name for path in made.iterdir()}, FILES | {source})
                self.assertIn(f"cd {name} && make test", output)
                for path in made.iterdir():
                    self.assertNotIn("my-filter", path.read_text())
                    self.assertNotIn("MyFilter", path.read_text())
                if language in ENGINES and not has_engine(ENGINES[language]):
                    self.skipTest(f"the engine {ENGINES[language]} is not built")
                self.assertIn(f"{name} works", self.good(run("make", "-C", made, "test", env=self.env)))
                self.good(run("meson", "setup", made / "build", made, env=self.env))
                self.good(run("meson", "test", "-C", made / "build", env=self.env))

    def test_engines_decoders_and_converters_build_run_and_have_a_test(self):
        for kind, broken in (("engine", ("x[i] + added_", "x[i]")), ("decoder", ("sum / bytes.size()", "sum")),
                             ("converter", ("numbers.push_back(number)", "numbers.push_back(0)"))):
            with self.subTest(kind):
                name = f"a-{kind}_2"
                output = self.good(run(COMMAND, "new", kind, name, cwd=self.folder))
                made = self.folder / name
                self.assertEqual({path.name for path in made.iterdir()}, FILES | {f"{kind}.cpp"})
                self.assertIn(f"cd {name} && make test", output)
                for path in made.iterdir():
                    self.assertNotIn(f"my-{kind}", path.read_text())
                    self.assertNotIn(f"My{kind.capitalize()}", path.read_text())
                self.assertIn(f"{name} works", self.good(run("make", "-C", made, "test", env=self.env)))
                source = made / f"{kind}.cpp"
                self.assertIn(broken[0], source.read_text())
                source.write_text(source.read_text().replace(*broken))
                self.assertNotEqual(run("make", "-C", made, "test", env=self.env).returncode, 0, "its test can fail")

    def test_a_new_engine_is_described_and_its_options_are_checked(self):
        self.good(run(COMMAND, "new", "engine", "adder2", cwd=self.folder))
        made = self.folder / "adder2"
        self.good(run("make", "-C", made, env=self.env))
        env = {**self.env, "WEIR_MODULE_PATH": str(made)}
        self.assertRegex(self.good(run(COMMAND, "inspect", "--engine", "adder2", env=env)), r"times +integer +1 +how often N is added")
        (made / "three.model").write_text("3")
        done = run(COMMAND, "run", "fakesrc num-buffers=1 ! tensor_filter framework=adder2 model=three.model custom=tims:2 ! fakesink", env=env, cwd=made)
        self.assertEqual(done.returncode, 1)
        for words in ("WEIR-1004: the engine adder2 has no such option", "did you mean times?", "fix: custom=times:2"):
            self.assertIn(words, done.stderr)

    def test_the_test_fails_where_the_filter_does_something_else(self):
        self.good(self.write("-l", "c", "other"))
        source = self.folder / "other" / "filter.c"
        source.write_text(source.read_text().replace("255 - x[i]", "254 - x[i]"))
        done = run("make", "-C", source.parent, "test", env=self.env)
        self.assertNotEqual(done.returncode, 0)
        for words in ("With isolate=none, the filter did not return the expected bytes:\n", "  output    \\376\\375\\177\\377\n",
                      "  expected  \\377\\376\\200\\000\n", 'change "expected" in test.sh.\n'):
            self.assertIn(words, done.stderr)

    def inspected(self, name, modules):
        return self.good(run(COMMAND, "inspect", "--engine", name, env={**self.env, "WEIR_MODULE_PATH": modules}))

    def test_it_is_installed_in_a_prefix_of_its_own_and_found_by_its_name(self):
        self.good(self.write("-l", "c++", "by-name"))
        made, prefix = self.folder / "by-name", self.folder / "prefix"
        self.assertIn("class ByName {", (made / "filter.cpp").read_text())
        output = self.good(run("make", "-C", made, "install", f"PREFIX={prefix}", env=self.env))
        modules = re.search('^export WEIR_MODULE_PATH="(.*)"$', output, re.MULTILINE)[1]
        self.assertEqual(pathlib.Path(modules), prefix / "lib" / "weir" / "modules")
        self.assertIn("Engine  by-name 1", self.inspected("by-name", modules))

    def test_without_a_prefix_it_is_installed_where_weir_looks(self):
        self.good(self.write("-l", "c", "beside"))
        output = self.good(run("make", "-C", self.folder / "beside", "install", f"DESTDIR={self.folder / 'root'}", env=self.env))
        file = next((self.folder / "root").rglob("libweir-engine-beside.so"))
        self.assertEqual(file.parent.name, "modules")
        self.assertNotIn("WEIR_MODULE_PATH", output)
        self.assertIn("Engine  beside 1", self.inspected("beside", str(file.parent)))

    def test_meson_installs_it_too(self):
        self.good(self.write("-l", "c++", "by-meson"))
        made, prefix = self.folder / "by-meson", self.folder / "prefix"
        self.good(run("meson", "setup", made / "build", made, f"--prefix={prefix}", env=self.env))
        self.good(run("meson", "install", "-C", made / "build", env=self.env))
        file = next(prefix.rglob("libweir-engine-by-meson.so"))
        self.assertIn("Engine  by-meson 1", self.inspected("by-meson", str(file.parent)))

    def test_what_cannot_be_is_refused_and_nothing_is_written(self):
        (self.folder / "there").mkdir()
        self.there = [self.folder / "there"]
        self.refused(self.write("-l", "c", "there"), 1, "WEIR-4010: a file or folder with this name already exists", "there-2")
        self.refused(self.write("-l", "cpp", "x"), 1, "WEIR-1004: there is no template for this language",
                     "one of: c, c++, lua, python", "did you mean c++?")
        self.refused(self.write("-l", "rust", "x"), 1, "--language rust")
        for name in ("", "Big", "1st", "-x1", "a b", "../up", "a/b", "x" * 65, "auto", "any", "m\u00e4h"):
            with self.subTest(name):
                self.refused(self.write("-l", "c", "--", name), 1, "WEIR-1004: this cannot be the name of a new filter",
                             "needed: a lower-case letter, then lower-case letters", "fix: weir new filter --language c brightness\n")
        for kind in ("engine", "decoder", "converter"):
            self.refused(run(COMMAND, "new", kind, "there", cwd=self.folder), 1, "WEIR-4010", f"fix: weir new {kind} there-2")
            self.refused(run(COMMAND, "new", kind, "Big", cwd=self.folder), 1, f"this cannot be the name of a new {kind}",
                         f"fix: weir new {kind} brightness")
            self.refused(run(COMMAND, "new", kind, cwd=self.folder), 2, "NAME")
        self.refused(self.write("x"), 2, "--language")
        self.refused(self.write("-l", "c"), 2, "NAME")
        self.refused(run(COMMAND, "new", cwd=self.folder), 2)

    def test_a_folder_that_cannot_be_written_to_is_reported(self):
        if os.geteuid() == 0:
            self.skipTest("nothing is closed to root")
        self.folder.chmod(0o500)
        self.there = []
        self.refused(self.write("-l", "c", "x"), 1, "WEIR-4010: a file of the new filter cannot be written")


if __name__ == "__main__":
    tap_runner.main()
