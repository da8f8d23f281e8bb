#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Pipelines that tensor_query_serversrc and tensor_query_serversink serve, with Python's grpcio as their client."""

import concurrent.futures
import os
import pathlib
import re
import subprocess
import tempfile
import time
import unittest

import grpc
import numpy as np

import http2_peer
import tap_runner
from built_modules import has_engine
from served_pipeline import CONTENTS, TYPES, Client, Gate, Pipeline, pb, request, status_of, wait_until_done

SOURCE = pathlib.Path(os.environ["WEIR_SOURCE"])
FLOATS = "caps=other/tensor,dimension=(string)4:1,type=(string)float32,framerate=0/1"
INFER = "/inference.GRPCInferenceService/ModelInfer"
AFFINE = "tensor_transform mode=arithmetic option=mul:2,add:1"
X = np.array([[1.5, -2, 0, 1e6]], np.float32)


def source(options="", caps=FLOATS):
    return f"tensor_query_serversrc protocol=oip port=0 {options} {caps}"


class Served(unittest.TestCase):
    def serve(self, text, ports=1, gate=None):
        pipeline = Pipeline(text, ports, gate)
        self.addCleanup(pipeline.stop)
        self.assertTrue(pipeline.port, "".join(pipeline.lines))
        return pipeline

    def client(self, pipeline, model="affine", **more):
        client = Client(f"127.0.0.1:{pipeline.port}", **more)
        self.addCleanup(client.close)
        if model:
            client.wait_until_ready(model)
        return client

    def affine(self, between="", options=""):
        pipeline = self.serve(f"{source('model-name=affine ' + options)} ! {between} {AFFINE} ! tensor_query_serversink")
        return pipeline, self.client(pipeline)

    def gated(self, options=""):
        """The same, and a gate that holds the requests in the pipeline."""
        gate = Gate(self)
        pipeline = self.serve(f"{source('model-name=affine ' + options)} ! {gate.text} {AFFINE} ! tensor_query_serversink", gate=gate)
        return pipeline, self.client(pipeline), gate

    def ended_after(self, pipeline):
        pipeline.interrupt()
        return self.ended(pipeline)

    def ended(self, pipeline):
        """What became of the requests, from the log of the source's end."""
        counts = pipeline.wait_for(r"requests: (\d+) received = (\d+) answered \+ (\d+) refused \+ (\d+) expired \+ (\d+) aborted")
        self.assertEqual(len(counts), 1, "".join(pipeline.lines))
        names = ("received", "answered", "refused", "expired", "aborted")
        out = dict(zip(names, map(int, counts[0])))
        self.assertEqual(out["received"], sum(out[name] for name in names[1:]))
        return out


class WithoutGrpc(unittest.TestCase):
    def test_the_error_names_the_missing_plugin(self):
        plugins = pathlib.Path(os.environ["WEIR_BUILD"]) / "src" / "plugin"
        with tempfile.TemporaryDirectory() as folder:
            (pathlib.Path(folder) / "libgstweiredge.so").symlink_to(plugins / "libgstweiredge.so")
            played = subprocess.run(
                ["gst-launch-1.0", "tensor_query_serversrc", "protocol=oip", "port=0", "!", "fakesink"],
                env={**os.environ, "GST_PLUGIN_PATH": folder, "GST_REGISTRY": folder + "/registry.bin"},
                capture_output=True, text=True, timeout=60)
        self.assertNotEqual(played.returncode, 0)
        self.assertIn("WEIR-3007: the plug-in weirnet, which serves the Open Inference Protocol, is not installed", played.stderr)
        self.assertIn("fix: apt-get install libgrpc++-dev", played.stderr)


