#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Tests of Weir next to another plug-in with elements of the same names."""

import json
import os

import tap_runner
from weir_case import DECOY, PLUGIN, Case, weir


class ConflictingPlugins(Case):
    def test_another_plugin_with_the_same_elements_is_a_conflict(self):
        def conflicts(*folders):
            """By the plug-in that owns tensor_filter: the one that GStreamer reads last."""
            variables = self.plugins_of(*folders)
            report = json.loads(self.good(weir("doctor", "--json", **variables)))
            owner = {e["name"]: e["plugin"] for e in report["elements"]}["tensor_filter"]
            return owner, report["conflicts"], self.good(weir("doctor", **variables))

        results = {r[0]: r for r in (conflicts(DECOY.parent, PLUGIN.parent), conflicts(PLUGIN.parent, DECOY.parent))}
        self.assertEqual(set(results), {"weir", "decoy"})
        self.assertEqual(results["weir"][1], [])
        _, found, output = results["decoy"]
        self.assertEqual([(c["plugin"], c["file"]) for c in found], [("decoy", str(DECOY))])
        self.assertEqual(found[0]["version"], "1")
        self.assertIn("GStreamer uses tensor_filter from that plug-in, not from Weir", found[0]["reason"])
        for words in (f"the plug-in decoy (version 1) conflicts with Weir: {DECOY}\n", found[0]["reason"], "fix: remove the package"):
            self.assertIn(words, output)
        self.assertRegex(output, r"Elements     1 of the plug-in decoy, \d+ of the plug-in weir(, \d+ of the plug-in weir(edge|net))*\n")
        self.assertRegex(results["weir"][2], r"Elements     \d+ of the plug-in weir(, \d+ of the plug-in weir(edge|net))*\n")

    def test_one_setting_leaves_the_elements_to_another_plugin(self):
        paths = self.plugins_of(DECOY.parent, PLUGIN.parent)

        def owners(**variables):
            report = json.loads(self.good(weir("doctor", "--json", **paths, **variables)))
            return {e["name"]: e["plugin"] for e in report["elements"]}, report

        before, report = owners()
        self.assertEqual((before["tensor_mux"], report["yields_to"]), ("weir", ""))
        self.assertEqual({e["rank"] for e in report["elements"]}, {0})
        # With the same registry GStreamer scans Weir again when the variable changes, but not the
        # other plug-in, whose elements it dropped when Weir's took their names.
        if before["tensor_filter"] == "weir":
            report = owners(WEIR_PLUGIN_PREFER_NNSTREAMER="true")[1]
            self.assertIn("GStreamer's registry has no tensor_filter", report["conflicts"][0]["reason"])
            self.assertEqual(report["conflicts"][0]["fix"], f"rm {paths['GST_REGISTRY']}")
            self.assertEqual(owners(WEIR_PLUGIN_PREFER_NNSTREAMER="false")[0], before)
        os.remove(paths["GST_REGISTRY"])
        after, report = owners(WEIR_PLUGIN_PREFER_NNSTREAMER="true")
        self.assertEqual((after["tensor_filter"], after["tensor_preprocess"]), ("decoy", "weir"))
        for name in ("tensor_mux", "tensor_converter", "join"):
            self.assertNotIn(name, after)
        self.assertEqual((report["yields_to"], report["owners"]["decoy"]), ("WEIR_PLUGIN_PREFER_NNSTREAMER", 1))
        self.assertIn("WEIR_PLUGIN_PREFER_NNSTREAMER, which sets prefer_nnstreamer", report["conflicts"][0]["fix"])
        # Set by a file, and by a change of that file.
        path = self.folder / "weir.ini"
        path.write_text("[plugin]\nprefer_nnstreamer = yes\n")
        after, report = owners(WEIR_CONFIG=str(path))
        self.assertEqual((after["tensor_filter"], report["yields_to"]), ("decoy", f"{path}:2"))
        path.write_text("[plugin]\nprefer_nnstreamer = no  \n\n")
        self.assertEqual(owners(WEIR_CONFIG=str(path))[0]["tensor_mux"], "weir")

    def test_both_plugins_in_one_process_run_and_are_reported(self):
        output = ""
        line = "videotestsrc num-buffers=4 ! tensor_converter ! tensor_aggregator frames-out=2 ! tensor_sink sync=false"
        for number, (first, second) in enumerate([(PLUGIN, DECOY), (DECOY, PLUGIN)]):
            paths = {"GST_PLUGIN_PATH": f"{first.parent}:{second.parent}", "GST_REGISTRY": str(self.folder / f"registry-{number}")}
            for text in (f"decoy_bin {line}", f"{line} decoy_bin"):
                # Detects uses of a factory that the registry has freed.
                done = weir("run", text, GST_DEBUG="2", GST_DEBUG_NO_COLOR="1", G_DEBUG="fatal-criticals",
                            G_SLICE="always-malloc", MALLOC_PERTURB_="165", **paths)
                self.assertIn("2 frames", self.good(done))
                output += done.stderr
        self.assertRegex(output, r"tensor_filter is now registered by Weir instead of the plug-in decoy \(.*\): weir doctor")


if __name__ == "__main__":
    tap_runner.main()
