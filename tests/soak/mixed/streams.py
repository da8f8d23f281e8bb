# SPDX-License-Identifier: LGPL-2.1-or-later
"""The 16 streams of the soak test, each with its processes, what happens to them, and the policy that says which frames may be lost.

A process is a line of words for the shell's PATH, or what stream_end.py runs:
  pipeline   the pipeline; its frames arrive at the tensor_sink `out`
  send       frames a second that it pushes into the appsrc `in`, numbered
  numbered   numbered frames arrive that another process sent; `add`: what the stream added to the numbers
  edits      methods of weir.Pipeline with their arguments, one of them every few seconds
  file       a file that has all frames that arrived; the pipeline has no `out`
  ends with  the error that a fault may end the pipeline with; it is started again
  command    runs of `weir run` with this pipeline, again and again
At the end the valve `gate` is closed downstream of a source that no process feeds, and what is in the pipeline arrives.
"""

import dataclasses
import pathlib

HERE = pathlib.Path(__file__).parent
NUMBERS = HERE / "slow_copy.py"
DIGITS = HERE.parent.parent.parent / "models" / "clock_digits.onnx"
STRIP = "video/x-raw,format=GRAY8,width=192,height=32,framerate=15/1"
READ_CLOCK = f"tensor_transform mode=typecast option=float32 ! tensor_filter name=digits is-updatable=true model={DIGITS}"
RATE = 20  # frames a second
FULL = "No space left|could not write|Could not write|disk is full|Error while writing"


@dataclasses.dataclass
class Stream:
    processes: dict
    # What happens: process and "kill", "stop" (SIGTERM), "stall" (SIGSTOP for seconds); "disk" is full for seconds.
    faults: list = dataclasses.field(default_factory=list)
    # Elements and their counters of lost frames: no other frame may be missing, except between a kill and the next frame.
    counted: list = dataclasses.field(default_factory=list)
    # The process that counts is never killed: it must count each missing frame, also those of a killed process.
    exact: bool = False
    # Without numbers: the elements that count the frames that come and go, and how many come for one that goes.
    through: tuple = ()
    # Frames may come twice, as the protocol says.
    repeats: bool = False


def isolated(policy, disk):
    return (f"appsrc name=in ! tensor_filter name=model model={NUMBERS} isolate=process on-crash={policy} isolate-timeout=2000 "
            f"crash-folder={disk} ! tensor_sink name=out")


def files(disk, frames):
    """Streams of files: read again and again by `weir run`, read in a loop, recorded to a disk that is full at times."""
    for number, picture in enumerate(frames):
        pathlib.Path(f"strip{number}.gray").write_bytes(picture)
    record = disk / "record.bin"
    return {
        "files": Stream({"run": {
            "command": "filesrc location={source} blocksize=512 ! application/octet-stream ! tensor_converter input-dim=64 "
                       f"input-type=int64 ! tensor_filter model={NUMBERS} ! tensor_decoder mode=octet_stream ! filesink location={{out}}",
            "report": str(disk / "report.html"), "frames": 500, "pause": 5, "ends with": FULL}}, [("", "disk")]),
        "loop": Stream({"loop": {
            "pipeline": f"multifilesrc location=strip%d.gray stop-index={len(frames) - 1} loop=true "
                        'caps="video/x-raw,format=(string)GRAY8,width=192,height=32,framerate=(fraction)15/1" ! valve name=gate ! '
                        f"tensor_converter name=first ! clocksync ! {READ_CLOCK} ! tensor_sink name=out"}}, through=("first", "out", 1)),
        "record": Stream({"record": {
            "pipeline": f"appsrc name=in max-bytes=10240 block=true ! tensor_filter model={NUMBERS} ! tensor_decoder mode=octet_stream ! "
                        f"filesink buffer-mode=unbuffered location={record}",
            "send": RATE, "file": str(record), "ends with": FULL}}, [("", "disk")]),
    }


def live(other_model):
    """Live streams: a model that is replaced, sound, a pipeline that is edited, a model that is too slow."""
    return {
        "reloads": Stream({"reloads": {
            "pipeline": f"videotestsrc is-live=true ! {STRIP} ! valve name=gate ! tensor_converter name=first ! {READ_CLOCK} ! tensor_sink name=out",
            "edits": [["set", "digits", "model", str(model)] for model in (DIGITS, other_model)]}}, through=("first", "out", 1)),
        "sound": Stream({"sound": {
            "pipeline": "audiotestsrc is-live=true samplesperbuffer=800 ! audio/x-raw,format=S16LE,rate=16000,channels=1 ! valve name=gate ! "
                        "tensor_converter frames-per-tensor=800 ! tensor_aggregator name=first frames-in=800 frames-out=1600 frames-dim=1 ! "
                        "tensor_transform mode=typecast option=float32 ! tensor_sink name=out"}}, through=("first", "out", 2)),
        "edits": Stream({"edits": {
            "pipeline": f"videotestsrc is-live=true ! {STRIP} ! valve name=gate ! tensor_converter name=first ! tee name=t "
                        "t. ! queue ! tensor_transform mode=arithmetic option=add:1 ! tensor_sink name=out async=false "
                        f"t. ! queue ! valve name=a ! {READ_CLOCK} ! fakesink async=false "
                        "t. ! queue ! valve name=b ! tensor_transform mode=typecast option=float32 ! s.sink_0 "
                        "t. ! queue ! tensor_transform mode=typecast option=float32 ! s.sink_1 "
                        "input-selector name=s sync-streams=false ! tensor_sink name=rest async=false emit-signal=false",
            "edits": [["open_valve", "a", True], ["open_valve", "a", False], ["open_valve", "b", True], ["open_valve", "b", False],
                      ["select", "s", "sink_0"], ["select", "s", "sink_1"], ["pause"], ["start"], ["start"], ["start"]]}},
            through=("first", "out", 1)),
        "busy": Stream({"busy": {
            "pipeline": f"appsrc name=in ! tensor_filter name=model model={NUMBERS} custom=80 when-busy=drop-new ! tensor_sink name=out",
            "send": RATE}}, counted=[("model", "dropped")], exact=True),
    }


