#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Compares models for sound, sensors and text with the reference results of ../shared."""

import wave

import numpy

import tap_runner
from reference_models import MEDIA, MODELS, ReferenceCase, results


def sound(name):
    with wave.open(str(MEDIA / "audio" / name)) as file:
        assert (file.getframerate(), file.getnchannels(), file.getsampwidth()) == (16000, 1, 2)
        return numpy.frombuffer(file.readframes(file.getnframes()), "<i2").astype("f4") / 32768


def labels(name):
    return (MODELS / "audio" / name).read_text().splitlines()


class Sounds(ReferenceCase):
    def agree(self, scores, names, reference, delta):
        self.assertEqual(names[scores.argmax()], reference[0][0])
        for name, score in reference:
            self.assertAlmostEqual(float(scores[names.index(name)]), score, delta=delta, msg=name)

    def test_speech_commands(self):
        names = labels("conv_actions_labels.txt")
        for file, reference in results()["audio"].items():
            with self.subTest(file):
                samples = sound(file)[:16000]
                samples = numpy.pad(samples, (0, 16000 - samples.size))
                scores = self.run_model("audio/conv_actions_frozen.tflite", [samples[:, None], numpy.array([16000], "i4")], [((12,), "f4")])
                self.agree(scores, names, reference["conv_actions"], 0.005)

    def test_yamnet(self):
        names = labels("yamnet_labels.txt")
        for file, reference in results()["audio"].items():
            with self.subTest(file):
                scores = self.run_model("audio/yamnet.tflite", [sound(file)[:15600]], [((521,), "f4")])
                self.agree(scores, names, reference["yamnet_first_0.975s"], 0.03)


class Signals(ReferenceCase):
    def test_the_nine_is_read_row_by_row(self):
        picture = self.picture("image/9.png", "GRAY8").reshape(1, 28, 28)
        scores = self.run_model("sensor/mnist_lstm_float.tflite", [picture / numpy.float32(255)], [((10,), "f4")])
        self.assertEqual(scores.argmax(), results()["sensor"]["mnist_lstm 9.png"])

    def test_an_autoencoder_is_as_far_off_as_it_was(self):
        """Uses windows of five spectra, as in the network's training."""
        spectra = numpy.fromfile(MEDIA / "sensor/dcase_normal_id_01_hist_librosa.bin", "<f4").reshape(200, 128)
        windows, error = results("reference_results_extra")["ad01 mean squared error"]
        inputs = numpy.stack([spectra[i:i + 5].ravel() for i in range(windows)])
        outputs = self.run_model("sensor/ad01_fp32.tflite", [inputs[:, None]], [((640,), "f4")], frames=windows)
        self.assertAlmostEqual(float(((outputs - inputs) ** 2).mean()), error, delta=0.001)


if __name__ == "__main__":
    tap_runner.main()
