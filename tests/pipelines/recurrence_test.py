#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Tests recurrent cells in a loop of tensor_reposrc, tensor_mux, tensor_filter, tensor_demux and tensor_reposink."""

import os
import pathlib
import subprocess
import tempfile
import unittest

import numpy

import onnx_writer
import tap_runner

STEPS, X, H, Y = 1000, 4, 8, 3
HAS_ONNX = "onnxruntime" in os.environ["WEIR_MODULE_PATH"]


def sigmoid(x):
    return 1 / (1 + numpy.exp(-x))


class Cell:
    """Seeded weights of gates that read the input and the last output, and of the output layer."""

    def __init__(self, seed, gates):
        random = numpy.random.default_rng(seed)
        self.arrays = {"V": self.small(random, H, Y)}
        for gate in gates:
            self.arrays |= {f"W{gate}": self.small(random, X, H), f"U{gate}": self.small(random, H, H),
                            f"b{gate}": self.small(random, 1, H)}
        self.inputs = random.uniform(-1, 1, (STEPS, X)).astype(numpy.float32)

    @staticmethod
    def small(random, *shape):
        return random.uniform(-0.4, 0.4, shape).astype(numpy.float32)

    def gate(self, name, function, x, h):
        a = self.arrays
        return function(x @ a[f"W{name}"] + h @ a[f"U{name}"] + a[f"b{name}"])

    @staticmethod
    def gate_nodes(name, function):
        return [("MatMul", ["x", f"W{name}"], f"{name}x"), ("MatMul", ["h", f"U{name}"], f"{name}h"),
                ("Add", [f"{name}x", f"{name}h"], f"{name}s"), ("Add", [f"{name}s", f"b{name}"], f"{name}p"),
                (function, [f"{name}p"], name)]


class Rnn(Cell):
    """h' = tanh(x W + h U + b), y = h' V."""

    def __init__(self, seed):
        super().__init__(seed, "n")

    def model(self):
        nodes = self.gate_nodes("n", "Tanh") + [("MatMul", ["n", "V"], "y"), ("Identity", ["n"], "next")]
        return onnx_writer.model(nodes, self.arrays, [("x", (1, X)), ("h", (1, H))], [("y", (1, Y)), ("next", (1, H))])

    def expected(self):
        h, out = numpy.zeros((1, H), numpy.float32), []
        for x in self.inputs:
            h = self.gate("n", numpy.tanh, x[None], h)
            out.append(h @ self.arrays["V"])
        return numpy.concatenate(out)


class Lstm(Cell):
    """c' = f c + i g, h' = o tanh(c'), y = h' V."""

    def __init__(self, seed):
        super().__init__(seed, "ifgo")

    def model(self):
        nodes = sum((self.gate_nodes(g, "Tanh" if g == "g" else "Sigmoid") for g in "ifgo"), [])
        nodes += [("Mul", ["f", "c"], "kept"), ("Mul", ["i", "g"], "new"), ("Add", ["kept", "new"], "next_c"),
                  ("Tanh", ["next_c"], "shown"), ("Mul", ["o", "shown"], "next_h"), ("MatMul", ["next_h", "V"], "y")]
        return onnx_writer.model(nodes, self.arrays, [("x", (1, X)), ("h", (1, H)), ("c", (1, H))],
                                 [("y", (1, Y)), ("next_h", (1, H)), ("next_c", (1, H))])

    def expected(self):
        h, c, out = numpy.zeros((1, H), numpy.float32), numpy.zeros((1, H), numpy.float32), []
        for x in self.inputs:
            i, f, o = (self.gate(g, sigmoid, x[None], h) for g in "ifo")
            c = f * c + i * self.gate("g", numpy.tanh, x[None], h)
            h = o * numpy.tanh(c)
            out.append(h @ self.arrays["V"])
        return numpy.concatenate(out)


