#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""An inference server for tests, of Python's grpcio and the classes that protoc makes of inference.proto.

inference_server.py --classes FOLDER [OPTION...] [--port PORT]; prints `port PORT` when it listens, and at the end of its
input or at SIGTERM ends with a line `requests N`. The model `affine` answers y = 2 x + 1 in the type of x.
"""

import argparse
import concurrent.futures
import signal
import sys
import threading
import time

import grpc
import numpy

DTYPES = {"FP32": "<f4", "FP64": "<f8", "FP16": "<f2", "INT8": "<i1", "INT16": "<i2", "INT32": "<i4", "INT64": "<i8",
          "UINT8": "<u1", "UINT16": "<u2", "UINT32": "<u4", "UINT64": "<u8"}
TYPED = {"FP32": "fp32_contents", "FP64": "fp64_contents", "INT8": "int_contents", "INT16": "int_contents",
         "INT32": "int_contents", "INT64": "int64_contents", "UINT8": "uint_contents", "UINT16": "uint_contents",
         "UINT32": "uint_contents", "UINT64": "uint64_contents"}
BEHAVIOURS = ["right", "refuses-raw", "wrong-shape", "wrong-type", "short", "extra-raw", "damaged", "no-output", "error", "huge"]


def arguments():
    parser = argparse.ArgumentParser()
    parser.add_argument("--classes", required=True)
    parser.add_argument("--port", default="0")
    parser.add_argument("--address", default="127.0.0.1", help="or unix:PATH with --port empty")
    parser.add_argument("--type", default="FP32")
    parser.add_argument("--shape", default="-1,4")
    parser.add_argument("--delay", type=float, default=0, help="seconds of each request")
    parser.add_argument("--delays", default="", help="seconds of the requests in turn, repeated")
    parser.add_argument("--typed", action="store_true", help="answers typed contents")
    parser.add_argument("--behaviour", default="right", choices=BEHAVIOURS)
    parser.add_argument("--no-metadata", action="store_true")
    parser.add_argument("--away", default="", help="FIRST:COUNT: answers UNAVAILABLE to so many requests from the FIRST one, counted from 0")
    parser.add_argument("--print-times", action="store_true", help="prints `left SECONDS`, the time that each request has left")
    parser.add_argument("--times", type=float, metavar="AHEAD", help="knows weir_times, by a clock that is so many seconds ahead; "
                        "without it, a request with a parameter is refused")
    parser.add_argument("--token", default="")
    parser.add_argument("--cert", default="")
    parser.add_argument("--key", default="")
    parser.add_argument("--ca", default="", help="clients need a certificate of this authority")
    return parser.parse_args()


ARGS = arguments()
sys.path.insert(0, ARGS.classes)
import inference_pb2 as pb  # noqa: E402
import inference_pb2_grpc as service  # noqa: E402


class Server(service.GRPCInferenceServiceServicer):
    def __init__(self):
        self.lock = threading.Lock()
        self.requests = self.most = self.now = 0
        first, count = (int(part) for part in (ARGS.away or "0:0").split(":"))
        self.away = range(first, first + count)
        self.delays = [float(part) for part in ARGS.delays.split(",") if part] or [ARGS.delay]

    def check_token(self, context):
        if ARGS.token and ("authorization", "Bearer " + ARGS.token) not in context.invocation_metadata():
            context.abort(grpc.StatusCode.UNAUTHENTICATED, "a token is needed")

    def ServerLive(self, request, context):
        return pb.ServerLiveResponse(live=True)

    def ServerReady(self, request, context):
        return pb.ServerReadyResponse(ready=True)

    def ServerMetadata(self, request, context):
        extensions = ["other", "weir_times"] if ARGS.times is not None else ["other", "weir_times_2"]
        return pb.ServerMetadataResponse(name="test", version="1", extensions=extensions)

    def now_ns(self):
        return time.time_ns() + int(ARGS.times * 1e9)

    def ModelReady(self, request, context):
        return pb.ModelReadyResponse(ready=request.name == "affine")

    def ModelMetadata(self, request, context):
        if ARGS.no_metadata:
            context.abort(grpc.StatusCode.UNIMPLEMENTED, "no metadata here")
        self.check_token(context)
        if request.name != "affine":
            context.abort(grpc.StatusCode.NOT_FOUND, f"there is no model {request.name}")
        out = pb.ModelMetadataResponse(name="affine", versions=["1"], platform="test")
        shape = [int(part) for part in ARGS.shape.split(",")]
        out.inputs.add(name="x", datatype=ARGS.type, shape=shape)
        out.outputs.add(name="y", datatype=ARGS.type, shape=shape)
        return out

    def check_request(self, request, context):
        if request.model_name != "affine":
            context.abort(grpc.StatusCode.NOT_FOUND, f"there is no model {request.model_name}")
        if ARGS.times is None and request.parameters:
            context.abort(grpc.StatusCode.INVALID_ARGUMENT, f"unknown parameters: {list(request.parameters)}")
        if len(request.inputs) != 1 or request.inputs[0].name != "x" or request.inputs[0].datatype != ARGS.type:
            context.abort(grpc.StatusCode.INVALID_ARGUMENT, f"one input is needed, x of the type {ARGS.type}")
        size = numpy.dtype(DTYPES[ARGS.type]).itemsize if ARGS.type in DTYPES else 1
        if any(len(content) % size for content in request.raw_input_contents):
            context.abort(grpc.StatusCode.INVALID_ARGUMENT, "the contents end within an element")

    def ModelInfer(self, request, context):
        received = self.now_ns() if ARGS.times is not None else 0
        self.check_token(context)
        self.check_request(request, context)
        with self.lock:
            if ARGS.print_times:
                print(f"left {context.time_remaining():.3f}", flush=True)
            number = self.requests
            delay = self.delays[number % len(self.delays)]
            self.requests += 1
            self.now += 1
            self.most = max(self.most, self.now)
        time.sleep(delay)
        try:
            if number in self.away:
                context.abort(grpc.StatusCode.UNAVAILABLE, "not now")
            out = self.answer(request, context)
            if request.parameters["weir_times"].bool_param:
                for name, value in (("received_ns", received), ("queue_us", 1500), ("compute_us", 2500), ("answered_ns", self.now_ns())):
                    out.parameters["weir_" + name].int64_param = value
            return out
        finally:
            with self.lock:
                self.now -= 1

    def answer(self, request, context):
        if ARGS.behaviour == "error":
            context.abort(grpc.StatusCode.INTERNAL, "the model failed")
        if ARGS.behaviour == "refuses-raw" and request.raw_input_contents:
            context.abort(grpc.StatusCode.INVALID_ARGUMENT, "raw contents are not accepted")
        tensor = request.inputs[0]
        if ARGS.type == "BYTES":
            given = request.raw_input_contents[0] if request.raw_input_contents else None
            element = given[4:] if given is not None else tensor.contents.bytes_contents[0]
            if given is not None and int.from_bytes(given[:4], "little") != len(element):
                context.abort(grpc.StatusCode.INVALID_ARGUMENT, "the length of the element is wrong")
            reverse = element[::-1]
            out = pb.ModelInferResponse(model_name="affine", id=request.id)
            output = out.outputs.add(name="y", datatype="BYTES", shape=[1])
            if ARGS.typed:
                output.contents.bytes_contents.append(reverse)
            else:
                out.raw_output_contents.append(len(reverse).to_bytes(4, "little") + reverse)
            return out
        if request.raw_input_contents:
            x = numpy.frombuffer(request.raw_input_contents[0], DTYPES[tensor.datatype])
        else:
            x = numpy.array(getattr(tensor.contents, TYPED[tensor.datatype]), DTYPES[tensor.datatype])
        if x.size != int(numpy.prod(tensor.shape)):
            context.abort(grpc.StatusCode.INVALID_ARGUMENT, f"{x.size} elements for {list(tensor.shape)}")
        y = (x * 2 + 1).astype(x.dtype)
        return self.response(request, list(tensor.shape), y)

    def response(self, request, shape, y):
        behaviour = ARGS.behaviour
        out = pb.ModelInferResponse(model_name="affine", id=request.id)
        if behaviour == "no-output":
            return out
        if behaviour == "wrong-shape":
            shape = shape + [2]
        if behaviour == "huge":
            shape = [1 << 40] + shape[1:]
        output = out.outputs.add(name="y", datatype="INT32" if behaviour == "wrong-type" else ARGS.type, shape=shape)
        if ARGS.typed:
            getattr(output.contents, TYPED[ARGS.type]).extend(y.tolist())
            return out
        data = y.tobytes()
        out.raw_output_contents.append(data[:-1] if behaviour == "short" else data)
        if behaviour == "extra-raw":
            out.raw_output_contents.append(data)
        return out


def serialize(message):
    data = message.SerializeToString()
    return data[:-5] if ARGS.behaviour == "damaged" and isinstance(message, pb.ModelInferResponse) else data


def main():
    server = grpc.server(concurrent.futures.ThreadPoolExecutor(max_workers=16),
                         options=[("grpc.max_receive_message_length", -1), ("grpc.so_reuseport", 0)])
    mine = Server()
    handlers = {name: grpc.unary_unary_rpc_method_handler(getattr(mine, name),
                                                          getattr(pb, name + "Request").FromString, serialize)
                for name in ("ServerLive", "ServerReady", "ServerMetadata", "ModelReady", "ModelMetadata", "ModelInfer")}
    server.add_generic_rpc_handlers((grpc.method_handlers_generic_handler("inference.GRPCInferenceService", handlers),))
    address = ARGS.address if ARGS.address.startswith("unix:") else f"{ARGS.address}:{ARGS.port}"
    if ARGS.cert:
        with open(ARGS.cert, "rb") as cert, open(ARGS.key, "rb") as key:
            pair = (key.read(), cert.read())
        ca = open(ARGS.ca, "rb").read() if ARGS.ca else None
        port = server.add_secure_port(address, grpc.ssl_server_credentials([pair], ca, ca is not None))
    else:
        port = server.add_insecure_port(address)
    server.start()
    print(f"port {port}", flush=True)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(0))
    try:
        sys.stdin.read()
    finally:
        server.stop(0)
        print(f"requests {mine.requests} most {mine.most}", flush=True)


if __name__ == "__main__":
    main()
