#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Makes sequences of boxes that cross, hide, shake and are missed, with their truth, to score trackers on.

tools/tracking/sequences.py FOLDER [--scenes crossings,occlusion] [--seeds 1,2,3] [--pictures] [--embeddings]

Writes a folder for each scene and seed, as MOTChallenge does: seqinfo.ini, gt/gt.txt and det/det.txt; with --pictures
img1/000001.png and so on, with --embeddings det/embeddings.npy, a vector for each line of det.txt. docs/tracking.md has
the formulas. The same seed makes the same files.
"""

import argparse
import dataclasses
import pathlib
import struct
import sys
import zlib

import numpy

WIDTH, HEIGHT, RATE = 960, 540, 30
HIDDEN = 0.25  # an object of which less than this part is visible is never found, and not counted
EMBEDDING = 16  # numbers of a vector
CELL = 2        # pixels: the grid on which the visible part is counted


@dataclasses.dataclass(frozen=True)
class Scene:
    """What is in a scene and what a detector makes of it. docs/tracking.md explains each number."""
    frames: int = 300
    objects: int = 10        # at a time
    lanes: float = 200       # pixels from the lowest to the highest feet
    speed: float = 90        # pixels per second, of the fastest
    sway: float = 6          # pixels, of a sine on top of the straight way
    pillars: int = 0         # that hide what is behind them
    shake: float = 0         # pixels, of the camera's oscillation
    jolts: float = 0         # per second: jumps of the camera of up to 2 * shake
    found: float = 0.97      # probability that a visible object is found
    false_alarms: float = 0.2  # per frame
    jitter: float = 0.02     # standard deviation of a box's centre and size, as a part of its size


SCENES = {
    "crossings": Scene(lanes=30, speed=150),
    "occlusion": Scene(pillars=4),
    "shake": Scene(shake=25, jolts=0.5),
    "missed": Scene(found=0.7),
    "false-alarms": Scene(false_alarms=4),
    "jitter": Scene(jitter=0.08),
    "all": Scene(lanes=60, speed=120, pillars=2, shake=12, jolts=0.2, found=0.85, false_alarms=2, jitter=0.04),
}


@dataclasses.dataclass
class Walker:
    """An object: where it is at each time."""
    number: int
    begin: float
    feet: numpy.ndarray      # x and y of the middle of the lower edge at `begin`
    speed: numpy.ndarray
    size: numpy.ndarray
    sway: float
    period: float
    phase: float

    def box(self, time, shift):
        passed = time - self.begin
        x, y = self.feet + self.speed * passed + shift
        x += self.sway * numpy.sin(2 * numpy.pi * passed / self.period + self.phase)
        return numpy.array([x - self.size[0] / 2, y - self.size[1], x + self.size[0] / 2, y])


@dataclasses.dataclass
class Frame:
    numbers: numpy.ndarray     # of the objects in the picture
    boxes: numpy.ndarray       # x1, y1, x2, y2 in pixels from 0
    visible: numpy.ndarray     # 0 to 1
    found: numpy.ndarray       # x1, y1, x2, y2, score of what the detector finds
    embeddings: numpy.ndarray  # a unit vector of each
    pillars: numpy.ndarray     # x1, y1, x2, y2


def new_walker(scene, random, number, begin, at_border):
    height = random.uniform(70, 120)
    size = numpy.array([0.4 * height, height])
    direction = random.choice([-1.0, 1.0])
    pace = direction * random.uniform(0.4, 1) * scene.speed
    x = random.uniform(0, WIDTH) if not at_border else (0.0 if direction > 0 else float(WIDTH))
    y = HEIGHT * 0.65 + random.uniform(-0.5, 0.5) * scene.lanes
    return Walker(number, begin, numpy.array([x, y]), numpy.array([pace, random.normal(0, 2)]), size, scene.sway,
                  random.uniform(1.5, 3), random.uniform(0, 2 * numpy.pi))


def make_shifts(scene, random):
    """How far the camera moved the picture, for each frame: two sines, and jolts that decay in a quarter of a second."""
    time = numpy.arange(scene.frames) / RATE
    phases, rates = random.uniform(0, 2 * numpy.pi, 4), random.uniform(0.7, 2.2, 4)
    shift = numpy.zeros((scene.frames, 2))
    for axis in (0, 1):
        for k in (2 * axis, 2 * axis + 1):
            shift[:, axis] += scene.shake / 2 * numpy.sin(2 * numpy.pi * rates[k] * time + phases[k])
    for start in numpy.flatnonzero(random.random(scene.frames) < scene.jolts / RATE):
        size = random.uniform(-2, 2, 2) * scene.shake
        shift[start:] += size * numpy.exp(-(time[start:, None] - time[start]) / 0.25)
    return shift


def clipped(boxes):
    return numpy.clip(boxes, 0, [WIDTH, HEIGHT, WIDTH, HEIGHT])


def visible_parts(boxes, pillars):
    """The part of each box that no nearer box (one whose feet are lower) and no pillar covers, on a grid of CELL pixels."""
    order = numpy.argsort(-boxes[:, 3])
    taken = numpy.zeros((HEIGHT // CELL + 1, WIDTH // CELL + 1), bool)
    out = numpy.ones(len(boxes))

    def region(box):
        x1, y1, x2, y2 = (int(round(edge / CELL)) for edge in clipped(box))
        return slice(y1, max(y2, y1 + 1)), slice(x1, max(x2, x1 + 1))
    for pillar in pillars:
        taken[region(pillar)] = True
    for i in order:
        out[i] = 1 - taken[region(boxes[i])].mean()
        taken[region(boxes[i])] = True
    return out


def unit(vectors):
    return vectors / numpy.maximum(numpy.linalg.norm(vectors, axis=-1, keepdims=True), 1e-12)


def detections(scene, random, boxes, visible, appearances):
    """What a detector finds: x1, y1, x2, y2, score, and the vectors."""
    rows, vectors = [], []
    for box, part, appearance in zip(boxes, visible, appearances):
        chance = scene.found * min(max((part - HIDDEN) / 0.2, 0), 1)
        noise, is_found = random.normal(size=4), random.random() < chance
        score, blur = random.normal(0, 0.05), random.normal(size=EMBEDDING)
        if not is_found:
            continue
        size = box[2:] - box[:2]
        centre = (box[:2] + box[2:]) / 2 + scene.jitter * size * noise[:2]
        half = size / 2 * numpy.exp(scene.jitter * noise[2:])
        rows.append([*(centre - half), *(centre + half), min(max(0.1 + 0.85 * part + score, 0.05), 0.99)])
        vectors.append(unit(appearance + (0.08 + 0.3 * (1 - part)) * blur))
    for _ in range(random.poisson(scene.false_alarms)):
        height = random.uniform(70, 120)
        x, y = random.uniform(0, WIDTH - 0.4 * height), random.uniform(0, HEIGHT - height)
        rows.append([x, y, x + 0.4 * height, y + height, random.beta(2, 3)])
        vectors.append(unit(random.normal(size=EMBEDDING)))
    order = random.permutation(len(rows))
    found = numpy.array(rows).reshape(-1, 5)[order]
    found[:, :4] = clipped(found[:, :4])
    return found.round(3), numpy.array(vectors).reshape(-1, EMBEDDING)[order].astype(numpy.float32)


def make(scene, seed):
    """The frames of a scene."""
    random = numpy.random.default_rng(seed)
    walkers = [new_walker(scene, random, i + 1, 0, False) for i in range(scene.objects)]
    appearances = list(unit(random.normal(size=(scene.objects, EMBEDDING))))
    places = (numpy.arange(scene.pillars) + 0.5) * WIDTH / max(scene.pillars, 1)
    pillars = numpy.array([[x - 25, 0, x + 25, HEIGHT] for x in places]).reshape(-1, 4)
    shifts = make_shifts(scene, random)
    count, out = scene.objects, []
    for i in range(scene.frames):
        time = i / RATE
        for k, walker in enumerate(walkers):
            x = walker.feet[0] + walker.speed[0] * (time - walker.begin)
            if not -1 <= x <= WIDTH + 1:  # gone: another one comes
                count += 1
                walkers[k] = new_walker(scene, random, count, time, True)
                appearances.append(unit(random.normal(size=EMBEDDING)))
        whole = numpy.array([walker.box(time, shifts[i]) for walker in walkers])
        middle = (whole[:, 0] + whole[:, 2]) / 2
        inside = (middle > 1) & (middle < WIDTH - 1)
        boxes = clipped(whole[inside]).round(3)  # as the files have them
        numbers = numpy.array([walker.number for walker in walkers])[inside]
        moved = pillars + numpy.tile(shifts[i], 2)
        visible = visible_parts(boxes, moved)
        found, embeddings = detections(scene, random, boxes, visible, [appearances[n - 1] for n in numbers])
        out.append(Frame(numbers, boxes, visible, found, embeddings, moved))
    return out


def write_png(path, grey):
    """A grey PNG (https://www.w3.org/TR/png/)."""
    def chunk(kind, content):
        return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))
    lines = numpy.pad(grey, ((0, 0), (1, 0))).tobytes()  # each line begins with its filter, 0
    head = struct.pack(">IIBBBBB", grey.shape[1], grey.shape[0], 8, 0, 0, 0, 0)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(lines, 1)) + chunk(b"IEND", b""))