class Responses(Served):
    def test_a_request_is_answered_by_the_pipeline(self):
        pipeline, client = self.affine()
        response = client.infer(request("affine", X, id="seven"))
        self.assertEqual((response.model_name, response.model_version, response.id), ("affine", "1", "seven"))
        output, = response.outputs
        self.assertEqual((output.name, output.datatype, list(output.shape)), ("output", "FP32", [1, 4]))
        np.testing.assert_array_equal(np.frombuffer(response.raw_output_contents[0], np.float32), (2 * X + 1)[0])
        pipeline.stop()
        self.assertEqual(self.ended(pipeline), dict(received=1, answered=1, refused=0, expired=0, aborted=0))

    def test_every_type_is_read_raw_and_typed(self):
        for datatype, numpy_type in TYPES.items():
            values = np.array([[0, 1, 100, 7]], numpy_type)
            if numpy_type[1] != "u":
                values[0, 1] = -1
            name = np.dtype(numpy_type).name
            caps = f"caps=other/tensor,dimension=(string)4:1,type=(string){name},framerate=0/1"
            pipeline = self.serve(f"{source('model-name=same', caps)} ! tensor_query_serversink")
            client = self.client(pipeline, "same")
            for typed in ([False, True] if datatype in CONTENTS else [False]):
                with self.subTest(datatype, typed=typed):
                    response = client.infer(request("same", values, datatype, typed))
                    self.assertEqual(response.raw_output_contents[0], values.tobytes())
                    self.assertEqual(response.outputs[0].datatype, datatype)
            if CONTENTS.get(datatype) in ("int_contents", "uint_contents") and numpy_type[2] < "4":
                limits = np.iinfo(numpy_type)
                for beyond in {limits.min - 1, limits.max + 1} - {-1}:
                    typed = request("same", values, datatype, True)
                    getattr(typed.inputs[0].contents, CONTENTS[datatype])[2] = beyond
                    code, text = status_of(lambda: client.infer(typed))
                    self.assertEqual(code, "INVALID_ARGUMENT")
                    self.assertIn(f"offered: the number {beyond} in input {datatype} [1,4]\n  needed: numbers from {limits.min} to {limits.max}", text)
            if datatype == "FP16":
                typed = request("same", values, "FP16")
                del typed.raw_input_contents[:]
                typed.inputs[0].contents.fp32_contents.extend([1, 2, 3, 4])
                self.assertEqual(status_of(lambda: client.infer(typed))[0], "INVALID_ARGUMENT")
            pipeline.stop()

    def test_outer_ones_may_be_added_or_left_out(self):
        _, client = self.affine()
        for shape in ([4], [1, 4], [1, 1, 4]):
            response = client.infer(request("affine", X, shape=shape))
            np.testing.assert_array_equal(np.frombuffer(response.raw_output_contents[0], np.float32), (2 * X + 1)[0])

    def test_several_inputs_are_matched_by_their_names(self):
        caps = "caps=other/tensors,format=static,num_tensors=2,dimensions=(string)2,types=(string)uint8,framerate=0/1"
        caps = caps.replace("(string)2,", "(string)2.3,").replace("(string)uint8", "(string)uint8.int16")
        pipeline = self.serve(f"{source('model-name=two', caps)} ! tensor_query_serversink")
        client = self.client(pipeline, "two")
        one, other = np.array([1, 2], np.uint8), np.array([-1, 5, 7], np.int16)
        wanted = pb.ModelInferRequest(model_name="two")
        wanted.inputs.add(name="input_1", datatype="INT16", shape=[3])
        wanted.inputs.add(name="input_0", datatype="UINT8", shape=[2])
        wanted.raw_input_contents.extend([other.tobytes(), one.tobytes()])
        self.assertEqual(list(client.infer(wanted).raw_output_contents), [one.tobytes(), other.tobytes()])
        wanted.outputs.add(name="output_1")
        response = client.infer(wanted)
        self.assertEqual([output.name for output in response.outputs], ["output_1"])
        self.assertEqual(list(response.raw_output_contents), [other.tobytes()])
        wanted.outputs.add(name="elsewhere")
        code, text = status_of(lambda: client.infer(wanted))
        self.assertEqual(code, "INVALID_ARGUMENT")
        self.assertIn("offered: a request for the output elsewhere\n  needed: output_0 UINT8 [2], output_1 INT16 [3]", text)

    def test_several_sources_of_one_address_are_several_models(self):
        # The second source takes the port of the first, which a free port cannot be beforehand.
        first = self.serve(f"{source('model-name=first')} ! tensor_query_serversink")
        port = first.port
        first.stop()
        at = f"port={port}"
        pipeline = self.serve(
            f"{source('model-name=first id=1').replace('port=0', at)} ! tensor_query_serversink id=1 "
            f"{source('model-name=second id=2').replace('port=0', at)} ! {AFFINE} ! tensor_query_serversink id=2", 2)
        client = self.client(pipeline, "first")
        client.wait_until_ready("second")
        self.assertEqual(client.infer(request("first", X)).raw_output_contents[0], X.tobytes())
        self.assertEqual(client.infer(request("second", X)).raw_output_contents[0], (2 * X + 1).tobytes())

    def test_bytes_are_one_frame_of_a_stream_without_tensors(self):
        pipeline = self.serve(f"{source('model-name=text', 'caps=text/x-raw,format=utf8')} ! tensor_query_serversink")
        client = self.client(pipeline, "text")
        described = client.call("ModelMetadata", pb.ModelMetadataRequest(name="text"))
        self.assertEqual([(t.name, t.datatype, list(t.shape)) for t in (*described.inputs, *described.outputs)],
                         [("input", "BYTES", [1]), ("output", "BYTES", [1])])
        for text in (b"grape", "größer".encode(), bytes(range(256)) * 1000):
            raw = pb.ModelInferRequest(model_name="text")
            raw.inputs.add(name="input", datatype="BYTES", shape=[1])
            typed = pb.ModelInferRequest()
            typed.CopyFrom(raw)
            raw.raw_input_contents.append(len(text).to_bytes(4, "little") + text)
            typed.inputs[0].contents.bytes_contents.append(text)
            for asked in (raw, typed):
                self.assertEqual(client.infer(asked).raw_output_contents[0], len(text).to_bytes(4, "little") + text)
        empty = pb.ModelInferRequest(model_name="text")
        empty.inputs.add(name="input", datatype="BYTES", shape=[1]).contents.bytes_contents.append(b"")
        code, text = status_of(lambda: client.infer(empty))
        self.assertEqual(code, "INVALID_ARGUMENT")
        self.assertIn("the element of bytes is empty\n  needed: one byte or more", text)
        self.assertEqual(self.ended_after(pipeline), {"received": 7, "answered": 6, "refused": 1, "expired": 0, "aborted": 0})

    def test_a_pipeline_whose_caps_come_with_the_first_request_is_ready_and_described(self):
        picture = subprocess.run(["gst-launch-1.0", "-q", "videotestsrc", "num-buffers=1", "!", "video/x-raw,width=16,height=8", "!", "jpegenc", "!", "fdsink"],
                                 capture_output=True, timeout=60, check=True).stdout
        scaled = "videoscale ! tensor_converter ! other/tensors,format=static,num_tensors=1,dimensions=(string)3:4:2:1,types=(string)uint8"
        in_bytes = f"{scaled} ! tensor_decoder mode=octet_stream"
        rows = f"{in_bytes} ! tensor_converter input-dim=6:4 input-type=uint8 ! tensor_transform mode=typecast option=float32 ! tensor_decoder"
        cases = (("known", f"{scaled} ! tensor_transform mode=typecast option=float32", [("output", "FP32", [1, 2, 4, 3])], 96),
                 ("bytes", in_bytes, [("output", "BYTES", [1])], 4 + 24),
                 ("converted", f"{scaled} ! tensor_decoder mode=direct_video ! tensor_converter", [("output", "UINT8", [1, 2, 4, 3])], 24),
                 ("results", f"{rows} mode=detection custom=head:yolov10,input:16:8", [("output", "FP32", [-1, 9])], None),
                 ("open", "tensor_converter", [], 3 * 16 * 8))
        for name, between, described, size in cases:
            pipeline = self.serve(f"{source(f'model-name={name}', 'caps=image/jpeg')} ! jpegdec ! videoconvert ! video/x-raw,format=RGB ! {between} ! "
                                  "tensor_query_serversink")
            client = self.client(pipeline, name)
            metadata = client.call("ModelMetadata", pb.ModelMetadataRequest(name=name))
            found = [(t.name, t.datatype, list(t.shape)) for t in metadata.outputs]
            self.assertEqual(found, described, name)
            asked = pb.ModelInferRequest(model_name=name)
            asked.inputs.add(name="input", datatype="BYTES", shape=[1]).contents.bytes_contents.append(picture)
            response = client.infer(asked)
            answered = [(t.name, t.datatype, list(t.shape)) for t in response.outputs]
            if size is None:
                self.assertEqual([(n, t, [-1, *shape[1:]]) for n, t, shape in answered], described, name)
            else:
                self.assertEqual(len(response.raw_output_contents[0]), size, name)
            after = client.call("ModelMetadata", pb.ModelMetadataRequest(name=name))
            self.assertEqual([(t.name, t.datatype, list(t.shape)) for t in after.outputs], answered if size else described, name)

    def test_results_of_an_open_type_are_described_by_each_response(self):
        """The caps do not say how wide the numbers of a class map are."""
        caps = "caps=other/tensors,format=static,num_tensors=1,dimensions=(string)3:8:8:1,types=(string)float32,framerate=0/1"
        pipeline = self.serve(f"{source('model-name=map', caps)} ! tensor_decoder mode=segmentation custom=head:deeplab,input:8:8 ! tensor_query_serversink")
        client = self.client(pipeline, "map")
        for _ in range(2):
            self.assertEqual(list(client.call("ModelMetadata", pb.ModelMetadataRequest(name="map")).outputs), [])
            outputs = client.infer(request("map", np.zeros((1, 8, 8, 3), np.float32))).outputs
            self.assertIn(("UINT16", [8, 8]), [(t.datatype, list(t.shape)) for t in outputs])

    def test_bytes_are_one_flexible_tensor(self):
        caps = "caps=other/tensors,format=flexible,framerate=0/1"
        line = "tensor_transform mode=typecast option=float32 ! tensor_transform mode=arithmetic option=mul:2"
        pipeline = self.serve(f"{source('model-name=twice', caps)} ! {line} ! tensor_query_serversink")
        client = self.client(pipeline, "twice")
        for size in (1, 5, 4096):
            values = np.arange(size, dtype=np.uint8)
            asked = pb.ModelInferRequest(model_name="twice")
            asked.inputs.add(name="input", datatype="BYTES", shape=[1]).contents.bytes_contents.append(values.tobytes())
            response = client.infer(asked)
            self.assertEqual((response.outputs[0].datatype, list(response.outputs[0].shape)), ("FP32", [size]))
            self.assertEqual(response.raw_output_contents[0], (2 * values.astype(np.float32)).tobytes())

    # A request in which nothing is found gets an answer, and so do the requests after it.
    @unittest.skipUnless(has_engine("python3"), "the engine python3 is not built")
    def test_outputs_have_as_many_rows_as_the_model_finds(self):
        with tempfile.TemporaryDirectory() as folder:
            script = pathlib.Path(folder, "found.py")
            script.write_text("import numpy as np\nfrom weir import TensorShape\n"
                              "class CustomFilter:\n"
                              "    def setInputDim(self, dims):\n        return [TensorShape([2, 1], np.float32)]\n"
                              "    def invoke(self, arrays):\n        rows = arrays[0].reshape(-1, 2)\n        return [rows[rows[:, 0] > 0]]\n")
            pipeline = self.serve(f"{source('model-name=found')} ! tensor_filter model={script} invoke-dynamic=true outputname=rows ! tensor_query_serversink")
            client = self.client(pipeline, "found")
            described = client.call("ModelMetadata", pb.ModelMetadataRequest(name="found"))
            self.assertEqual([(o.name, o.datatype, list(o.shape)) for o in described.outputs], [("rows", "FP32", [-1, 2])])
            for values, rows in (([1, 2, 3, 4], [[1, 2], [3, 4]]), ([0, 2, -3, 4], []), ([0, 2, 5, 6], [[5, 6]])):
                response = client.infer(request("found", np.array([values], np.float32)))
                self.assertEqual((response.outputs[0].name, list(response.outputs[0].shape)), ("rows", [len(rows), 2]))
                self.assertEqual(response.raw_output_contents[0], np.array(rows, np.float32).tobytes())

    @unittest.skipUnless(has_engine("python3"), "the engine python3 is not built")
    def test_tensors_have_the_names_of_the_filter(self):
        with tempfile.TemporaryDirectory() as folder:
            script = pathlib.Path(folder, "same.py")
            script.write_text("class CustomFilter:\n"
                              "    def setInputDim(self, dims):\n        return dims\n"
                              "    def invoke(self, inputs):\n        return inputs\n")
            filter_ = f"tensor_filter framework=python3 model={script} inputname=samples outputname=scores"
            pipeline = self.serve(f"{source('model-name=named')} ! {filter_} ! tensor_transform mode=arithmetic option=mul:2 ! "
                                  "tensor_query_serversink")
            client = self.client(pipeline, "named")
            response = client.infer(request("named", X, name="samples"))
            self.assertEqual((response.outputs[0].name, response.raw_output_contents[0]), ("scores", (2 * X).tobytes()))

    def test_the_lines_of_the_documents_serve(self):
        for element in ("tensor_query_serversrc", "tensor_query_serversink"):
            text = (SOURCE / "src/edge" / element / "README.md").read_text()
            line, = re.findall(r"^gst-launch-1.0 (.* model-name=affine .*)$", text, re.MULTILINE)
            pipeline = self.serve(line.replace("port=8001", "port=0"))
            response = self.client(pipeline).infer(request("affine", X))
            self.assertEqual(response.raw_output_contents[0], (2 * X + 1).tobytes())

    @unittest.skipUnless(has_engine("oip"), "the engine oip is not built")
    def test_the_engine_oip_is_a_client(self):
        server, _ = self.affine()
        with tempfile.TemporaryDirectory() as folder:
            frames = np.random.default_rng(1).normal(size=(50, 4)).astype(np.float32)
            pathlib.Path(folder, "in").write_bytes(frames.tobytes())
            line = (f"filesrc location={folder}/in blocksize=16 ! application/octet-stream,framerate=30/1 ! "
                    "tensor_converter input-dim=4:1 input-type=float32 ! "
                    f"tensor_filter framework=oip model=grpc://127.0.0.1:{server.port}/affine workers=4 ! "
                    f"filesink async=false location={folder}/out")
            done = subprocess.run(["gst-launch-1.0", *line.split()], capture_output=True, text=True, timeout=60, stdin=subprocess.DEVNULL)
            self.assertEqual(done.returncode, 0, done.stderr)
            np.testing.assert_array_equal(np.fromfile(f"{folder}/out", np.float32).reshape(-1, 4), frames * 2 + 1)
        server.stop()
        self.assertEqual(self.ended(server), dict(received=50, answered=50, refused=0, expired=0, aborted=0))


