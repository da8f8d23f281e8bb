#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Trains the networks of examples/ars on simulated clips, scores them on held-back clips, and writes weights and cards.

About eleven minutes on one core. The seed and the number of threads are fixed.
"""

import argparse
import datetime
import hashlib
import json
import pathlib
import sys
import time

import numpy as np
import torch
from torch import nn

import activity_networks as networks

EXAMPLE = pathlib.Path(__file__).resolve().parents[2] / "examples/ars"
sys.path.insert(0, str(EXAMPLE))
import event_camera  # noqa: E402
import radio  # noqa: E402
import simulator  # noqa: E402

SEED, HELD_BACK_SEED = 20261126, 7
BATCH = 64
ACTIVITIES = simulator.ACTIVITIES
# The sequence network learns from results on clips that the event network has not seen.
CLIPS = {"event": (SEED, 250), "sequence": (SEED + 1, 200), "radio": (SEED + 2, 1000), "held back": (HELD_BACK_SEED, 150)}


def clips(sensor, name):
    """Simulated clips and the index of the activity of each."""
    seed, count = CLIPS[name]
    labels = np.arange(count) % len(ACTIVITIES)
    return [sensor.clip(ACTIVITIES[label], simulator.generator(seed, index)) for index, label in enumerate(labels)], labels


def normalised(frames):
    return (torch.from_numpy(frames).float() - event_camera.REST) / event_camera.GAIN


def standardised(responses):
    """As tensor_transform mode=stand option=default: |x - mean| / deviation over the window of one radio."""
    axes = (-2, -1)
    return np.abs(responses - responses.mean(axes, keepdims=True)) / responses.std(axes, keepdims=True)


def fit(network, windows, labels, epochs, rate, varied):
    """`varied` changes a batch at random, so that the network sees more than the clips."""
    steps = epochs * (len(windows) // BATCH)
    optimiser = torch.optim.AdamW(network.parameters(), lr=rate, weight_decay=1e-2)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimiser, max_lr=rate, total_steps=steps)
    loss_of = nn.CrossEntropyLoss(label_smoothing=0.05)
    network.train()
    for epoch in range(epochs):
        total, started = 0.0, time.monotonic()
        batches = torch.randperm(len(windows))[: len(windows) // BATCH * BATCH].split(BATCH)
        for batch in batches:
            optimiser.zero_grad()
            loss = loss_of(network(varied(windows[batch])), labels[batch])
            loss.backward()
            optimiser.step()
            schedule.step()
            total += loss.item()
        print(f"epoch {epoch + 1}/{epochs}: loss {total / len(batches):.3f}, {time.monotonic() - started:.0f} s", flush=True)
    return network.eval()


@torch.no_grad()
def probabilities(network, windows):
    return torch.cat([torch.softmax(network(part), dim=1) for part in windows.split(256)])


def share_right(scores, labels):
    """Of windows [clips, windows, activities]."""
    return float((np.asarray(scores).argmax(-1) == np.asarray(labels)[:, None]).mean())


def train_event_network():
    frames, labels = clips(event_camera, "event")
    windows = normalised(np.concatenate([networks.make_windows(one, networks.EVENT_FRAMES, networks.EVENT_FRAMES) for one in frames]))
    each = torch.from_numpy(labels).repeat_interleave(len(windows) // len(labels))

    def varied(batch):
        return batch.flip(3) if torch.rand(()) < 0.5 else batch

    return fit(networks.EventNetwork(len(ACTIVITIES)), windows, each, 6, 3e-3, varied)


def get_results(event_network, frames):
    """The event network's probabilities in windows of 8 by 4: [clips, windows, activities]."""
    return np.stack([probabilities(event_network, normalised(networks.make_windows(one, networks.EVENT_FRAMES, 4))).numpy() for one in frames])


def make_sequences(results, length, step):
    return np.stack([networks.make_windows(one, length, step) for one in results])


def train_sequence_network(event_network):
    frames, labels = clips(event_camera, "sequence")
    windows = make_sequences(get_results(event_network, frames), networks.RESULTS, 1)
    each = torch.from_numpy(labels).repeat_interleave(windows.shape[1])
    flat = torch.from_numpy(windows.reshape(-1, *windows.shape[2:]))
    return fit(networks.SequenceNetwork(len(ACTIVITIES)), flat, each, 8, 4e-3, lambda batch: batch)