def picture(frame):
    """Objects as grey rectangles, the nearest last; pillars are black."""
    out = numpy.full((HEIGHT, WIDTH), 230, numpy.uint8)
    for i in numpy.argsort(frame.boxes[:, 3]):
        x1, y1, x2, y2 = frame.boxes[i].astype(int)
        out[y1:y2, x1:x2] = 40 + frame.numbers[i] * 37 % 160
    for x1, y1, x2, y2 in clipped(frame.pillars).astype(int):
        out[y1:y2, x1:x2] = 0
    return out


def truth_lines(frames):
    """frame,id,x,y,width,height,flag,class,visibility; frames and pixels count from 1. What is hidden has the flag 0."""
    for i, frame in enumerate(frames, 1):
        for number, (x1, y1, x2, y2), part in zip(frame.numbers, frame.boxes, frame.visible):
            yield f"{i},{number},{x1 + 1:.3f},{y1 + 1:.3f},{x2 - x1:.3f},{y2 - y1:.3f},{int(part >= HIDDEN)},1,{part:.3f}"


def found_lines(frames):
    """frame,-1,x,y,width,height,score; frames and pixels count from 1."""
    for i, frame in enumerate(frames, 1):
        for x1, y1, x2, y2, score in frame.found:
            yield f"{i},-1,{x1 + 1:.3f},{y1 + 1:.3f},{x2 - x1:.3f},{y2 - y1:.3f},{score:.3f}"