class Descriptions(Served):
    def test_the_server_describes_itself_and_its_models(self):
        _, client = self.affine(options="model-version=3")
        self.assertTrue(client.call("ServerLive", pb.ServerLiveRequest()).live)
        self.assertTrue(client.call("ServerReady", pb.ServerReadyRequest()).ready)
        server = client.call("ServerMetadata", pb.ServerMetadataRequest())
        self.assertEqual(server.name, "weir")
        self.assertIn("weir_keepalive", server.extensions)
        model = client.call("ModelMetadata", pb.ModelMetadataRequest(name="affine", version="3"))
        self.assertEqual((model.name, list(model.versions), model.platform), ("affine", ["3"], "weir"))
        self.assertEqual([(t.name, t.datatype, list(t.shape)) for t in model.inputs], [("input", "FP32", [1, 4])])
        self.assertEqual([(t.name, t.datatype, list(t.shape)) for t in model.outputs], [("output", "FP32", [1, 4])])

    def test_health_is_reported_by_the_service_of_grpc(self):
        _, client = self.affine()
        check = client.channel.unary_unary("/grpc.health.v1.Health/Check")
        for service in (b"", b"inference.GRPCInferenceService", b"affine"):
            asked = b"\x0a" + bytes([len(service)]) + service
            self.assertEqual(check(asked, timeout=30), b"\x08\x01", service)
        self.assertEqual(status_of(lambda: check(b"\x0a\x01x", timeout=30)), ("NOT_FOUND", "there is no service x here"))

    def test_statistics_add_up(self):
        _, client = self.affine("identity sleep-time=20000 !")
        for _ in range(3):
            client.infer(request("affine", X))
        status_of(lambda: client.infer(request("affine", X, "INT32")))
        model, = client.call("ModelStatistics", pb.ModelStatisticsRequest(name="affine")).model_stats
        self.assertEqual((model.name, model.inference_count, model.execution_count), ("affine", 3, 3))
        times = model.inference_stats
        self.assertEqual((times.success.count, times.queue.count, times.compute_infer.count), (3, 3, 3))
        self.assertGreaterEqual(times.compute_infer.ns, 3 * 20_000_000)
        parts = times.queue.ns + times.compute_input.ns + times.compute_infer.ns + times.compute_output.ns
        self.assertAlmostEqual(times.success.ns, parts, delta=1e6)
        self.assertLess(abs(model.last_inference / 1000 - time.time()), 60)

    def test_times_are_answered_to_those_who_ask(self):
        _, client = self.affine("identity sleep-time=20000 !")
        message = request("affine", X)
        self.assertEqual(dict(client.infer(message).parameters), {})
        message.parameters["weir_times"].bool_param = False
        message.parameters["other"].string_param = "weir_times"
        self.assertEqual(dict(client.infer(message).parameters), {})
        message.parameters["weir_times"].bool_param = True
        sent = time.time_ns()
        calls = [client.stub.ModelInfer.future(message, timeout=30) for _ in range(2)]
        responses = [call.result().parameters for call in calls]
        arrived = time.time_ns()
        for response in responses:
            self.assertEqual({response[name].WhichOneof("parameter_choice") for name in response}, {"int64_param"})
        numbers = [{name: response[name].int64_param for name in response} for response in responses]
        for times in numbers:
            self.assertEqual(sorted(times), ["weir_answered_ns", "weir_compute_us", "weir_queue_us", "weir_received_ns"])
            self.assertTrue(sent <= times["weir_received_ns"] < times["weir_answered_ns"] <= arrived, (sent, times, arrived))
            self.assertGreaterEqual(times["weir_compute_us"], 20_000)
            whole = (times["weir_answered_ns"] - times["weir_received_ns"]) / 1000
            self.assertLessEqual(times["weir_compute_us"] + times["weir_queue_us"], whole + 2)

    def test_the_trace_of_a_request_comes_back(self):
        _, client = self.affine()
        trace = "00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01"
        _, call = client.stub.ModelInfer.with_call(request("affine", X), timeout=30, metadata=[("traceparent", trace)])
        self.assertIn(("traceparent", trace), call.trailing_metadata())


