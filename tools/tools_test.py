#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Tests of tools/setup, tools/configure, tools/count-tests.py and tools/measure, in folders of their own and with stand-ins for
npm, apt and dpkg: nothing is fetched and nothing installed. The last line is `N passed, N failed`.
"""

import base64
import hashlib
import os
import pathlib
import shutil
import subprocess
import sys
import tarfile
import tempfile
import unittest

TOOLS = pathlib.Path(__file__).resolve().parent

NPM = """#!/bin/bash
echo "npm $*" >> "$FAKE/calls"
[[ ! -e $FAKE/offline ]] || { echo "npm ERR! network" >&2; exit 1; }
[[ ! -e $FAKE/interrupted ]] || { head -c 20 "$FAKE/toy.tgz" > toy-1.0.tgz; kill -KILL 0; }
cp "$FAKE/toy.tgz" toy-1.0.tgz
"""
APT_GET = """#!/bin/bash
echo "apt-get $*" >> "$FAKE/calls"
[[ ! -e $FAKE/offline ]] || { echo "E: Could not resolve" >&2; exit 100; }
for word; do case $word in install) on=yes ;; -*) ;; *) [[ -z ${on:-} ]] || echo "$word" >> "$FAKE/installed" ;; esac; done
"""
DPKG_QUERY = """#!/bin/bash
grep -qxF -e "${@: -1}" "$FAKE/installed" && echo -n "installed ${FAKE_ARCHITECTURE:-$(cat "$FAKE/architecture")} "
"""
DPKG = """#!/bin/bash
[[ $1 != --print-architecture ]] || cat "$FAKE/architecture"
[[ $1 != --compare-versions ]] || exec /usr/bin/dpkg "$@"
"""
APT_CACHE = """#!/bin/bash
[[ ${@: -1} == library-* ]] && echo "Version: 1.22.0-4+deb12u8"
"""
FAKES = {"npm": NPM, "apt-get": APT_GET, "dpkg-query": DPKG_QUERY, "dpkg": DPKG, "apt-cache": APT_CACHE}
ENGINES = """suite trixie
arch  amd64 x64
arch  arm64 arm64
system  toy  toy-dev
toy  npm  toy  1.0  {pin}
  take  package/{{node-arch}}/libtoy.so*  lib
  link  lib/libtoy.so  libtoy.so.1