@unittest.skipUnless(HAS_ONNX, "the engine onnxruntime is not built")
class Recurrence(unittest.TestCase):
    def play(self, cell, line):
        """The pipeline's outputs for the cell's inputs, one row per step. {source}, {model}, {out} stand for files."""
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder)
            (path / "in").write_bytes(cell.inputs.tobytes())
            (path / "cell.onnx").write_bytes(cell.model())
            source = (f"filesrc location={path}/in blocksize={4 * X} ! application/octet-stream,framerate=30/1 ! "
                      f"tensor_converter input-dim={X}:1 input-type=float32")
            words = line.format(source=source, filter=f"tensor_filter framework=onnxruntime model={path}/cell.onnx",
                                out=f"filesink async=false location={path}/out").split()
            done = subprocess.run(["gst-launch-1.0", "-q", *words], timeout=120, capture_output=True, text=True,
                                  stdin=subprocess.DEVNULL)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            self.assertNotRegex(done.stderr, r"object-alive, type-name=\(string\)\w+|CRITICAL|WARNING|ERROR")
            return numpy.frombuffer((path / "out").read_bytes(), numpy.float32).reshape(-1, Y)

    def check(self, cell, line):
        seen, expected = self.play(cell, line), cell.expected()
        self.assertEqual(len(seen), STEPS, "EOS of the source ends the loop, and no step is lost")
        self.assertGreater(expected.std(), 0.01, "the cell does something")
        numpy.testing.assert_allclose(seen, expected, rtol=0, atol=1e-5)

    def test_an_rnn_cell_for_1000_steps(self):
        self.check(Rnn(1), f"{{source}} ! mux.sink_0 tensor_reposrc slot-index=0 caps=other/tensor,dimension=(string){H}:1,"
                   "type=(string)float32,framerate=(fraction)30/1 ! mux.sink_1 tensor_mux name=mux sync-mode=nosync ! "
                   "{filter} ! tensor_demux name=d d.src_0 ! {out} d.src_1 ! tensor_reposink slot-index=0")

    def test_an_rnn_cell_with_queues_and_the_sink_written_first(self):
        self.check(Rnn(2), f"tensor_reposink name=end slot-index=5 {{source}} ! queue ! mux.sink_0 tensor_reposrc slot-index=5 "
                   f"caps=other/tensors,format=static,num_tensors=1,dimensions=(string){H}:1:1:1,types=(string)float32,"
                   "framerate=(fraction)30/1 ! queue ! mux.sink_1 tensor_mux name=mux sync-mode=nosync ! {filter} ! "
                   "tensor_demux name=d d.src_0 ! queue ! {out} d.src_1 ! queue ! end.")

    def test_an_lstm_cell_whose_two_states_go_round_in_one_frame(self):
        self.check(Lstm(3), f"{{source}} ! mux.sink_0 tensor_reposrc slot-index=0 caps=other/tensors,format=static,num_tensors=2,"
                   f"dimensions=(string)\"{H}:1,{H}:1\",types=(string)\"float32,float32\",framerate=(fraction)30/1 ! mux.sink_1 "
                   "tensor_mux name=mux sync-mode=nosync ! {filter} ! tensor_demux name=d tensorpick=0,1:2 "
                   "d.src_0 ! {out} d.src_1 ! tensor_reposink slot-index=0")

    def test_an_lstm_cell_with_a_loop_for_each_state(self):
        loop = (f"caps=other/tensor,dimension=(string){H}:1,type=(string)float32,framerate=(fraction)30/1 ")
        self.check(Lstm(4), f"{{source}} ! mux.sink_0 tensor_reposrc slot-index=0 {loop} ! mux.sink_1 "
                   f"tensor_reposrc slot-index=1 {loop} ! mux.sink_2 tensor_mux name=mux sync-mode=nosync ! {{filter}} ! "
                   "tensor_demux name=d d.src_0 ! {out} d.src_1 ! tensor_reposink slot-index=0 "
                   "d.src_2 ! tensor_reposink slot-index=1")


if __name__ == "__main__":
    tap_runner.main()