class Refusals(Served):
    def refused(self, client, message, code="INVALID_ARGUMENT"):
        found, text = status_of(lambda: client.infer(message))
        self.assertEqual(found, code, text)
        return text

    def test_what_does_not_fit_is_refused_with_both_sides(self):
        pipeline, client = self.affine()
        text = self.refused(client, request("affine", X, shape=[1, 5]))
        self.assertIn("WEIR-2001: the request does not fit the model affine\n  offered: input FP32 [1,5]\n"
                      "  needed: input FP32 [1,4]", text)
        self.assertIn("offered: input INT32 [1,4]", self.refused(client, request("affine", X, "INT32")))
        self.assertIn("offered: no input with the name input\n  needed: input FP32 [1,4]", self.refused(client, request("affine", X, name="x")))
        self.assertIn("offered: 12 bytes for input FP32 [1,4]\n  needed: 16 bytes",
                      self.refused(client, request("affine", X[:, :3], shape=[1, 4])))
        self.assertIn("offered: 0 inputs\n  needed: 1: input FP32 [1,4]", self.refused(client, pb.ModelInferRequest(model_name="affine")))
        self.assertIn("a wrong number of elements in the typed contents of input FP32 [1,4]",
                      self.refused(client, request("affine", X[:, :3], typed=True, shape=[1, 4])))
        both = request("affine", X, typed=True)
        both.raw_input_contents.append(X.tobytes())
        self.assertIn("offered: raw contents for all inputs, and typed contents for", self.refused(client, both))
        more = request("affine", X)
        more.raw_input_contents.append(X.tobytes())
        self.assertIn("offered: 2 raw contents for 1 inputs", self.refused(client, more))
        self.assertIn("there is no model other here; this server has: affine version 1",
                      self.refused(client, request("other", X), "NOT_FOUND"))
        self.assertIn("no model affine version 2", self.refused(client, request("affine", X, model_version="2"), "NOT_FOUND"))
        self.assertEqual(client.infer(request("affine", X)).raw_output_contents[0], (2 * X + 1).tobytes())
        pipeline.stop()
        self.assertEqual(self.ended(pipeline), dict(received=7, answered=1, refused=6, expired=0, aborted=0))

    def test_damaged_messages_are_refused(self):
        _, client = self.affine()
        infer = client.channel.unary_unary("/inference.GRPCInferenceService/ModelInfer")
        message = request("affine", X).SerializeToString()
        for damaged in (message[:-3], b"\xff" * 40, b"\x2a\x05\x1a\x02\xff\xff", message.replace(b"FP32", b"BF16")):
            self.assertEqual(status_of(lambda: infer(damaged, timeout=30))[0], "INVALID_ARGUMENT", damaged)
        self.assertEqual(status_of(lambda: infer(b"", timeout=30))[0], "NOT_FOUND")

    def test_unknown_methods_are_unimplemented(self):
        _, client = self.affine()
        for method in ("/inference.GRPCInferenceService/ModelStreamInfer", "/other.Service/Method"):
            call = client.channel.unary_unary(method)
            self.assertEqual(status_of(lambda: call(b"", timeout=30)), ("UNIMPLEMENTED", f"there is no method {method} here"))

    def test_a_message_beyond_the_limit_is_refused(self):
        _, client = self.affine(options="max-message=4096")
        code, text = status_of(lambda: client.infer(request("affine", np.zeros((1, 2048), np.float32))))
        self.assertEqual(code, "RESOURCE_EXHAUSTED", text)
        self.assertIn("4096", text)

    def test_a_full_queue_refuses_at_once(self):
        pipeline, client, gate = self.gated("queue=1")
        first = client.stub.ModelInfer.future(request("affine", X), timeout=60)
        self.assertEqual(pipeline.frames_at_gate(1), 1)
        calls = [client.stub.ModelInfer.future(request("affine", X), timeout=60) for _ in range(5)]
        wait_until_done(calls, 4)
        gate.open()
        ended = [status_of(call.result) for call in [first, *calls]]
        codes = [code for code, _ in ended]
        self.assertEqual(sorted(codes), ["OK"] * 2 + ["RESOURCE_EXHAUSTED"] * 4)
        self.assertEqual({text for code, text in ended if code != "OK"}, {"1 requests wait for the model affine (queue)"})
        pipeline.stop()
        self.assertEqual(self.ended(pipeline), dict(received=6, answered=2, refused=4, expired=0, aborted=0))

    def test_a_connection_has_no_more_requests_than_allowed(self):
        _, client, gate = self.gated("max-requests=2")
        calls = [client.stub.ModelInfer.future(request("affine", X), timeout=60) for _ in range(4)]
        wait_until_done(calls, 2)
        gate.open()
        codes = sorted(status_of(call.result)[0] for call in calls)
        self.assertEqual(codes, ["OK", "OK", "RESOURCE_EXHAUSTED", "RESOURCE_EXHAUSTED"])