"""
PACKAGES = """[build]  to build
first     # one
wanted?   # not in these sources
toy-dev?  # the same
library-old?>=1.24  # in these sources in version 1.22
[test]
second
library-new?>=1.20
[cross]
compiler-for-{deb-arch}
[engines]
authority
"""


def write_program(path, text):
    path.write_text(text)
    path.chmod(0o755)


class Setup(unittest.TestCase):
    def setUp(self):
        self.root = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory(prefix="weir setup ")))
        self.fake = self.root / "fake"
        self.tools = self.root / "checkout" / "tools"
        self.engine = self.root / "checkout" / ".engines" / "toy"
        self.fake.mkdir()
        self.tools.mkdir(parents=True)
        for name in ("setup", "setup-packages.sh", "setup-engines.sh"):
            shutil.copy(TOOLS / name, self.tools)
        for name, text in FAKES.items():
            write_program(self.fake / name, text)
        (self.fake / "installed").write_text("")
        (self.fake / "architecture").write_text("amd64\n")
        (self.tools / "packages.txt").write_text(PACKAGES)
        self.make_archive("the library")
        self.pin_archive()

    def make_archive(self, content):
        library = self.root / "libtoy.so.1"
        library.write_text(content)
        with tarfile.open(self.fake / "toy.tgz", "w:gz") as archive:
            archive.add(library, "package/x64/libtoy.so.1")
            library.write_text("the other library")
            archive.add(library, "package/arm64/libtoy.so.1")

    def pin_archive(self):
        digest = hashlib.sha512((self.fake / "toy.tgz").read_bytes()).digest()
        (self.tools / "engines.txt").write_text(ENGINES.format(pin="sha512-" + base64.b64encode(digest).decode()))

    def setup(self, *options, **variables):
        environment = {"PATH": f"{self.fake}:/usr/bin:/bin", "FAKE": str(self.fake), "CI": "true", **variables}
        if os.geteuid():  # sudo of the stand-ins: none
            write_program(self.fake / "sudo", '#!/bin/bash\nexec "$@"\n')
        result = subprocess.run([self.tools / "setup", *options], env=environment, stdin=subprocess.DEVNULL, text=True,
                                stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False,
                                start_new_session=True)  # so that a kill meant for all of it spares us
        return result.returncode, result.stdout

    def calls(self):
        calls = self.fake / "calls"
        text = calls.read_text() if calls.exists() else ""
        calls.unlink(missing_ok=True)
        return text

    def assert_engine_is_whole(self):
        self.assertEqual((self.engine / "lib" / "libtoy.so").read_text(), "the library")
        self.assertTrue((self.engine / ".stamp").exists())
        left = {p.name for p in self.engine.parent.iterdir()}
        self.assertEqual(left, {"toy", ".lock"})

    def test_installs_packages_and_engines_once(self):
        status, output = self.setup()
        self.assertEqual(status, 0, output)
        self.assertIn("install: first second library-new authority", output.replace("to install, with what they depend on", "install"))
        self.assert_engine_is_whole()
        self.assertIn("apt-get", self.calls())
        self.assertEqual(self.setup(), (0, ""))
        self.assertEqual(self.calls(), "")

    def test_check_only_looks(self):
        status, output = self.setup("--check")
        self.assertEqual(status, 1)
        for words in ("first second", "toy", "to install: tools/setup"):
            self.assertIn(words, output)
        self.assertEqual(self.calls(), "")
        self.assertFalse(self.engine.parent.exists())
        self.setup()
        self.assertEqual(self.setup("--check"), (0, "setup: nothing is missing\n"))

    def test_a_package_of_another_architecture_counts_as_missing(self):
        self.setup()
        self.assertEqual(self.setup("--check", FAKE_ARCHITECTURE="all"), (0, "setup: nothing is missing\n"))
        status, output = self.setup("--check", FAKE_ARCHITECTURE="mips")
        self.assertEqual(status, 1)
        self.assertIn("first second", output)

    def test_parts_can_be_selected(self):
        self.assertEqual(self.setup("--no-engines")[0], 0)
        self.assertFalse(self.engine.exists())
        self.assertEqual(self.setup("--no-engines", "--check")[0], 0)
        self.assertEqual(self.setup("--engine", "toy")[0], 0)
        self.assert_engine_is_whole()

    def test_no_tests_leaves_out_what_only_tests_need(self):
        status, output = self.setup("--check", "--no-tests")
        self.assertEqual(status, 1)
        self.assertIn("to install: tools/setup --no-tests", output)
        self.assertEqual(self.setup("--no-tests")[0], 0)
        self.assertEqual((self.fake / "installed").read_text(), "first\nauthority\n")
        self.assert_engine_is_whole()
        self.assertEqual(self.setup("--no-tests"), (0, ""))
        status, output = self.setup("--check")
        self.assertEqual((status, "what they depend on: second library-new\n" in output), (1, True), output)

    def test_engines_only_installs_no_compiler(self):
        self.assertEqual(self.setup("--engines-only")[0], 0)
        self.assertEqual((self.fake / "installed").read_text(), "authority\n")

    def test_an_engine_that_a_package_has_is_fetched_only_by_its_name(self):
        write_program(self.fake / "apt-cache", '#!/bin/bash\n[[ ${@: -1} == toy-dev ]]\n')
        status, output = self.setup()
        self.assertEqual(status, 0, output)
        self.assertIn("toy-dev", (self.fake / "installed").read_text().splitlines())
        self.assertNotIn("npm", self.calls())
        self.assertEqual(self.setup(), (0, ""))
        self.assertEqual(self.setup("--engines-only"), (0, ""))
        self.assertFalse(self.engine.exists())
        self.assertEqual(self.setup("--engine", "toy")[0], 0)
        self.assert_engine_is_whole()

    def test_an_engine_whose_package_is_not_to_be_installed_is_fetched(self):
        write_program(self.fake / "apt-cache", '#!/bin/bash\n[[ ${@: -1} == toy-dev ]]\n')
        self.assertEqual(self.setup("--engines-only")[0], 0)
        self.assertEqual((self.fake / "installed").read_text(), "authority\n")
        self.assert_engine_is_whole()

    def test_engines_dir_can_be_elsewhere(self):
        elsewhere = self.root / "else where"
        self.assertEqual(self.setup("--engines-only", WEIR_ENGINES_DIR=str(elsewhere))[0], 0)
        self.assertTrue((elsewhere / "toy" / "lib" / "libtoy.so.1").exists())
        self.assertFalse(self.engine.parent.exists())

    def test_an_archive_that_differs_from_its_pin_is_not_unpacked(self):
        self.make_archive("another library")
        status, output = self.setup()
        self.assertEqual(status, 1)
        self.assertIn("toy 1.0 is not what tools/engines.txt pins", output)
        self.assertFalse(self.engine.exists())
        self.make_archive("the library")
        self.pin_archive()
        self.assertEqual(self.setup()[0], 0)
        self.assert_engine_is_whole()

    def test_works_again_after_an_interruption(self):
        (self.fake / "interrupted").touch()
        self.assertEqual(self.setup()[0], -9)
        self.assertFalse(self.engine.exists())
        (self.fake / "interrupted").unlink()
        status, output = self.setup()
        self.assertEqual(status, 0, output)
        self.assert_engine_is_whole()

    def test_a_new_pin_brings_the_engine_again(self):
        self.setup()
        self.make_archive("a newer library")
        self.pin_archive()
        self.assertEqual(self.setup()[0], 0)
        self.assertEqual((self.engine / "lib" / "libtoy.so.1").read_text(), "a newer library")

    def test_no_network_is_reported(self):
        (self.fake / "offline").touch()
        status, output = self.setup()
        self.assertEqual(status, 1)
        self.assertIn("the packages could not be installed", output)
        self.assertIn("Is there a network?", output)
        (self.fake / "installed").write_text("first\nsecond\nlibrary-new\nauthority\n")
        status, output = self.setup()
        self.assertEqual(status, 1)
        self.assertIn("cannot fetch toy 1.0", output)
        self.assertIn("npm ERR! network", output)
        self.assertIn("--no-engines", output)
        self.assertFalse(self.engine.exists())

    def test_a_machine_without_engines_is_no_failure(self):
        (self.fake / "architecture").write_text("riscv64\n")
        status, output = self.setup()
        self.assertEqual(status, 0)
        self.assertIn("no engine is published for riscv64", output)

    def test_another_architecture_has_a_compiler_and_engines_of_its_own(self):
        self.setup("--engines-only")
        status, output = self.setup("--arch", "arm64", "--check")
        self.assertEqual(status, 1)
        self.assertTrue(output.endswith("setup: to install: tools/setup --arch arm64\n"), output)
        self.calls()
        self.assertEqual(self.setup("--arch", "arm64")[0], 0)
        self.assertIn("install --no-install-recommends --yes compiler-for-arm64\n", self.calls())
        self.assertEqual((self.engine.parent / "arm64" / "toy" / "lib" / "libtoy.so").read_text(), "the other library")
        self.assertEqual((self.engine / "lib" / "libtoy.so").read_text(), "the library")
        self.assertEqual(self.setup("--arch", "arm64"), (0, ""))
        self.assertEqual(self.setup("--arch", "amd64", "--engines-only"), (0, ""), "the architecture of this machine")

    def test_an_architecture_without_engines_is_refused(self):
        status, output = self.setup("--arch", "riscv64")
        self.assertEqual(status, 1)
        self.assertIn("no engine is published for riscv64 where tools/engines.txt looks; known are: amd64 arm64", output)
        self.assertIn("tools/setup --arch arm64", self.setup("--arch")[1])

    def test_wrong_options_are_refused(self):
        self.assertIn("unknown option '--al'", self.setup("--al")[1])
        self.assertIn("there is no engine 'tox' to fetch; known are: toy", self.setup("--engine", "tox")[1])
        self.assertEqual(self.setup("--no-engines", "--engines-only")[0], 1)
        self.assertEqual(self.calls(), "")

    @unittest.skipUnless(os.geteuid() == 0 and shutil.which("setpriv"), "needs root, to be someone else")
    def test_a_user_is_prompted(self):
        for path in (self.root, *self.root.rglob("*")):
            os.chown(path, 65534, 65534)
        command = ["setpriv", "--reuid=65534", "--regid=65534", "--clear-groups", self.tools / "setup"]
        environment = {"PATH": f"{self.fake}:/usr/bin:/bin", "FAKE": str(self.fake)}
        result = subprocess.run(command, env=environment, stdin=subprocess.DEVNULL, text=True, capture_output=True, check=False)
        self.assertEqual(result.returncode, 1)
        self.assertIn("tools/setup --yes", result.stderr)
        self.assertEqual(self.calls(), "")


class Configure(unittest.TestCase):
    def setUp(self):
        self.root = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory(prefix="weir configure ")))
        (self.root / "tools").mkdir()
        shutil.copy(TOOLS / "configure", self.root / "tools")
        (self.root / "meson.build").write_text("project('toy')\n")

    def configure(self, **variables):
        return subprocess.run([self.root / "tools" / "configure", "build"], env={**os.environ, **variables}, text=True,
                              capture_output=True, check=True).stdout

    def test_goes_on_where_it_was_interrupted(self):
        built = self.root / "build" / "build.ninja"
        for _ in range(2):
            self.configure()
            self.assertTrue(built.exists())
            built.unlink()  # as it is gone when Meson is stopped while it configures again

    def test_configures_again_when_a_package_has_come(self):
        (self.root / "tools" / "packages.txt").write_text("[test]  to test\ntoy-dev?  # a toy\n")
        write_program(self.root / "dpkg-query", '#!/bin/bash\n[[ ! -e $ROOT/come ]] || echo "${@: -1} installed"\n')
        variables = {"PATH": f"{self.root}:{os.environ['PATH']}", "ROOT": str(self.root)}
        self.assertIn("toy", self.configure(**variables))
        self.assertEqual(self.configure(**variables), "")
        (self.root / "come").touch()
        self.assertIn("toy", self.configure(**variables))
        self.assertEqual(self.configure(**variables), "")


class CountTests(unittest.TestCase):
    def count(self, log, junit, status):
        with tempfile.TemporaryDirectory() as build:
            logs = pathlib.Path(build) / "meson-logs"
            logs.mkdir()
            if log:
                (logs / "testlog.json").write_text("\n".join(log))
                (logs / "testlog.junit.xml").write_text(f"<testsuites>{junit}</testsuites>")
            result = subprocess.run([TOOLS / "count-tests.py", build, status], text=True, capture_output=True, check=False)
        return result.returncode, result.stdout.splitlines()

    CASES = '<testsuite name="weir.weir:core / core.A"><testcase name="b"/><testcase name="c"><skipped/></testcase></testsuite>'

    def test_counts_cases(self):
        log = ['{"name": "weir:core / core", "result": "OK"}', '{"name": "weir / plain", "result": "OK"}']
        self.assertEqual(self.count(log, self.CASES, "0"), (0, ["1 skipped", "2 passed, 0 failed"]))

    def test_counts_cases_of_tap_programs(self):
        log = ['{"name": "weir:apps / weir", "result": "FAIL"}']
        cases = ('<testsuite name="weir.weir:apps / weir"><testcase name="1 Run.a"/>'
                 '<testcase name="2 Run.b"><failure/></testcase></testsuite>')
        status, lines = self.count(log, cases, "1")
        self.assertEqual((status, lines), (1, ["FAILED weir:apps / weir: 2 Run.b", "1 passed, 1 failed"]))

    def test_a_program_that_fails_after_its_cases_passed_is_a_failure(self):
        log = ['{"name": "weir:core / core", "result": "FAIL"}']
        status, lines = self.count(log, self.CASES, "1")
        self.assertEqual((status, lines[-1]), (1, "1 passed, 1 failed"))
        self.assertIn("FAILED weir:core / core: FAIL, though none of its cases did", lines)

    def test_characters_that_xml_does_not_have_hide_nothing(self):
        log = ['{"name": "weir:core / core", "result": "FAIL"}']
        printed = self.CASES.replace("</testsuite>", "<system-err>\x1b[33mWARN \x00\ufffe\U0001f600</system-err></testsuite>")
        status, lines = self.count(log, printed, "1")
        self.assertEqual((status, lines[-1]), (1, "1 passed, 1 failed"))

    def test_a_program_that_ran_out_of_time_is_a_failure(self):
        log = ['{"name": "weir / slow", "result": "TIMEOUT"}']
        self.assertEqual(self.count(log, "", "1")[1][-1], "0 passed, 1 failed")

    def test_nothing_run_is_a_failure(self):
        self.assertEqual(self.count([], "", "1"), (1, ["FAILED meson test failed before it ran a test", "0 passed, 1 failed"]))
        self.assertEqual(self.count([], "", "0")[0], 1)


class Measure(unittest.TestCase):
    FILES = {"src/core/text/a.cpp": 40, "src/core/text/a_test.cpp": 7, "include/weir/a.h": 30, "apps/weir/a.py": 31,
             "tests/a.cpp": 5, "tools/a.py": 3, "docs/a.md": 9}

    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.root = pathlib.Path(temporary.name)
        (self.root / "tools").mkdir()
        shutil.copy(TOOLS / "measure", self.root / "tools")
        for name, lines in self.FILES.items():
            path = self.root / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text("x\n" * lines)
        self.git("init", "-q")
        self.git("add", *self.FILES)
        self.git("commit", "-qm", "first")

    def git(self, *arguments):
        subprocess.run(["git", "-c", "user.name=a", "-c", "user.email=a@b", *arguments], cwd=self.root, check=True)

    def measure(self, *arguments):
        output = subprocess.run([self.root / "tools/measure", *arguments], text=True, capture_output=True, check=True).stdout
        return {line[:42].strip(): [int(n) for n in line[42:].split() if n.lstrip("-").isdigit()] for line in output.splitlines()}

    def test_counts_product_tests_and_headers_apart(self):
        rows = self.measure()
        self.assertEqual(rows["product"], [3, 101])
        self.assertEqual(rows["product, files of at most 30 lines"], [1, 30])
        self.assertEqual(rows["public headers"], [1, 30])
        self.assertEqual(rows["tests and benchmarks"], [2, 12])
        self.assertEqual(rows["tools and examples"], [1, 3])
        self.assertEqual(rows["src/core/text"], [1, 40])

    def test_compares_two_commits(self):
        (self.root / "src/core/text/a.cpp").write_text("x\n" * 15)
        self.git("commit", "-qam", "second")
        rows = self.measure("HEAD~1", "HEAD")
        self.assertEqual(rows["src/core/text"], [1, 40, 1, 15, 0, -25])
        self.assertNotIn("apps/weir", rows)

    def test_reads_the_compile_steps_of_a_build(self):
        build = self.root / "build"
        build.mkdir()
        (build / ".ninja_log").write_text("# ninja log v5\n0\t900\t1\ta.o\tf\n5\t1505\t1\ta.o\tf\n0\t500\t1\tb.o\tf\n0\t9000\t1\tb.so\tf\n")
        output = subprocess.run([self.root / "tools/measure", "--build", build], text=True, capture_output=True, check=True).stdout
        self.assertEqual(output.splitlines()[-1], "compile steps: 2, 2 s")


def main(module):
    """Runs the tests of a module; the last line is `N passed, N failed`."""
    result = unittest.TextTestRunner(verbosity=2).run(unittest.defaultTestLoader.loadTestsFromModule(module))
    failed = len(result.failures) + len(result.errors)
    sys.stderr.flush()
    print(f"{result.testsRun - failed - len(result.skipped)} passed, {failed} failed", flush=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.modules[__name__]))
