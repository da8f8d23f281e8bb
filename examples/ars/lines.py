# SPDX-License-Identifier: LGPL-2.1-or-later
"""The pipelines of the example as text for gst-launch-1.0 and weir.Pipeline; README.md explains them.

LINES[variant] is a pipeline with places in braces that filled() fills.
"""

import pathlib

HERE = pathlib.Path(__file__).resolve().parent

EVENT_FRAMES = """filesrc location={recording}/events.frames blocksize=3072 ! application/octet-stream,framerate=30/1 !
  tensor_converter input-dim=64:48:1 input-type=uint8"""
EVENT_STREAM = """filesrc location={recording} blocksize=64 ! application/x-event-stream,framerate=30/1 !
  tensor_converter"""
EVENT_NETWORK = """tensor_aggregator frames-out=8 frames-flush=4 frames-dim=2 !
  tensor_transform mode=arithmetic option=typecast:float32,add:-128,mul:0.0625 ! queue !
  tensor_filter framework=custom model={build}/libars-event-network.so custom=weights:{networks}/event_network.f32"""
VOTE = """tensor_aggregator frames-out=6 frames-flush=1 frames-dim=1 !
  tensor_filter framework=custom model={build}/libars-vote.so"""
SEQUENCE_NETWORK = """tensor_aggregator frames-out=12 frames-flush=3 frames-dim=1 ! queue !
  tensor_filter framework=custom model={build}/libars-sequence-network.so custom=weights:{networks}/sequence_network.f16"""
RADIO = """filesrc location={{recording}}/radio{0}.frames blocksize=128 ! application/octet-stream,framerate=25/1 !
  tensor_converter input-dim=32:1 input-type=float32 ! tensor_aggregator frames-out=75 frames-flush=25 frames-dim=1 !
  tensor_transform mode=stand option=default ! merge.sink_{0}"""
RADIO_NETWORK = """tensor_merge name=merge option=2 sync-mode=slowest ! queue !
  tensor_filter framework=onnxruntime model={networks}/radio_network.onnx custom=NumThreads:1"""
RADIOS = " ".join((RADIO.format(0), RADIO.format(1)))
ACTIVITY = "tensor_decoder mode=image_labeling option1={activities} ! {sink}"

A = " ! ".join((EVENT_NETWORK, VOTE, ACTIVITY))
LINES = {
    "a": " ! ".join((EVENT_FRAMES, A)),
    "a-recorded": " ! ".join((EVENT_STREAM, A)),
    "b": " ! ".join((EVENT_FRAMES, EVENT_NETWORK, SEQUENCE_NETWORK, ACTIVITY)),
    "c": f"{RADIO_NETWORK} ! {ACTIVITY} {RADIOS}",
    "bc": " ".join((" ! ".join((EVENT_FRAMES, EVENT_NETWORK, SEQUENCE_NETWORK, "mux.sink_0")), RADIOS,
                    " ! ".join((RADIO_NETWORK, "mux.sink_1")),
                    " ! ".join(("tensor_mux name=mux sync-mode=slowest",
                                "tensor_filter framework=custom model={build}/libars-vote.so custom=inputs:2", ACTIVITY)))),
}


def with_workers(line, workers):
    """The line with so many frames at once in the event network and the radio network; the LSTM takes much less time."""
    for model in ("libars-event-network.so", "radio_network.onnx"):
        line = line.replace(f"{model} ", f"{model} workers={workers} ")
    return line


def filled(line, recording, build, sink, example=HERE):
    """The line on one line, with its places filled; `build` is the folder of the whole build."""
    return " ".join(line.format(recording=recording, build=f"{build}/examples/ars", networks=f"{example}/networks",
                                activities=f"{example}/activities.txt", sink=sink).split())