class Endings(Served):
    def test_a_dropped_frame_ends_its_request(self):
        pipeline = self.serve(f"{source('model-name=shut')} ! {AFFINE} ! identity name=gate drop-probability=1 ! tensor_query_serversink")
        client = self.client(pipeline, "shut")
        self.assertEqual(status_of(lambda: client.infer(request("shut", X))), ("ABORTED", "dropped by gate"))
        pipeline.stop()
        self.assertEqual(self.ended(pipeline), dict(received=1, answered=0, refused=0, expired=0, aborted=1))

    def test_a_request_that_leaves_by_another_sink_is_dropped(self):
        pipeline = self.serve(f"{source('model-name=lost')} ! {AFFINE} ! fakesink name=elsewhere sync=false enable-last-sample=false")
        client = self.client(pipeline, None)
        grpc.channel_ready_future(client.channel).result(30)
        code, text = status_of(lambda: client.infer(request("lost", X)))
        self.assertEqual((code, text), ("ABORTED", "dropped by elsewhere"))

    def test_an_expired_request_is_not_run(self):
        pipeline, client, gate = self.gated()
        first = client.stub.ModelInfer.future(request("affine", X), timeout=60)
        self.assertEqual(pipeline.frames_at_gate(1), 1)
        # gRPC's clients end such calls themselves, perhaps before the server does.
        peer = http2_peer.Connection(pipeline.port)
        self.addCleanup(peer.close)
        late = [peer.call(INFER, request("affine", X).SerializeToString(), more=[("grpc-timeout", "2S")]) for _ in range(3)]
        end = time.monotonic() + 60
        while any(stream.reset is None for stream in late):
            self.assertLess(time.monotonic(), end)
            peer.push()
            peer.read(1)
        gate.open()
        self.assertEqual(status_of(first.result)[0], "OK")
        self.assertEqual(status_of(lambda: client.infer(request("affine", X)))[0], "OK")
        self.assertEqual(pipeline.frames_at_gate(2), 2)
        pipeline.stop()
        counts = self.ended(pipeline)
        self.assertEqual((counts["answered"], counts["expired"]), (2, 3))

    def test_a_cancelled_request_is_not_run(self):
        pipeline, client, gate = self.gated()
        first = client.stub.ModelInfer.future(request("affine", X), timeout=60)
        self.assertEqual(pipeline.frames_at_gate(1), 1)
        second = client.stub.ModelInfer.future(request("affine", X), timeout=60)
        second.cancel()
        for _ in range(20):  # no client sees that the server knows of it, but it comes before these calls
            self.assertTrue(client.call("ServerLive", pb.ServerLiveRequest()).live)
        gate.open()
        self.assertEqual(status_of(first.result)[0], "OK")
        self.assertEqual(status_of(lambda: client.infer(request("affine", X)))[0], "OK")
        pipeline.stop()
        counts = self.ended(pipeline)
        self.assertEqual((counts["answered"], counts["aborted"], counts["refused"]), (2, 0, 0))

    def test_stopping_ends_all_requests(self):
        pipeline, client, _ = self.gated("queue=4")
        first = client.stub.ModelInfer.future(request("affine", X), timeout=60)
        self.assertEqual(pipeline.frames_at_gate(1), 1)
        calls = [client.stub.ModelInfer.future(request("affine", X), timeout=60) for _ in range(7)]
        wait_until_done(calls, 3)  # the queue is full when they are refused
        pipeline.interrupt()
        ended = [status_of(call.result)[0] for call in [first, *calls]]
        self.assertEqual(sorted(ended), ["RESOURCE_EXHAUSTED"] * 3 + ["UNAVAILABLE"] * 5)
        pipeline.stop()
        self.assertEqual(self.ended(pipeline)["received"], 8)

    def test_64_clients_get_an_end_of_each_call(self):
        clients, calls = 64, 1000
        pipeline, _ = self.affine("queue !", "max-connections=0 max-connections-per-address=0")

        def work(number):
            client = Client(f"127.0.0.1:{pipeline.port}")
            wrong = 0
            for i in range(calls):
                x = np.full((1, 4), number * calls + i, np.float32)
                response = client.infer(request("affine", x), 60)
                wrong += response.raw_output_contents[0] != (2 * x + 1).tobytes()
            client.close()
            return wrong

        with concurrent.futures.ThreadPoolExecutor(clients) as pool:
            self.assertEqual(sum(pool.map(work, range(clients))), 0)
        pipeline.stop()
        self.assertEqual(self.ended(pipeline), dict(received=clients * calls, answered=clients * calls, refused=0, expired=0, aborted=0))


