# SPDX-License-Identifier: LGPL-2.1-or-later
"""grpcio's client of a pipeline that serves models.

WEIR_INFERENCE_CLASSES is the folder with the classes that protoc makes of inference.proto.
"""

import os
import sys
import time

sys.path.insert(0, os.environ.get("WEIR_INFERENCE_CLASSES", ""))

# Before grpc, whose threads a child process would not have.
import grpc  # noqa: E402
import inference_pb2 as pb  # noqa: E402
import inference_pb2_grpc as service  # noqa: E402

from launched_pipeline import Gate, Pipeline  # noqa: E402, F401

TYPES = {"FP32": "<f4", "FP64": "<f8", "FP16": "<f2", "INT8": "<i1", "INT16": "<i2", "INT32": "<i4", "INT64": "<i8",
         "UINT8": "<u1", "UINT16": "<u2", "UINT32": "<u4", "UINT64": "<u8"}
CONTENTS = {"FP32": "fp32_contents", "FP64": "fp64_contents", "INT8": "int_contents", "INT16": "int_contents",
            "INT32": "int_contents", "INT64": "int64_contents", "UINT8": "uint_contents", "UINT16": "uint_contents",
            "UINT32": "uint_contents", "UINT64": "uint64_contents"}


class Client:
    def __init__(self, address, credentials=None, metadata=()):
        options = [("grpc.max_receive_message_length", -1), ("grpc.max_send_message_length", -1), ("grpc.enable_http_proxy", 0),
                   ("grpc.use_local_subchannel_pool", 1)]
        self.channel = (grpc.secure_channel(address, credentials, options) if credentials
                        else grpc.insecure_channel(address, options))
        self.stub = service.GRPCInferenceServiceStub(self.channel)
        self.metadata = metadata

    def close(self):
        self.channel.close()

    def call(self, method, request, timeout=30, **more):
        return getattr(self.stub, method)(request, timeout=timeout, metadata=self.metadata, wait_for_ready=False, **more)

    def infer(self, request, timeout=30, **more):
        return self.call("ModelInfer", request, timeout, **more)

    def connect(self):
        """Makes no call."""
        grpc.channel_ready_future(self.channel).result(60)

    def wait_until_ready(self, model):
        """Once the pipeline runs, its model is ready."""
        self.connect()
        end = time.monotonic() + 60
        while not self.call("ModelReady", pb.ModelReadyRequest(name=model)).ready:
            if time.monotonic() > end:
                raise AssertionError(f"the model {model} is not ready")
            time.sleep(0.01)


def request(model, array, datatype="FP32", typed=False, name="input", shape=None, **more):
    """A ModelInferRequest with one input."""
    out = pb.ModelInferRequest(model_name=model, **more)
    tensor = out.inputs.add(name=name, datatype=datatype, shape=list(array.shape) if shape is None else shape)
    if typed:
        getattr(tensor.contents, CONTENTS[datatype]).extend(array.flatten().tolist())
    else:
        out.raw_input_contents.append(array.tobytes())
    return out


def wait_until_done(calls, count):
    """Returns when `count` of the calls have ended."""
    end = time.monotonic() + 60
    while sum(call.done() for call in calls) < count:
        if time.monotonic() > end:
            raise AssertionError(f"{sum(call.done() for call in calls)} of {len(calls)} calls have ended, not {count}")
        time.sleep(0.01)


def ends_behind_gate(pipeline, gate, clients, message, refused):
    """How one call of each client ends. The first reaches the gate before the others begin, and `refused` end there."""
    for client in clients:
        client.connect()
    calls = [clients[0].stub.ModelInfer.future(message, timeout=60)]
    if pipeline.frames_at_gate(1) != 1:
        raise AssertionError("the first request did not reach the gate")
    calls += [client.stub.ModelInfer.future(message, timeout=60) for client in clients[1:]]
    wait_until_done(calls, refused)
    gate.open()
    return [status_of(call.result) for call in calls]


def status_of(call):
    """The code's name and the text with which a call fails; ("OK", response) if it does not."""
    try:
        return "OK", call()
    except grpc.RpcError as error:
        return error.code().name, error.details()
