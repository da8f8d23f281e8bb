#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""What programs, modules and pipelines rely on, compared with tests/abi/baseline: the C ABI that the headers of include/weir declare, as
libabigail describes it, and the pads, properties and values of the elements, as the pages in docs/elements have them.

`tests/abi/compatibility.py --renew` writes tests/abi/baseline. It refuses where something that the baseline has is changed or gone, unless
WEIR_ABI_MAJOR is another one.

What libabigail describes is a small library that is compiled from the headers alone: each function has a body, and each type has a variable.
The libraries of the build show less: they are built without types (-g1), and no function of them mentions the extensions of modules and
the enumerations.
"""

import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import xml.etree.ElementTree

FOLDER = pathlib.Path(__file__).resolve().parent
INCLUDE = FOLDER.parents[1] / "include"
BASELINE = FOLDER / "baseline"
DUMP = BASELINE / "weir.abi"
ELEMENTS = BASELINE / "elements.txt"
FIX = ("to keep what was built for Weir working: leave what exists as it is, and add a function, an enumerator, or a member at the end of "
       "a struct that begins with struct_size (docs/stability.md). With a new major version: raise WEIR_ABI_MAJOR and library_version, "
       "then run tests/abi/compatibility.py --renew")
NAME_FIX = ("a name stays as long as docs/stability.md says; the commit that removes it for a major release also removes its lines from "
            "tests/abi/baseline/elements.txt")


def run(*command, **more):
    return subprocess.run(command, capture_output=True, text=True, check=True, **more).stdout


def preprocess(include, *options):
    headers = sorted(f"#include <weir/{path.name}>\n" for path in (include / "weir").glob("*.h"))
    return run("cc", "-E", "-P", "-std=c11", "-I", include, "-DWEIR_EXPORT=WEIR_EXPORT", *options, "-x", "c", "-", input="".join(headers))


def constants(include):
    """The values of the macros without parameters."""
    found = re.findall(r"^#define (WEIR_\w+) (.+)$", preprocess(include, "-dM"), re.MULTILINE)
    return {name: value for name, value in found if not re.match("WEIR_(EXPORT|ABI_MINOR|ERROR_CODES)$", name)}


def describe(include):
    """The description of libabigail, without anything of this machine."""
    source = preprocess(include)
    types = [*re.findall(r"\} (weir_\w+);", source), *(f"enum {name}" for name in re.findall(r"enum (weir_\w+) \{", source))]
    source = re.sub(r"(?:WEIR_EXPORT |(?=const weir_module\* weir_module_entry))([^;]*);", r"\1 { __builtin_trap(); }", source)
    source += "".join(f"{name}* every_{name.split()[-1]};\n" for name in types)
    with tempfile.TemporaryDirectory() as folder:
        run("cc", "-std=c11", "-g", "-gno-record-gcc-switches", "-fPIC", "-shared", "-nostdlib", "-x", "c", "-", "-o", "weir.so",
            input=source, cwd=folder)
        return run("abidw", "--no-corpus-path", "--no-comp-dir-path", "--no-show-locs", "--type-id-style", "hash", "weir.so", cwd=folder)


def without_additions(today, baseline):
    """The description of today without what a later minor version may add: enumerators, and members at the end of structs that begin
    with struct_size. What is added within the size that such a struct had stays: struct_size does not tell whether it is there."""
    def parts(tree, kind):
        return {part.get("name"): part for part in tree.iter(kind) if part.get("name")}

    baseline, tree = (xml.etree.ElementTree.fromstring(text) for text in (baseline, today))
    for name, enum in parts(tree, "enum-decl").items():
        known = parts(parts(baseline, "enum-decl").get(name, enum), "enumerator")
        for enumerator in [part for part in enum.findall("enumerator") if part.get("name") not in known]:
            enum.remove(enumerator)
    before = parts(baseline, "class-decl")
    for name, struct in parts(tree, "class-decl").items():
        if name not in before or next(iter(parts(before[name], "var-decl")), None) != "struct_size":
            continue
        size = int(before[name].get("size-in-bits"))
        for member in [part for part in struct.findall("data-member") if int(part.get("layout-offset-in-bits")) >= size]:
            struct.remove(member)
        struct.set("size-in-bits", str(min(size, int(struct.get("size-in-bits")))))
    return xml.etree.ElementTree.tostring(tree, encoding="unicode")


def compare(include, baseline=DUMP):
    """What has changed in the headers or is gone; an empty text: nothing."""
    with tempfile.TemporaryDirectory() as folder:
        today = pathlib.Path(folder, "today.abi")
        today.write_text(without_additions(describe(include), baseline.read_text(encoding="utf-8")), encoding="utf-8")
        done = subprocess.run(["abidiff", "--harmless", "--no-added-syms", baseline, today], capture_output=True, text=True, check=False)
    return done.stdout + done.stderr if done.returncode else ""


def elements(folder=FOLDER.parents[1] / "docs" / "elements"):
    """A line for each pad template, property and value: `tensor_mux pad SRC src Always`, `tensor_mux silent Boolean readable, writable`,
    `tensor_mux on-backwards-time 1 = drop`. tools/gen-docs --check compares the pages with the plug-ins."""
    lines = []
    for page in folder.glob("*.md"):
        text = page.read_text(encoding="utf-8")
        lines += [f"{page.stem} pad {' '.join(pad)}" for pad in re.findall(r"(SRC|SINK) template: '(.+)'\n +Availability: (.+)", text)]
        for name, row, access in re.findall(r"^\| `([\w-]+)` \| (.*?) \| (readable(?:, writable)?|writable)", text, re.MULTILINE):
            kind = re.match(r"(?:(?!Default)[\w ])+", row)[0].strip()
            lines += [f"{page.stem} {name} {kind} {access}",
                      *(f"{page.stem} {name} {number} = {value}" for number, value in re.findall(r"\((\d+)\): (\S+)", row))]
    return sorted(set(lines))


def gone(today=None):
    return sorted(set(ELEMENTS.read_text(encoding="utf-8").splitlines()) - set(elements() if today is None else today))


def renew():
    frozen = BASELINE / "include"
    if names := gone():
        sys.exit("".join(f"gone: {name}\n" for name in names) + f"compatibility.py: nothing is written.\n{NAME_FIX}")
    is_new = constants(frozen).get("WEIR_ABI_MAJOR") != constants(INCLUDE)["WEIR_ABI_MAJOR"]
    if not is_new and (changes := compare(INCLUDE)):
        sys.exit(f"{changes}compatibility.py: nothing is written, because programs and modules that exist would break.\n{FIX}")
    if is_new:
        for header in (frozen / "weir").iterdir():
            shutil.copy(INCLUDE / "weir" / header.name, header)
    DUMP.write_text(describe(INCLUDE), encoding="utf-8")
    ELEMENTS.write_text("".join(f"{line}\n" for line in elements()), encoding="utf-8")


if __name__ == "__main__":
    if sys.argv[1:] != ["--renew"]:
        sys.exit("compatibility.py: the only option is --renew")
    renew()
