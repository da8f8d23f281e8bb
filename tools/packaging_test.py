#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Tests of tools/install, tools/uninstall, tools/deb and tools/sbom, in folders of their own and with stand-ins for meson, ninja and
what builds packages: nothing is installed. The last line is `N passed, N failed`.
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
import tempfile
import unittest

from tools_test import TOOLS, main, write_program


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
echo "engines of ${@: -1}: $WEIR_ENGINES_DIR"
version=$(sed -n '1s/.*(\\(.*\\)).*/\\1/p' debian/changelog)
touch "../weir_${version}_all.deb" "../libweir0_${version}_${@: -1}.deb"
""",
        "dpkg": '''#!/bin/bash
case $1 in --print-architecture) echo amd64 ;; --print-foreign-architectures) ;; *) echo "dpkg $*" >> "$FAKE/calls" ;; esac
''',
        "dpkg-deb": "#!/bin/sh\n",
        "pkg-config": "#!/bin/bash\n[[ -e $FAKE/onnxruntime ]]\n",
        "aarch64-linux-gnu-pkg-config": "#!/bin/bash\nexit 1\n",
        "aarch64-linux-gnu-g++": "#!/bin/bash\n",
        "gpg": """#!/bin/bash
[[ "$*" != *unknown* ]] || exit 2
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
        (checkout / "tools" / "engines.txt").write_text("arch  amd64 x64\narch  arm64 arm64\n")
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

    def cross_compile(self):
        done = self.call("--arch", "arm64")
        self.assertEqual(done.returncode, 0, done.stderr)
        return {path.name.split("_")[2] for path in self.folder.glob("*.deb")}

    def test_packages_of_a_commit_for_several_architectures_share_a_folder(self):
        for engine in ("onnxruntime", "tensorflow-lite"):
            (self.checkout / ".engines" / "arm64" / engine).mkdir(parents=True)
        self.version(1_700_000_000)
        self.assertEqual(self.cross_compile(), {"all.deb", "amd64.deb", "arm64.deb"})
        self.assertEqual({path.name for path in self.folder.glob("*.json")}, {"weir-amd64.spdx.json", "weir-arm64.spdx.json"})
        log = (self.checkout / "build-deb" / "weir.log").read_text()
        self.assertIn(f"engines of arm64: {self.checkout.resolve()}/.engines/arm64\n", log)
        os.utime(self.news, (1_800_000_000, 1_800_000_000))
        self.assertEqual(self.cross_compile(), {"all.deb", "arm64.deb"}, "those for the other architecture are of an earlier commit")
        self.assertEqual({path.name for path in self.folder.glob("*.json")}, {"weir-arm64.spdx.json"})

    def test_what_is_missing_to_cross_compile_is_named_with_its_fix(self):
        self.assertRegex(self.refused("--arch", "riscv64"), "no engine .* 'riscv64'; known are: amd64, arm64\n +make deb ARCH=arm64")
        self.assertIn("tools/setup --arch arm64 --engine onnxruntime", self.refused("--arch", "arm64"))
        (self.root / "missing").touch()
        commands = ["dpkg --add-architecture arm64", "apt-get update",
                    "apt-get build-dep --host-architecture arm64 --no-remove --yes --no-install-recommends"]
        refused = self.refused("--arch", "arm64")
        if os.geteuid() == 0:
            calls = (self.root / "calls").read_text().splitlines()
            self.assertEqual(calls[:2], commands[:2])
            self.assertTrue(calls[2].startswith(commands[2]), calls)
        else:
            self.assertIn(" && ".join(f"sudo {command}" for command in commands), refused)
        (self.root / "fakes" / "aarch64-linux-gnu-g++").unlink()
        if not shutil.which("aarch64-linux-gnu-g++"):
            self.assertRegex(self.refused("--arch", "arm64"), "cross compiler for arm64 is not installed\n +tools/setup --arch arm64")

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


if __name__ == "__main__":
    sys.exit(main(sys.modules[__name__]))