def train_radio_network():
    responses, labels = clips(radio, "radio")
    starts = (0, 8, 17, 25)
    windows = np.concatenate([np.stack([one[:, begin:begin + networks.RESPONSES] for begin in starts]) for one in responses])
    each = torch.from_numpy(labels).repeat_interleave(len(starts))

    def varied(batch):
        return batch.flip(1) if torch.rand(()) < 0.5 else batch

    return fit(networks.RadioNetwork(len(ACTIVITIES)), torch.from_numpy(standardised(windows)), each, 8, 4e-3, varied)


def card(weights, task, inputs, accuracy):
    return {
        "name": weights.stem, "model": weights.name, "sha256": hashlib.sha256(weights.read_bytes()).hexdigest(), "task": task,
        "inputs": [inputs], "outputs": [{"name": "probabilities", "type": "float32", "shape": [1, len(ACTIVITIES)],
                                         "meaning": "probability of each activity"}],
        "labels": list(ACTIVITIES), "decoder": "image_labeling",
        "provenance": {
            "how": "trained from random weights by tools/train/train_activities.py on clips that the simulator of examples/ars made",
            "seed": SEED, "held_back": f"{CLIPS['held back'][1]} clips of {simulator.CLIP_SECONDS} s, seed {HELD_BACK_SEED}",
            **accuracy, "date": datetime.date.today().isoformat(), "licence": "LGPL-2.1-or-later"}}


def write_card(weights, task, shape, accuracy, meaning):
    inputs = {"name": "windows", "type": "float32", "shape": shape, "meaning": meaning}
    text = json.dumps(card(weights, task, inputs, {name: round(value, 3) for name, value in accuracy.items()}), indent=2)
    weights.with_suffix(".card.json").write_text(text + "\n")
    print(weights.name, weights.stat().st_size, "bytes", accuracy, flush=True)


def train_events(folder):
    event_network = train_event_network()
    sequence_network = train_sequence_network(event_network)
    frames, labels = clips(event_camera, "held back")
    results = get_results(event_network, frames)
    votes = make_sequences(results, 6, 1).mean(axis=2)
    scores = np.stack([probabilities(sequence_network, torch.from_numpy(one)).numpy() for one in make_sequences(results, networks.RESULTS, 3)])
    for network, name, export, shape, task, accuracy, meaning in (
            (event_network, "event_network.f32", networks.export_event_network, [8, 48, 64], "activity in a window of 8 event frames",
             {"accuracy_held_back": share_right(results, labels), "accuracy_of_6_results": share_right(votes, labels)},
             "event frames of 1/30 s, (byte - 128) / 16"),
            (sequence_network, "sequence_network.f16", networks.export_sequence_network, [12, 5], "activity in 12 results of event_network",
             {"accuracy_held_back": share_right(scores, labels)}, "probabilities of event_network, the oldest first")):
        weights = folder / name
        export(network, weights)
        write_card(weights, task, shape, accuracy, meaning)


def train_radio(folder):
    network = train_radio_network()
    responses, labels = clips(radio, "held back")
    windows = standardised(np.stack([np.stack([one[:, begin:begin + networks.RESPONSES] for begin in (0, 25)]) for one in responses]))
    scores = np.stack([probabilities(network, torch.from_numpy(one)).numpy() for one in windows])
    weights = folder / "radio_network.onnx"
    networks.export_radio_network(network, weights)
    write_card(weights, "activity in 3 s of two ultra-wideband radios", [1, 2, 75, 32], {"accuracy_held_back": share_right(scores, labels)},
               "responses of both radios, 75 at 25 Hz, each radio's as |x - mean| / deviation")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--output", type=pathlib.Path, default=EXAMPLE / "networks", help="folder of weights and cards")
    parser.add_argument("--only", choices=("events", "radio"), help="train these networks alone")
    options = parser.parse_args()
    options.output.mkdir(parents=True, exist_ok=True)
    torch.set_num_threads(1)
    torch.use_deterministic_algorithms(True)
    for name, train in (("events", train_events), ("radio", train_radio)):
        if options.only in (None, name):
            torch.manual_seed(SEED)
            train(options.output)


if __name__ == "__main__":
    main()
