#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Tests that the same weights in four formats, each in its own engine and pipeline, give the same values, and that a Darknet
network gives those computed with NumPy.

The nets in four formats are MTCNN's (../shared/MANIFEST.md, MTCNN facts): ONNX and TorchScript take the picture unchanged, Caffe and
TensorFlow Lite with rows and columns exchanged.
"""

import struct
import unittest

import numpy

import tap_runner
from built_modules import has_engine
from reference_models import MEDIA, MODELS, PipelineCase

MTCNN = MODELS / "face/mtcnn"
TOLERANCE = 1e-4


def dimensions(array):
    return ":".join(str(extent) for extent in reversed(array.shape))


class Filtered(PipelineCase):
    def filtered(self, array, properties):
        """The float32 values that leave a tensor_filter, all outputs concatenated."""
        source, result = self.folder / "in.raw", self.folder / "out.raw"
        array.astype("<f4").tofile(source)
        self.play(f"filesrc location={source} blocksize={array.size * 4} ! application/octet-stream ! "
                  f"tensor_converter input-dim={dimensions(array)} input-type=float32 ! tensor_filter {properties} ! "
                  f"filesink location={result}")
        return numpy.fromfile(result, "<f4")


DARKNET = """[net]
batch=1
width=12
height=10
channels=3

[convolutional]
batch_normalize=1
filters=4
size=3
stride=1
pad=1
activation=leaky

[maxpool]
size=2
stride=2

[convolutional]
filters=5
size=1
stride=1
pad=1
activation=linear
"""


@unittest.skipUnless(has_engine("darknet"), "the engine darknet is not built")
class Darknet(Filtered):
    def test_a_network_gives_what_numpy_computes(self):
        """Darknet's layers as in its source: batch mean and variance with 1e-6, leaky with 0.1."""
        random = numpy.random.default_rng(5)
        beta, mean = random.normal(size=(2, 4)).astype("<f4")
        gamma, variance = random.uniform(0.5, 2, (2, 4)).astype("<f4")
        first = random.normal(size=(4, 3, 3, 3)).astype("<f4")
        bias, second = random.normal(size=5).astype("<f4"), random.normal(size=(5, 4)).astype("<f4")
        cfg, weights = self.folder / "net.cfg", self.folder / "net.weights"
        cfg.write_text(DARKNET)
        weights.write_bytes(struct.pack("<iiiq", 0, 2, 0, 0) + b"".join(
            part.tobytes() for part in (beta, gamma, mean, variance, first, bias, second)))
        pictures = random.uniform(0, 1, (2, 3, 10, 12)).astype("<f4")

        padded = numpy.pad(pictures.astype(float), ((0, 0), (0, 0), (1, 1), (1, 1)))
        x = sum(numpy.einsum("fc,nchw->nfhw", first[:, :, i, j].astype(float), padded[:, :, i:i + 10, j:j + 12])
                for i in range(3) for j in range(3))
        planes = (slice(None), None, None)
        x = (x - mean[planes]) / numpy.sqrt(variance[planes].astype(float) + 1e-6) * gamma[planes] + beta[planes]
        x = numpy.where(x > 0, x, 0.1 * x).reshape(2, 4, 5, 2, 6, 2).max((3, 5))
        expected = numpy.einsum("gf,nfhw->nghw", second.astype(float), x) + bias[planes]

        for properties in (f"framework=darknet model={cfg},{weights}", f"model={cfg}", f"model={weights}"):
            found = numpy.concatenate([self.filtered(picture[None], properties) for picture in pictures])
            self.assertLess(abs(found.reshape(expected.shape) - expected).max(), 1e-5)


