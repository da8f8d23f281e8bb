#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Tests of tools/setup, tools/configure, tools/install, tools/uninstall, tools/deb, tools/count-tests.py, tools/measure and
tools/sbom, in folders of their own and with stand-ins for npm, apt, dpkg, meson and ninja: nothing is fetched and nothing
installed. The last line is `N passed, N failed`.
"""

import base64
import hashlib
import json
import os
import pathlib
import re
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
grep -qxF -e "${@: -1}" "$FAKE/installed" && echo -n installed
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


class Install(unittest.TestCase):
    """With a stand-in for meson that installs two files and logs them as Meson does."""

    MESON = """#!/bin/bash
echo "meson $*" >> "$FAKE/calls"
d=$DESTDIR/usr/lib/weir
echo "# List of files installed by Meson" > build/meson-logs/install-log.txt
mkdir -p "$d" && echo "$d" > "$FAKE/folder"
for f in a b; do echo x > "$d/$f"; echo "$d/$f" >> build/meson-logs/install-log.txt; done
cat "$FAKE/folder" >> build/meson-logs/install-log.txt
"""
    NINJA = """#!/bin/bash
echo "ninja $*" >> "$FAKE/calls"
[[ ! -e $FAKE/broken ]]
"""

    def setUp(self):
        self.root = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory(prefix="weir install ")))
        write_program(self.root / "meson", self.MESON)
        write_program(self.root / "ninja", self.NINJA)
        (self.root / "build" / "meson-logs").mkdir(parents=True)
        (self.root / "build" / "meson-info").mkdir()
        targets = [{"installed": name == "weir", "filename": [str(self.root / "build" / "apps" / name)]} for name in ("weir", "weir_test")]
        (self.root / "build" / "meson-info" / "intro-targets.json").write_text(json.dumps(targets))
        self.place = self.root / "dest dir"
        self.environment = dict(os.environ, PATH=f"{self.root}:/usr/bin:/bin", FAKE=str(self.root), DESTDIR=str(self.place))

    def call(self, *command):
        return subprocess.run([TOOLS / command[0], *command[1:]], cwd=self.root, env=self.environment, text=True,
                              capture_output=True, check=True).stdout

    def test_uninstall_takes_away_what_was_installed_and_nothing_else(self):
        self.call("install", "build", "/usr")
        self.call("install", "build", "/usr")
        foreign = self.place / "usr" / "lib" / "other"
        foreign.write_text("not ours")
        shutil.rmtree(self.root / "build")
        self.assertIn("3 files removed", self.call("uninstall", "/usr"))
        files = [p for p in self.place.rglob("*") if p.is_file()]
        self.assertEqual(files, [foreign])
        self.assertFalse((self.place / "usr" / "lib" / "weir").exists())
        self.assertFalse((self.place / "usr" / "share").exists())

    def test_builds_what_it_installs_and_nothing_else(self):
        self.call("install", "--jobs", "3", "build", "/usr")
        calls = (self.root / "calls").read_text().splitlines()
        self.assertEqual(calls[:2], ["ninja -C build build.ninja", "ninja -C build -j 3 apps/weir"])
        self.assertIn("--no-rebuild", calls[2])

    def test_installs_nothing_where_the_build_fails(self):
        (self.root / "broken").touch()
        with self.assertRaises(subprocess.CalledProcessError):
            self.call("install", "--jobs", "3", "build", "/usr")
        self.assertFalse(self.place.exists())

    def test_installs_no_debug_information(self):
        self.call("install", "build", "/usr")
        self.assertRegex((self.root / "calls").read_text(), "^meson install .*--strip")

    def test_uninstall_of_nothing_is_reported(self):
        self.assertIn("nothing to do", self.call("uninstall", "/usr"))


class Deb(unittest.TestCase):
    """With stand-ins for what checks, builds, indexes and signs packages."""

    FAKES = {
        "apt-ftparchive": """#!/bin/bash
[[ $1 == packages ]] && ls *.deb || echo "Origin: Weir"
""",
        "apt-get": """#!/bin/bash
echo "apt-get $*" >> "$FAKE/calls"
""",
        "dpkg-checkbuilddeps": """#!/bin/bash
[[ ! -e $FAKE/missing ]] || { echo "dpkg-checkbuilddeps: error: Unmet build dependencies: libfrob-dev" >&2; exit 1; }
""",
        "dpkg-buildpackage": """#!/bin/bash