def links(port, broker):
    """Streams between two processes, without and with a broker. `port` returns a free one."""
    edge, grpc = port(), port()
    local = pathlib.Path("local.stream").absolute()
    here = f"port={broker} pub-topic=soak/mqtt protocol=5 mqtt-qos=1"
    there = f"port={broker} sub-topic=soak/mqtt protocol=5 mqtt-qos=1 cleansession=false client-id=soak sub-timeout=9223372036854775807"
    hybrid = f"connect-type=HYBRID dest-host=127.0.0.1 dest-port={broker} topic=soak/hybrid"

    def pair(sink, source):
        return {"sender": {"pipeline": f"appsrc name=in max-bytes=10240 block=true ! {sink} name=net", "send": RATE,
                           "ends with": "the MQTT broker .* cannot be reached"},
                "receiver": {"pipeline": f"{source} name=net ! tensor_sink name=out async=false", "numbered": True}}

    both = [("sender", "kill"), ("receiver", "kill"), ("receiver", "stall"), ("sender", "stall")]
    found = {
        "edge": Stream(pair(f"edgesink port={edge} sync=false", f"edgesrc dest-port={edge} reconnect=true"), both[1:],
                       [("net", "missed"), ("net", "dropped")]),
        "local": Stream(pair(f"edgesink protocol=local path={local} wait-connection=true sync=false",
                             f"edgesrc protocol=local path={local} reconnect=true"), both, [("net", "dropped")]),
        "grpc": Stream(pair(f"tensor_sink_grpc port={grpc}", f"tensor_src_grpc port={grpc}"), both[1:],
                       [("net", "messages-dropped"), ("net", "messages-lost")]),
    }
    if broker:
        found["mqtt"] = Stream(pair(f"mqttsink {here}", f"mqttsrc {there}"), [("broker", "kill"), *both[:1], *both[2:]],
                               [("net", "dropped")], repeats=True)
        found["hybrid"] = Stream(pair(f"edgesink {hybrid} port=0 sync=false", f"edgesrc {hybrid}"), both[:1],
                                 [("net", "missed"), ("net", "dropped")])
    return found


def servers(port):
    """Streams to a query server and to `weir serve`."""
    query, oip = port(), port()
    return {
        "query": Stream({
            "server": {"pipeline": f"tensor_query_serversrc port={query} ! other/tensors,format=static,num_tensors=1,dimensions=(string)64,"
                                   "types=(string)int64,framerate=0/1 ! tensor_transform mode=arithmetic option=add:1 ! "
                                   "tensor_query_serversink async=false"},
            "client": {"pipeline": f"appsrc name=in ! tensor_query_client name=net port=0 dest-port={query} reconnect=true timeout=1000 ! "
                                   "tensor_sink name=out async=false", "send": RATE, "add": 1}},
            [("server", "kill"), ("server", "stall")], [("net", "dropped")], exact=True),
        "oip": Stream({
            "server": ["weir", "serve", "--listen", f"127.0.0.1:{oip}", f"numbers={NUMBERS}"],
            "client": {"pipeline": "appsrc name=in max-bytes=10240 block=true ! tensor_filter name=net framework=oip "
                                   f"model=grpc://127.0.0.1:{oip}/numbers custom=timeout-ms:1000 ! tensor_sink name=out", "send": RATE,
                       "ends with": "the inference server cannot be reached"}},
            [("server", "kill"), ("server", "stop"), ("server", "stall")], [("net", "dropped")], exact=True),
    }


def isolated_models(disk):
    """Models in processes of their own, which end with a frame or take too long."""
    return {
        "isolated": Stream({"wait": {"pipeline": isolated("wait", disk), "send": RATE}},
                           [("worker", "kill"), ("worker", "stall")], [("model", "dropped")], exact=True),
        "restarts": Stream({"restart": {"pipeline": isolated("restart", disk), "send": RATE}},
                           [("worker", "kill"), ("worker", "stall"), ("", "disk")], [("model", "dropped")], exact=True),
    }
