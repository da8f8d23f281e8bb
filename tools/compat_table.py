# SPDX-License-Identifier: LGPL-2.1-or-later
"""The table of docs/guide/nnstreamer-elements.md: every property and mode of NNStreamer's elements, and its state in Weir.

What NNStreamer has is in tools/nnstreamer-elements.txt, what Weir has in the pages that tools/gen-docs makes of the plug-in.
"""

import pathlib
import re

ROOT = pathlib.Path(__file__).resolve().parent.parent
FACTS = ROOT / "tools" / "nnstreamer-elements.txt"
PAGE = ROOT / "docs" / "guide" / "nnstreamer-elements.md"
TYPES = {"guint": "Unsigned Integer", "gint": "Integer", "gboolean": "Boolean", "gchararray": "String",
         "guint64": "Unsigned Integer64", "gint64": "Integer64", "gulong": "Unsigned Long",
         "GstPad": 'Object of type "GstPad"', "GstCaps": 'Caps'}
# What a user should know of a property beyond its type and values.
REMARKS = {
    "tensor_filter.sub-plugins": "lists the installed engines by Weir's names",
    "tensor_filter.framework": "accepts the names and aliases of both projects",
    "tensor_decoder.sub-plugins": "lists the installed decoders",
    "tensor_converter.sub-plugins": "lists the installed converters",
    "tensor_transform.acceleration": "both values give the same results, always with SIMD",
    "tensor_transform.transpose-rank-limit": "transpose takes any rank",
    "tensor_debug.output-method": "`filewrite` is accepted but has no effect, because no property sets the file",
}
# Mode words: (element, property, what it chooses) -> words and where in the tree each is, "" where that is the element itself.
DECODERS = ["direct_video", "image_labeling", "octet_stream", "bounding_boxes", "pose_estimation", "image_segment",
            "tensor_region", "flatbuf", "flexbuf", "protobuf", "python3", "custom-code"]
CONVERTERS = ["custom-code", "custom-script", "flatbuf", "flexbuf", "protobuf", "python3"]
FRAMEWORKS = ["custom", "custom-easy", "cpp", "python3", "lua", "tensorflow-lite", "tensorflow2-lite", "tensorflow1-lite",
              "onnxruntime", "pytorch", "tensorflow", "caffe2", "armnn", "openvino", "ncnn", "llamacpp", "llama2c", "executorch",
              "executorch-llama", "nnfw", "tvm", "tensorrt", "tensorrt10", "snpe", "qnn", "mxnet", "edgetpu", "mediapipe", "vivante",
              "deepview-rt", "movidius-ncsdk2", "trix-engine", "snap", "tizen-hal", "dali", "nntrainer"]
WORDS = {
    "tensor_transform mode": ("src/core/transform", ["dimchg", "typecast", "arithmetic", "transpose", "stand", "clamp", "padding"]),
    "tensor_mux, tensor_merge sync-mode": ("src/core/sync", ["nosync", "slowest", "basepad", "refresh"]),
    "tensor_merge mode": ("src/elements/tensor_merge", ["linear"]),
}


def nnstreamer():
    """Element -> (plug-in, {property: (type, flags, initial value, range)})."""
    found, properties = {}, None
    for line in FACTS.read_text(encoding="utf-8").splitlines():
        if line.startswith("#"):
            continue
        fields = line.split("|")
        if fields[0] == "element":
            properties = {}
            found[fields[1]] = (fields[2], properties)
        else:
            properties[fields[0]] = tuple(fields[1:5])
    return found


def weir(page):
    """Property -> (type and default, flags) of a page of docs/elements."""
    rows = re.findall(r"^\| `([a-z0-9-]+)` \| (.*?) \| ([^|]*) \| (?:[^|\\]|\\.)*\|$", page, re.MULTILINE)
    return {name: (kind, flags) for name, kind, flags in rows}


def initial(kind):
    found = re.search(r'Default: (?:(-?\d+), )?("[^"]*"|\S+)', kind)
    return (found.group(1) or found.group(2)).strip(";,") if found else None


def same_value(theirs, ours):
    if ours is None:
        return theirs in ("", "NULL")
    empty = {"NULL", '""', "null"}
    if theirs in empty and ours in empty:
        return True
    if ours.startswith("0x"):
        ours = str(int(ours, 16))
    return theirs.lower() == ours.lower()


def words_missing(values, kind):
    """Words of an enum or flags that Weir's does not have."""
    missing = []
    for part in values.split(", "):
        match = re.match(r"(-?\w+)=(.*?)(?: \(default\))?$", part)
        if match and not any(re.search(rf"\): {re.escape(word.strip())} ", kind) for word in match.group(2).split(" / ")):
            missing.append(match.group(2))
    return missing