class Starts(unittest.TestCase):
    def fails(self, text):
        done = subprocess.run(["gst-launch-1.0", *text.split()], capture_output=True, text=True, timeout=60, stdin=subprocess.DEVNULL)
        self.assertNotEqual(done.returncode, 0, done.stdout)
        return done.stderr

    def test_other_machines_need_tls(self):
        text = self.fails(f"{source('host=0.0.0.0')} ! tensor_query_serversink")
        self.assertIn("WEIR-6003: other machines could connect without encryption\n  offered: listening on 0.0.0.0:0", text)
        self.assertIn("fix: tls-cert=server.pem tls-key=server.key, or host=localhost", text)

    def test_unusable_settings_are_errors(self):
        for options, wanted in {
                "protocol=edge connect-type=HYBRID": "topic cannot be part of an MQTT topic\n  offered: \"\"",
                "connect-type=HYBRID": "needed: connect-type=TCP",
                "tls-cert=a.pem": "offered: tls-cert without tls-key",
                "tls-ca=a.pem": "WEIR-1004: client certificates need a connection with TLS",
                "tls-peers=a": "offered: tls-peers without tls-ca",
                "token-file=a": "WEIR-6003: clients would send their tokens without TLS",
                "tls-cert=nowhere.pem tls-key=nowhere.key": "WEIR-4001: the file of the property tls-cert cannot be read",
                "host=192.0.2.1 insecure=true": "WEIR-1004: the server cannot listen on this address\n  offered: 192.0.2.1:0"}.items():
            with self.subTest(options):
                self.assertIn(wanted, self.fails(f"{source()} {options} ! tensor_query_serversink"))

    def test_unknown_requests_are_an_error(self):
        text = self.fails("tensor_query_serversrc protocol=oip port=0 ! tensor_transform mode=arithmetic option=add:1 ! fakesink")
        self.assertIn("WEIR-1004: the tensors of the requests are not known", text)
        self.assertIn("fix: caps=", text)

    def test_a_sink_without_its_source_is_an_error(self):
        text = self.fails(f"{source('id=1')} ! tensor_query_serversink id=2")
        self.assertIn("WEIR-1004: no tensor_query_serversrc has the same id\n  offered: tensor_query_serversink id=2", text)

    def test_two_pairs_of_one_id_are_an_error(self):
        text = self.fails(f"{source()} ! tensor_query_serversink {source()} ! tensor_query_serversink")
        self.assertIn("another tensor_query_serversrc of this process has the same id\n  offered: id=0", text)


if __name__ == "__main__":
    tap_runner.main()