class EnginesAgree(Filtered):
    def setUp(self):
        if not MTCNN.is_dir():
            self.skipTest(f"{MTCNN} is not there")
        super().setUp()

    def photo(self, width, height):
        """Faces as float32 of rows, columns, colours centred on zero, computed by elements."""
        result = self.folder / "photo.raw"
        self.play(f"filesrc location={MEDIA / 'face/faces.jpg'} ! jpegdec ! videoconvert ! videoscale ! "
                  f"video/x-raw,format=RGB,width={width},height={height} ! tensor_converter ! tensor_transform "
                  f"mode=arithmetic option=typecast:float32,add:-127.5,div:128 ! filesink location={result}")
        return numpy.fromfile(result, "<f4").reshape(height, width, 3)

    def outputs(self, photo, number, name):
        """Maps each format whose engine is built to its values in the order of the untransposed net."""
        planes = photo.transpose(2, 0, 1)[None]  # [1, 3, h, w]
        turned = photo.transpose(2, 1, 0)[None]  # [1, 3, w, h]
        rows = photo.transpose(1, 0, 2)[None]  # [1, w, h, 3]
        runs = {"onnxruntime": (planes, f"model={MTCNN}/onnx/{name}.onnx"),
                "pytorch": (planes, f"model={MTCNN}/torchscript/{name}.pt input={dimensions(planes)}"),
                "caffe": (turned, f"model={MTCNN}/caffe/det{number}.prototxt,{MTCNN}/caffe/det{number}.caffemodel "
                                  f"input={dimensions(turned)}"),
                "tensorflow-lite": (rows, f"model={MTCNN}/tflite/{name}.tflite")}
        return {engine: self.filtered(array, f"framework={engine} {properties}")
                for engine, (array, properties) in runs.items() if has_engine(engine)}

    def compare(self, found):
        self.assertGreater(len(found), 1, "one engine alone agrees with itself")
        first = next(iter(found))
        for engine, arrays in found.items():
            for role, array in arrays.items():
                other = found[first][role]
                self.assertEqual(array.shape, other.shape)
                self.assertGreater(other.std(), 1e-3, "the numbers differ among themselves")
                self.assertLess(abs(array - other).max(), TOLERANCE, f"{role} of {engine} and of {first}")

    def test_proposals_over_a_whole_photo(self):
        """P-Net at the size stored in the .tflite, 1280x960; its map is 635x475."""
        width, height, columns, rows = 1280, 960, 635, 475
        cells = columns * rows
        found = {}
        for engine, values in self.outputs(self.photo(width, height), 1, "pnet").items():
            self.assertEqual(values.size, 6 * cells, engine)
            if engine == "caffe":  # the box comes first; columns before rows
                box, face = values[:4 * cells], values[4 * cells:]
                box, face = (v.reshape(-1, columns, rows).transpose(0, 2, 1) for v in (box, face))
            elif engine == "tensorflow-lite":
                face, box = values[:2 * cells], values[2 * cells:]
                face, box = (v.reshape(columns, rows, -1).transpose(2, 1, 0) for v in (face, box))
            else:
                face, box = (v.reshape(-1, rows, columns) for v in (values[:2 * cells], values[2 * cells:]))
            self.assertLess(abs(face.sum(axis=0) - 1).max(), 1e-5, f"{engine}: a softmax")
            found[engine] = {"face": face, "box": box}
        self.compare(found)

    def vectors(self, number, name, side, places):
        """`places`: the offset of each role in the outputs of Caffe and TensorFlow Lite."""
        found = {}
        for engine, values in self.outputs(self.photo(side, side), number, name).items():
            order = places.get(engine, {"face": (0, 2), "box": (2, 6), "points": (6, 16)})
            found[engine] = {role: values[slice(*order[role])] for role in places["roles"]}
            self.assertEqual(values.size, sum(len(v) for v in found[engine].values()), engine)
        self.compare(found)

    def test_refinement(self):
        self.vectors(2, "rnet", 24, {"roles": ["face", "box"], "caffe": {"box": (0, 4), "face": (4, 6)}})

    def test_landmarks(self):
        self.vectors(3, "onet", 48, {"roles": ["face", "box", "points"],
                                     "caffe": {"box": (0, 4), "points": (4, 14), "face": (14, 16)}})

    @unittest.skipUnless(has_engine("caffe") and has_engine("onnxruntime"), "the engine caffe or onnxruntime is not built")
    def test_ultraface(self):
        """Compares the scores of the Caffe and the ONNX net; the latter decodes its boxes (MANIFEST.md)."""
        photo = self.photo(320, 240).transpose(2, 0, 1)[None]
        stem = MODELS / "face/ultraface_RFB-320"
        scores = self.filtered(photo, f"model={stem}.onnx output-combination=o0")
        caffe = self.filtered(photo, f"model={stem}.caffemodel outputname=scores")
        self.assertEqual(scores.shape, (2 * 4420,))
        self.assertGreater(scores.reshape(-1, 2)[:, 1].max(), 0.9, "it sees the faces")
        self.assertLess(abs(scores - caffe).max(), TOLERANCE)


if __name__ == "__main__":
    tap_runner.main()