def write(folder, frames, pictures=False, embeddings=False):
    folder = pathlib.Path(folder)
    for name in ("gt", "det") + (("img1",) if pictures else ()):
        (folder / name).mkdir(parents=True, exist_ok=True)
    (folder / "gt" / "gt.txt").write_text("".join(line + "\n" for line in truth_lines(frames)))
    (folder / "det" / "det.txt").write_text("".join(line + "\n" for line in found_lines(frames)))
    info = {"name": folder.name, "imDir": "img1", "frameRate": RATE, "seqLength": len(frames), "imWidth": WIDTH, "imHeight": HEIGHT,
            "imExt": ".png"}
    (folder / "seqinfo.ini").write_text("[Sequence]\n" + "".join(f"{key}={value}\n" for key, value in info.items()))
    if embeddings:
        numpy.save(folder / "det" / "embeddings.npy", numpy.concatenate([frame.embeddings for frame in frames]))
    if pictures:
        for i, frame in enumerate(frames, 1):
            write_png(folder / "img1" / f"{i:06}.png", picture(frame))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--scenes", default=",".join(SCENES), help="which of " + ", ".join(SCENES))
    parser.add_argument("--seeds", default="1", help="one sequence of each scene for each number")
    parser.add_argument("--frames", type=int, help="of each sequence, 300")
    parser.add_argument("--pictures", action="store_true", help="draw them too")
    parser.add_argument("--embeddings", action="store_true", help="a vector for each line of det.txt too")
    options = parser.parse_args()
    scenes = options.scenes.split(",")
    if unknown := [name for name in scenes if name not in SCENES]:
        sys.exit(f"sequences.py: there is no scene {unknown[0]}\n  fix: --scenes {','.join(SCENES)}")
    if not all(seed.isdecimal() for seed in options.seeds.split(",")):
        sys.exit(f"sequences.py: --seeds {options.seeds}: seeds are whole numbers\n  fix: --seeds 1,2,3")
    if options.frames is not None and options.frames < 1:
        sys.exit(f"sequences.py: --frames {options.frames}: a sequence has at least one frame\n  fix: --frames 300")
    for name in scenes:
        for seed in options.seeds.split(","):
            scene = dataclasses.replace(SCENES[name], frames=options.frames or SCENES[name].frames)
            folder = options.folder / f"{name}-{seed}"
            write(folder, make(scene, int(seed)), options.pictures, options.embeddings)
            print(folder)


if __name__ == "__main__":
    main()