def differences(fact, own):
    kind, flags, value, values = fact
    ours, our_flags = own
    found = []
    base = TYPES.get(kind)
    if base and not ours.startswith(base):
        found.append(f"type is {ours.split('.')[0]}")
    if not base and not ours.startswith(("Enum", "Flags")):
        found.append(f"type is {ours.split('.')[0]}")
    if "W" in flags and "writable" not in our_flags:
        found.append("read-only")
    if not value.count(",") and not same_value(value, initial(ours)):  # a list of names is of what is installed
        found.append(f"the default is {initial(ours)}, not {value}")
    if match := re.match(r"(-?\d+)\.\.(-?\d+)$", values):
        mine = re.search(r"Range: *(-?\d+) - *(-?\d+)", ours)
        if mine and mine.groups() != match.groups():
            found.append(f"the range is {mine.group(1)} to {mine.group(2)}, not {match.group(1)} to {match.group(2)}")
    elif missing := words_missing(values, ours):
        found.append("lacks " + ", ".join(missing))
    return found


def element_section(name, fact, page):
    plugin, properties = fact
    if page is None:
        return [f"## {name}", "", f"**Not implemented yet** (plug-in `{plugin}`). Its properties: "
                + ", ".join(f"`{p}`" for p in properties) + ".", ""]
    own = weir(page)
    out = [f"## {name}", "", "| property | state | remarks |", "|---|---|---|"]
    for prop, row in properties.items():
        found = ["not there"] if prop not in own else differences(row, own[prop])
        state = "same" if not found else "**missing**" if found == ["not there"] else "differs"
        remarks = [] if found == ["not there"] else found
        remarks += [REMARKS[f"{name}.{prop}"]] if REMARKS.get(f"{name}.{prop}") else []
        out.append(f"| `{prop}` | {state} | {'; '.join(remarks)} |")
    inherited = {"async", "blocksize", "enable-last-sample", "last-sample", "max-bitrate", "max-lateness", "processing-deadline", "qos",
                 "render-delay", "sync", "throttle-time", "ts-offset", "do-timestamp", "num-buffers", "typefind"}
    more = sorted(set(own) - set(properties) - inherited)
    out.append("")
    if more:
        out += ["Additional properties of Weir: " + ", ".join(f"`{p}`" for p in more) + ".", ""]
    return out


def source_text(folder):
    return "".join(p.read_text(encoding="utf-8", errors="replace") for p in sorted((ROOT / folder).rglob("*.cpp"))
                   if "_test" not in p.name)


def make_rows(words, there, absent="not implemented yet"):
    return [f"| `{word}` | {'supported' if word in there else absent} |" for word in words]


def engines():
    """Names and aliases of the engines that have a module here or are built in; from core's table and the tree."""
    known = re.findall(r'KnownEngine\{"([\w-]+)",\s*"([^"]*)"', (ROOT / "src/core/infer/module/known_engines.cpp").read_text())
    text = source_text("src/modules/engines") + source_text("src/core/custom")
    there = set()
    for name, aliases in known:
        if f'"{name}"' in text:
            there |= {name, *aliases.split(",")}
    return there


def modules(kind, builtin):
    return {p.name for p in (ROOT / "src/modules" / kind).iterdir() if p.is_dir()} | builtin


def page(pages):
    """`pages`: element -> text of its page."""
    out = ["# NNStreamer's elements in Weir, property by property", "",
           "Look up here whether Weir supports the elements, properties and modes that your NNStreamer pipeline uses. `same` means that the",
           "type, the default, the range and the enum values are those of NNStreamer 2.7. [Coming from NNStreamer](from-nnstreamer.md) explains",
           "the differences. `tools/gen-docs` generates this page from the plug-in.", ""]
    elements = nnstreamer()
    there = [name for name in elements if name in pages]
    out += [f"Weir implements {len(there)} of {len(elements)} elements. Not implemented yet: "
            + ", ".join(f"`{n}`" for n in elements if n not in pages) + ".", ""]
    for name, fact in elements.items():
        out += element_section(name, fact, pages.get(name))
    converter, decoder = source_text("src/elements/tensor_converter"), source_text("src/elements/tensor_decoder")
    out += ["## Modes", ""]
    for title, (folder, words) in WORDS.items():
        text = source_text(folder)
        out += [f"### {title}", "", "| value | state |", "|---|---|", *make_rows(words, {w for w in words if f'"{w}"' in text}), ""]
    decoders = modules("decoders", {w for w in ("custom-code",) if f'"{w}"' in decoder})
    decoders |= set(re.findall(r'decoder_table<\w+>\(\s*"(\w+)"', source_text("src/core/decoders")))
    out += ["### tensor_decoder mode", "", "| mode | state |", "|---|---|", *make_rows(DECODERS, decoders), ""]
    converters = modules("converters", {w for w in ("custom-code", "custom-script") if w in converter})
    out += ["### tensor_converter mode and converters", "", "| name | state |", "|---|---|", *make_rows(CONVERTERS, converters), ""]
    out += ["### tensor_filter framework", "", "| framework | state |", "|---|---|",
            *make_rows(FRAMEWORKS, engines(), "needs a sub-plugin that is built for NNStreamer"), ""]
    return "\n".join(out)