[[ ! -e $FAKE/broken ]] || { echo "frob.cpp: error"; exit 2; }
version=$(sed -n '1s/.*(\\(.*\\)).*/\\1/p' debian/changelog)
touch "../weir_${version}_all.deb" "../libweir0_${version}_$(dpkg --print-architecture).deb"
""",
        "dpkg-deb": "#!/bin/sh\n",
        "dpkg-deb": "#!/bin/sh\n",
        "pkg-config": "#!/bin/bash\n[[ -e $FAKE/onnxruntime ]]\n",
        "gpg": """#!/bin/bash
[[ "$*" != *unknown* ]] || exit 2
[[ "$*" != *--export* ]] || printf 'BEGIN KEY\\n\\nabc\\n'
[[ "$*" != *--export* ]] || printf 'BEGIN KEY\\n\\nabc\\n'
while (($#)); do [[ $1 != --output ]] || echo signed > "$2"; shift; done
""",
    }

    def setUp(self):
        self.root = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory(prefix="weir deb ")))
        fakes = self.root / "fakes"
        checkout = self.root / "checkout"
        for folder in ("tools", "packages/debian", ".engines/onnxruntime", ".engines/tensorflow-lite"):
            (checkout / folder).mkdir(parents=True)
        fakes.mkdir()
        for name, text in self.FAKES.items():
            write_program(fakes / name, text)
        for name in ("deb", "sources"):
            shutil.copy(TOOLS / name, checkout / "tools")
        write_program(checkout / "tools" / "sbom", "#!/bin/sh\necho '{}'\n")
        write_program(checkout / "tools" / "sbom", "#!/bin/sh\necho '{}'\n")
        (checkout / "meson.build").write_text("project('weir', version: '3.0.0')")
        (checkout / "packages" / "debian" / "control").write_text("Source: weir")
        self.news = checkout / "CHANGELOG.md"
        self.news.write_text("")
        self.checkout, self.folder = checkout, self.root / "packages"
        self.environment = dict(os.environ, PATH=f"{fakes}:/usr/bin:/bin", FAKE=str(self.root))

    def call(self, *options):
        return subprocess.run([self.checkout / "tools" / "deb", "--folder", self.folder, *options], env=self.environment, text=True,
                              capture_output=True, check=False)

    def refused(self, *options):
        done = self.call(*options)
        self.assertNotEqual(done.returncode, 0, done.stdout)
        self.assertNotIn("Traceback", done.stderr)
        return done.stderr

    def version(self, seconds):
        """Of a build from sources of that time."""
        os.utime(self.news, (seconds, seconds))
        done = self.call()
        self.assertEqual(done.returncode, 0, done.stderr)
        packages = sorted(path.name for path in self.folder.glob("*.deb"))
        self.assertEqual(len(packages), 2, packages)  # those of the build before are gone
        return packages[1].split("_")[1]

    def test_a_later_commit_has_a_later_version(self):
        first, second = self.version(1_700_000_000), self.version(1_800_000_000)
        self.assertTrue(first.startswith("3.0.0+20231114.221320~deb"), first)
        for smaller, larger in ((first, second), (first, first.partition("~deb")[0] + "~deb99"), ("3.0.0~rc1", first), (second, "3.0.1")):
            self.assertEqual(subprocess.run(["dpkg", "--compare-versions", smaller, "lt", larger], check=False).returncode, 0, (smaller, larger))

    def test_the_folder_is_a_source_of_apt(self):
        self.version(1_700_000_000)
        source = (self.folder / "weir.sources").read_text()
        self.assertEqual(source, f"Types: deb\nURIs: {self.folder.as_uri()}\nSuites: ./\nTrusted: yes\n")
        self.assertNotIn(" ", self.folder.as_uri())  # apt would not read any source
        self.assertIn("libweir0_", (self.folder / "Packages").read_text())
        self.assertEqual(self.call("--key", "mine").returncode, 0)
        source = (self.folder / "weir.sources").read_text()
        self.assertIn("Signed-By:\n BEGIN KEY\n .\n abc\n", source)
        self.assertNotIn("Trusted", source)
        self.assertTrue((self.folder / "InRelease").exists())
        self.assertEqual(self.call().returncode, 0)
        self.assertFalse((self.folder / "InRelease").exists(), "the signature of another index")

    def test_changes_that_are_not_committed_have_a_version_of_their_own(self):
        def git(*words):
            subprocess.run(["git", "-C", self.checkout, "-c", "user.name=x", "-c", "user.email=x", *words], env={
                **self.environment, "GIT_COMMITTER_DATE": "1700000000 +0000"}, capture_output=True, check=True)

        git("init")
        (self.checkout / ".gitignore").write_text("/build-deb\n/.engines\n")
        git("add", ".")
        git("commit", "-m", "x")
        clean = self.version(1)
        self.assertTrue(clean.startswith("3.0.0+20231114.221320~deb"), clean)
        changelog = self.checkout / "build-deb" / "weir" / "debian" / "changelog"
        self.assertRegex(changelog.read_text(), r"Commit \w{8}\. ")
        self.news.write_text("more")
        self.assertGreater(self.version(1), clean)
        self.assertIn("not committed", changelog.read_text())

    def test_a_folder_that_apt_cannot_read_is_copied(self):
        self.root.chmod(0o700)
        self.assertRegex(self.call().stdout, r"cp '.*packages'/\* /srv/weir/ +# apt cannot read .*\n +sed 's\|\^URIs")

    def test_what_is_missing_is_named_with_its_fix(self):
        self.assertIn("gpg --quick-generate-key 'the unknown'", self.refused("--key", "the unknown"))
        (self.root / "broken").touch()
        self.assertIn("frob.cpp: error", self.refused())
        (self.root / "broken").unlink()
        (self.root / "missing").touch()
        if os.geteuid() == 0:
            self.assertEqual(self.call().returncode, 0)
            self.assertIn("build-dep --yes", (self.root / "calls").read_text())
        else:
            self.assertRegex(self.refused(), "libfrob-dev\n +sudo apt-get build-dep")
        (self.root / "missing").unlink()
        shutil.rmtree(self.checkout / ".engines" / "onnxruntime")
        self.assertIn("tools/setup --engine onnxruntime", self.refused())
        (self.root / "onnxruntime").touch()
        self.assertEqual(self.call().returncode, 0, "ONNX Runtime is a package of this release")


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


class Sbom(unittest.TestCase):
    FILES = ("bin/weir", "lib/libweir.so.0.1.0", "lib/gstreamer-1.0/libgstweir.so", "lib/weir/modules/libweir-decoder-flatbuf.so",
             "lib/weir/engines/onnxruntime/lib/libonnxruntime.so.1", "lib/weir/engines/tensorflow-lite/lib/libtensorflowlite_c.so",
             "lib/python3/dist-packages/weir/_weir.cpython-311-x86_64-linux-gnu.so", "share/weir/cards/a.card.json")

    def setUp(self):
        self.root = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory(prefix="weir sbom ")))
        self.install(self.FILES)

    def install(self, names):
        manifest = self.root / "usr" / "share" / "weir" / "install-manifest.txt"
        for name in names:
            path = self.root / "usr" / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(name)
        (self.root / "usr" / "lib" / "libweir.so").symlink_to("libweir.so.0.1.0")
        manifest.parent.mkdir(parents=True, exist_ok=True)
        lines = ["/usr/lib", "/usr/lib/libweir.so", *(f"/usr/{name}" for name in names), "/usr/share/weir/install-manifest.txt"]
        manifest.write_text("".join(f"{line}\n" for line in lines))

    def call(self, *arguments, **variables):
        return subprocess.run([TOOLS / "sbom", *arguments], env={**os.environ, "SOURCE_DATE_EPOCH": "1700000000", **variables}, text=True,
                              capture_output=True, check=False)

    def document(self):
        done = self.call(self.root)
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads(done.stdout)

    def test_has_the_fields_that_the_specification_requires(self):
        document = self.document()
        self.assertEqual((document["spdxVersion"], document["dataLicense"], document["SPDXID"]), ("SPDX-2.3", "CC0-1.0", "SPDXRef-DOCUMENT"))
        self.assertEqual(document["creationInfo"], {"created": "2023-11-14T22:13:20Z", "creators": ["Tool: tools/sbom"]})
        self.assertRegex(document["documentNamespace"], r"^https://[^#]+$")
        parts = document["packages"] + document["files"]
        known = [part["SPDXID"] for part in parts]
        self.assertEqual(len(known), len(set(known)))
        for part in parts:
            self.assertRegex(part["SPDXID"], r"^SPDXRef-[A-Za-z0-9.-]+$")
            self.assertTrue(part["licenseConcluded"])
        filled = {relation["spdxElementId"] for relation in document["relationships"] if relation["relationshipType"] == "CONTAINS"}
        for part in document["packages"]:
            self.assertEqual((part["filesAnalyzed"], "packageVerificationCode" in part), (part["SPDXID"] in filled,) * 2)
            self.assertTrue(part["name"] and part["downloadLocation"] and part["licenseDeclared"] and part["supplier"])
        for part in document["files"]:
            content = (self.root / part["fileName"]).read_bytes()
            self.assertEqual(part["checksums"][0], {"algorithm": "SHA1", "checksumValue": hashlib.sha1(content).hexdigest()})
        for relation in document["relationships"]:
            for end in ("spdxElementId", "relatedSpdxElement"):
                self.assertIn(relation[end], [*known, "SPDXRef-DOCUMENT"])

    def test_each_file_is_in_one_package(self):
        document = self.document()
        ids = {part["SPDXID"]: part["fileName"] for part in document["files"]}
        owners = {}
        for relation in document["relationships"]:
            if relation["relationshipType"] == "CONTAINS":
                owners.setdefault(ids[relation["relatedSpdxElement"]], []).append(relation["spdxElementId"])
        wanted = {f"./usr/{name}": ["SPDXRef-Package-Weir"] for name in (*self.FILES, "share/weir/install-manifest.txt")}
        for engine, name in (("onnxruntime", self.FILES[4]), ("tensorflow-lite", self.FILES[5])):
            wanted[f"./usr/{name}"] = [f"SPDXRef-Package-{engine}"]
        self.assertEqual(owners, wanted)

    def test_names_what_is_compiled_in_and_the_pins_of_the_engines(self):
        packages = {part["name"]: part for part in self.document()["packages"]}
        for name, licence in (("Weir", "LGPL-2.1-or-later"), ("CLI11", "BSD-3-Clause"), ("pybind11", "BSD-3-Clause"), ("flatbuffers", "Apache-2.0"),
                              ("highway", "Apache-2.0"), ("onnxruntime", "MIT"), ("xnnpack in tensorflow-lite", "BSD-3-Clause")):
            self.assertEqual(packages[name]["licenseDeclared"], licence)
        line = re.search(r"^onnxruntime +npm +\S+ +(\S+) +sha512-(\S+)$", (TOOLS / "engines.txt").read_text(), re.MULTILINE)
        self.assertEqual((packages["onnxruntime"]["versionInfo"], packages["onnxruntime"]["checksums"][0]["checksumValue"]),
                         (line[1], base64.b64decode(line[2]).hex()))

    def test_lists_only_what_is_installed(self):
        shutil.rmtree(self.root / "usr")
        self.install(["lib/libweir.so.0.1.0"])
        self.assertEqual([part["name"] for part in self.document()["packages"]], ["Weir", "highway", "nlohmann-json"])

    def test_is_the_same_each_time_and_another_for_another_file(self):
        first = self.call(self.root).stdout
        self.assertEqual(self.call(self.root).stdout, first)
        (self.root / "usr" / "bin" / "weir").write_text("another")
        self.assertNotEqual(json.loads(self.call(self.root).stdout)["documentNamespace"], json.loads(first)["documentNamespace"])

    def test_knows_the_licence_of_each_engine(self):
        names = set(re.findall(r"^([\w-]+) +(?:npm|debian) ", (TOOLS / "engines.txt").read_text(), re.MULTILINE))
        shutil.rmtree(self.root / "usr")
        self.install(["lib/x", *(f"lib/weir/engines/{name}/lib/x.so" for name in names)])
        self.assertLessEqual(names, {part["name"] for part in self.document()["packages"]})

    def test_wrong_arguments_are_errors_with_a_fix(self):
        for arguments, text in (((), "one folder is needed"), (("--all",), "one folder is needed"),
                                ((self.root / "usr" / "bin",), "is no installation of Weir")):
            done = self.call(*arguments)
            self.assertEqual((done.returncode, done.stdout), (1, ""))
            self.assertIn(text, done.stderr)
            self.assertIn("fix: ", done.stderr)


def main(module):
    """Runs the tests of a module; the last line is `N passed, N failed`."""
    result = unittest.TextTestRunner(verbosity=2).run(unittest.defaultTestLoader.loadTestsFromModule(module))
    failed = len(result.failures) + len(result.errors)
    sys.stderr.flush()
    print(f"{result.testsRun - failed - len(result.skipped)} passed, {failed} failed", flush=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.modules[__name__]))
