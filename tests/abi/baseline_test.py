#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Tests that the headers keep the C ABI of tests/abi/baseline, that elements keep their pads, properties and values, and that the
comparison finds what breaks programs, modules and pipelines.

symbols_test.py compares the lists of symbols with the libraries of the build, and outside_test.py runs modules that are built with the
headers of the baseline.
"""

import pathlib
import platform
import re
import shutil
import tempfile
import unittest

import compatibility
import tap_runner

# File, what stands there, what takes its place, what the report names.
BREAKS = [
    ("model.h", r"WEIR_EXPORT void weir_results_free\(.*", "", "[D] 'function void weir_results_free(weir_results*)'"),
    ("model.h", "uint32_t n_inputs, uint32_t n_frames", "uint32_t n_inputs, uint64_t n_frames",
     "parameter 4 of type 'typedef uint32_t' changed"),
    ("model.h", r"weir_results_free\(weir_results\* results\)", "weir_results_free(weir_results* results, int all)",
     "parameter 2 of type 'int' was added"),
    ("abi.h", "WEIR_NO_RESULT = 1", "WEIR_NO_RESULT = 2", "'weir_no_result::WEIR_NO_RESULT' from value '1' to '2'"),
    ("abi.h", "WEIR_TYPE_END\n", "WEIR_BFLOAT16,\n  WEIR_TYPE_END\n", "'weir_type::WEIR_TYPE_END' from value '11' to '12'"),
    ("codes.h", r"X\(CANCELLED, 8001", "X(STOPPED, 8001", "'weir_code::WEIR_CANCELLED' value '8001'"),
    # Of a frozen struct: another type, another order, a member that is gone or added, a name.
    ("abi.h", "float x, y, w, h,", "double x, y, w, h,", "type of 'float x' changed"),
    ("abi.h", "float x, y, w, h,", "float y, x, w, h,", "'float x' offset changed from 0 to 32"),
    ("abi.h", "  int32_t circuit; .*", "  uint32_t state;", "'weir_server::circuit'"),
    ("abi.h", r"(\} weir_option;)", r"const char* more; \1", "'const char* more', at offset 128"),
    # Of structs that may grow: in the middle, in the padding, gone, and a function in one that has grown since the baseline.
    ("abi.h", r"(  weir_error\* \(\*error_of\))", r"  void* more;\n\1", "'void* more', at offset 320"),
    ("abi.h", "(  uint32_t n_card_labels;)", r"\1 uint32_t more;", "'uint32_t more', at offset 480"),
    ("abi.h", r"  uint32_t \(\*classes\)\(weir_decoder\*\);", "", "'typedef uint32_t (weir_decoder*)* classes'"),
    ("abi.h", r"uint32_t \(\*classes\)\(weir_decoder\*\);", "int64_t (*classes)(weir_decoder*); void* more;",
     "'typedef uint32_t (weir_decoder*)* classes' changed"),
]
ADDITIONS = [
    ("model.h", r"(?=WEIR_EXPORT void weir_model_close)", "typedef struct { int x; } weir_more;\nWEIR_EXPORT int weir_model_more(weir_more*);\n"),
    ("abi.h", r"WEIR_SET_OPTION \}", "WEIR_SET_OPTION, WEIR_MORE }"),
    ("codes.h", r"(?=X\(CANCELLED, 8001)", 'X(LOST, 7001, "A frame is lost") '),
    ("abi.h", r"(const void\* \(\*extension\)\(const char\* id\);)", r"\1 void* more;"),
]


@unittest.skipUnless(shutil.which("abidw") and shutil.which("abidiff"), "abigail-tools is not installed")
@unittest.skipUnless(platform.machine() == "x86_64", "the baseline describes x86-64")
class Baseline(unittest.TestCase):
    def changed(self, *changes):
        """A copy of the headers with these changes."""
        include = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        shutil.copytree(compatibility.INCLUDE / "weir", include / "weir")
        for name, before, after in changes:
            text, count = re.subn(before, after, (include / "weir" / name).read_text(encoding="utf-8"))
            self.assertGreater(count, 0, f"{name} has no '{before}'")
            (include / "weir" / name).write_text(text, encoding="utf-8")
        return include

    def test_the_headers_keep_what_the_baseline_has(self):
        changes = compatibility.compare(compatibility.INCLUDE)
        self.assertEqual(changes, "", f"{changes}\n{compatibility.FIX}")

    def test_the_constants_keep_their_values(self):
        today = compatibility.constants(compatibility.INCLUDE)
        for name, value in compatibility.constants(compatibility.BASELINE / "include").items():
            self.assertEqual(today.get(name), value, f"{name}\n{compatibility.FIX}")

    def test_the_headers_declare_what_the_libraries_export(self):
        lists = [(compatibility.FOLDER / f"{name}.symbols").read_text(encoding="utf-8").split() for name in ("libweir", "libweir-pipeline")]
        exported = {name.removesuffix("@@WEIR_0") for name in sum(lists, []) if not name.endswith("@@WEIR_PRIVATE")}
        declared = set(re.findall("<elf-symbol name='(weir_\\w+)' type='func-type'", compatibility.describe(compatibility.INCLUDE)))
        self.assertEqual(declared, exported | {"weir_module_entry"})

    def test_what_breaks_programs_or_modules_is_found(self):
        for name, before, after, report in BREAKS:
            with self.subTest(report):
                self.assertIn(report, compatibility.compare(self.changed((name, before, after))))

    def test_what_is_added_is_no_change(self):
        self.assertEqual(compatibility.compare(self.changed(*ADDITIONS)), "")

    def test_what_was_added_before_the_baseline_is_kept(self):
        later = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory())) / "later.abi"
        later.write_text(compatibility.describe(self.changed(*ADDITIONS)), encoding="utf-8")
        changes = compatibility.compare(compatibility.INCLUDE, later)
        for report in ("[D] 'function int weir_model_more(weir_more*)'", "'weir_control::WEIR_MORE' value '5'", "'void* more', at offset 512",
                       "'weir_code::WEIR_LOST' value '7001'"):
            self.assertIn(report, changes)


class Elements(unittest.TestCase):
    def test_elements_keep_their_pads_properties_and_values(self):
        self.assertEqual(compatibility.gone(), [], compatibility.NAME_FIX)

    def test_a_pad_a_property_a_value_and_an_element_that_are_gone_are_found(self):
        folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory())) / "elements"
        shutil.copytree(compatibility.FOLDER.parents[1] / "docs" / "elements", folder)
        (folder / "tensor_sink.md").unlink()
        page = folder / "tensor_mux.md"
        text = page.read_text(encoding="utf-8").replace("'sink_%u'", "'input_%u'").replace("| `max-wait` |", "| `wait` |")
        text = text.replace("Availability: Always", "Availability: Sometimes").replace("| `silent` | Boolean.", "| `silent` | String.")
        page.write_text(text.replace("(1): drop ", "(2): drop "), encoding="utf-8")
        found = compatibility.gone(compatibility.elements(folder))
        self.assertEqual([line for line in found if not line.startswith("tensor_sink ")],
                         ["tensor_mux max-wait Unsigned Integer64 readable, writable", "tensor_mux on-backwards-time 1 = drop",
                          "tensor_mux pad SINK sink_%u On request", "tensor_mux pad SRC src Always",
                          "tensor_mux silent Boolean readable, writable"])
        self.assertIn("tensor_sink pad SINK sink Always", found)


if __name__ == "__main__":
    tap_runner.main()
