#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Trains models/clock_digits.onnx, the reader of the clock that timeoverlay draws, and its card."""

import argparse
import datetime
import hashlib
import json
import os
import pathlib
import time
from concurrent.futures import ProcessPoolExecutor

import numpy as np
import torch
from torch import nn

import clock_strips as strips

SEED = 20261121
BATCH = 128
THREADS = 2  # fixed, as the order of a sum depends on it
MEAN, SCALE = 127.5, 1 / 127.5
OPSET = 11
CHUNKS = 8  # strips are drawn in this many independently seeded parts, whatever the number of cores
MODELS = pathlib.Path(__file__).resolve().parents[2] / "models"


def convolution(inputs, outputs, stride):
    return [nn.Conv2d(inputs, outputs, 3, stride, padding=1, bias=False), nn.BatchNorm2d(outputs), nn.ReLU()]


class DigitReader(nn.Module):
    """NHWC strips in, logits [batch, CELLS, labels] out; four halvings make one column a cell."""

    def __init__(self):
        super().__init__()
        self.features = nn.Sequential(
            *convolution(1, 16, 2), *convolution(16, 32, 2), *convolution(32, 32, 1),
            *convolution(32, 48, 2), *convolution(48, 64, 2))
        self.column = nn.Sequential(nn.Conv2d(64, 64, (strips.STRIP_HEIGHT // 16, 1)), nn.ReLU())
        self.classify = nn.Conv2d(64, len(strips.LABELS), 1)

    def forward(self, nhwc):
        cells = self.classify(self.column(self.features(nhwc.permute(0, 3, 1, 2))))
        return cells.squeeze(2).permute(0, 2, 1)


class Exported(nn.Module):
    """The reader as it is shipped: probabilities in place of logits."""

    def __init__(self, reader):
        super().__init__()
        self.reader = reader

    def forward(self, nhwc):
        return torch.softmax(self.reader(nhwc), dim=2)


def draw_dataset(fonts, count, seed):
    """count strips, drawn on all cores."""
    with ProcessPoolExecutor(os.cpu_count()) as pool:
        parts = list(pool.map(strips.draw_strips, [fonts] * CHUNKS, [count // CHUNKS] * CHUNKS,
                              range(seed, seed + CHUNKS)))
    images, labels = (np.concatenate(part) for part in zip(*parts))
    return torch.from_numpy(images).unsqueeze(3), torch.from_numpy(labels)


def normalised(images):
    return (images.float() - MEAN) * SCALE


def train(reader, images, labels, epochs):
    steps = epochs * (len(images) // BATCH)
    optimiser = torch.optim.AdamW(reader.parameters(), lr=1e-3, weight_decay=1e-3)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimiser, max_lr=6e-3, total_steps=steps)
    loss_of = nn.CrossEntropyLoss(label_smoothing=0.02)
    reader.train()
    for epoch in range(epochs):
        total, started = 0.0, time.monotonic()
        batches = torch.randperm(len(images))[: len(images) // BATCH * BATCH].split(BATCH)
        for batch in batches:
            optimiser.zero_grad()
            loss = loss_of(reader(normalised(images[batch])).transpose(1, 2), labels[batch])
            loss.backward()
            optimiser.step()
            schedule.step()
            total += loss.item()
        print(f"epoch {epoch + 1}/{epochs}: loss {total / len(batches):.4f}, {time.monotonic() - started:.0f} s",
              flush=True)


@torch.no_grad()
def accuracy(reader, images, labels):
    """Part of the printed characters and blanks that are read right."""
    reader.eval()
    right = [(reader(normalised(part)).argmax(2) == truth).float().mean(1)
             for part, truth in zip(images.split(512), labels.split(512))]
    return torch.cat(right).mean().item()


def export(reader, path):
    example = torch.zeros(1, strips.STRIP_HEIGHT, strips.STRIP_WIDTH, 1)
    torch.onnx.export(Exported(reader).eval(), example, str(path), opset_version=OPSET,
                      input_names=["strip"], output_names=["cells"])


def font_names(fonts):
    return [name.rsplit("/", 1)[-1].rsplit(".", 1)[0] for name in fonts]


def card(model, held_back_accuracy):
    return {
        "name": "clock_digits",
        "model": model.name,
        "sha256": hashlib.sha256(model.read_bytes()).hexdigest(),
        "task": "reads the clock text (h:mm:ss.mmm) that GStreamer's timeoverlay draws, one character per cell",
        "inputs": [{
            "name": "strip", "type": "float32", "shape": [1, strips.STRIP_HEIGHT, strips.STRIP_WIDTH, 1],
            "layout": "NHWC", "color": "GRAY8", "mean": [MEAN], "scale": [round(SCALE, 11)], "resize": "stretch"}],
        "outputs": [{
            "name": "cells", "type": "float32", "shape": [1, strips.CELLS, len(strips.LABELS)],
            "meaning": "probability of each label, for each cell from left to right"}],
        "labels": strips.LABELS,
        "decoder": None,
        "provenance": {
            "how": "trained from random weights by tools/train/train_clock_digits.py on strips drawn from font "
                   "glyphs; no recorded picture was used",
            "fonts": font_names(strips.TRAINING_FONTS),
            "held_back_fonts": font_names(strips.HELD_BACK_FONTS),
            "accuracy_held_back": round(held_back_accuracy, 4),
            "date": datetime.date.today().isoformat(),
            "licence": "LGPL-2.1-or-later",
        },
    }


def options():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--strips", type=int, default=40000, help="strips to train on")
    parser.add_argument("--epochs", type=int, default=8)
    parser.add_argument("--output", type=pathlib.Path, default=MODELS, help="folder of the model and its card")
    return parser.parse_args()


def main():
    chosen = options()
    torch.manual_seed(SEED)
    torch.set_num_threads(THREADS)
    torch.use_deterministic_algorithms(True)
    held_back = draw_dataset(strips.HELD_BACK_FONTS, 8000, SEED + 1000)
    images, labels = draw_dataset(strips.TRAINING_FONTS, chosen.strips, SEED)
    reader = DigitReader()
    train(reader, images, labels, chosen.epochs)
    result = accuracy(reader, *held_back)
    print(f"held-back fonts: {result:.4%} of the cells right")

    model = chosen.output / "clock_digits.onnx"
    export(reader, model)
    text = json.dumps(card(model, result), indent=2)
    model.with_suffix(".card.json").write_text(text + "\n")
    print(f"{model.name}: {model.stat().st_size} bytes")


if __name__ == "__main__":
    main()
