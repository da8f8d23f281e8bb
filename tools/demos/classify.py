# SPDX-License-Identifier: LGPL-2.1-or-later
"""Classifies a user's own photo or video: `weir inspect` says how, one pipeline does it."""

import collections
import json
import os
import pathlib
import subprocess

import gi

gi.require_version("Gst", "1.0")
gi.require_version("GstApp", "1.0")
from gi.repository import Gst, GstApp  # noqa: E402,F401

from demos.playing import play_to_end  # noqa: E402

PIPELINE = """
  filesrc name=file ! decodebin ! {preparation}
    ! tensor_filter name=network model={model} ! tensor_decoder name=decoder mode={decoder}
    ! appsink name=labels emit-signals=true sync=false
"""


def find_file(name, root, kind):
    """The path itself, else the file of that name in the data of the tests."""
    if pathlib.Path(name).is_file():
        return pathlib.Path(name).resolve()
    for folder in (os.environ.get("WEIR_DATA"), root / ".." / "shared"):
        found = sorted((pathlib.Path(folder) / kind).rglob(pathlib.Path(name).name)) if folder else []
        if found:
            return found[0].resolve()
    raise SystemExit(f"demo: {name} is not there, nor below {kind}/ of the folder in WEIR_DATA")


def inspect(build, model):
    done = subprocess.run([build / "apps/weir/weir", "inspect", "--json", model], capture_output=True, text=True)
    report = json.loads(done.stdout)
    error = report.get("error") or (not report.get("card") and report["no_card"])
    if error:
        parts = [f"demo: {error['id']}: {error['what']}"]
        parts += [f"  {part}: {error[part]}" for part in ("offered", "needed", "fix") if part in error]
        raise SystemExit("\n".join(parts))
    card = report["card"]
    if not card["labels"] or card["decoder"] != "image_labeling":
        raise SystemExit(f"demo: the card {card['path']} does not make its model a classifier with labels: "
                         + card.get("problem", "it needs labels and the decoder image_labeling"))
    return card


class Classifier:
    def __init__(self, source, model, card, label_file):
        self.pipeline = Gst.parse_launch(PIPELINE.format(
            preparation=card["preparation"], model=json.dumps(str(model)), decoder=card["decoder"]))
        self.pipeline.get_by_name("file").set_property("location", str(source))
        self.pipeline.get_by_name("decoder").set_property("option1", str(label_file))
        self.pipeline.get_by_name("labels").connect("new-sample", self.on_label)
        self.count, self.last, self.seen, self.error = 0, None, collections.Counter(), None

    def on_label(self, sink):
        buffer = sink.pull_sample().get_buffer()
        label = buffer.extract_dup(0, buffer.get_size()).rstrip(b"\0").decode(errors="replace")
        self.count += 1
        self.seen[label] += 1
        if label != self.last:
            print(f"  {buffer.pts / Gst.SECOND:8.2f} s  {label}", flush=True)
        self.last = label
        return Gst.FlowReturn.OK

    def play(self):
        self.error = play_to_end(self.pipeline)
        self.stats = self.pipeline.get_by_name("network").get_property("stats")
        self.pipeline.set_state(Gst.State.NULL)


def run(root, build, folder, source, model):
    """Prints what the model sees, each time that it changes. Returns the exit code."""
    source, model = find_file(source, root, "media"), find_file(model, root, "models")
    card = inspect(build, model)
    folder.mkdir(parents=True, exist_ok=True)
    label_file = folder / "labels.txt"
    label_file.write_text("\n".join(card["labels"]) + "\n")
    Gst.init(None)
    print(f"{card['name']} ({card['task']}) looks at {source.name}:")
    classifier = Classifier(source, model, card, label_file)
    classifier.play()
    if classifier.error:
        print(f"demo: {classifier.error}")
        return 1
    label, frames = classifier.seen.most_common(1)[0]
    milliseconds = classifier.stats.get_value("average-us") / 1000
    print(f"\n  {label}: {frames} of {classifier.count} frames; {milliseconds:.2f} ms a frame in the network")
    return 0
