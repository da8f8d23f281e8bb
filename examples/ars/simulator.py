# SPDX-License-Identifier: LGPL-2.1-or-later
"""Simulates a person in a room: where the joints of a moving figure are, for one of five activities.

figure() moves a stick figure; event_camera.py and radio.py compute what the two kinds of sensors measure of it. README.md describes
the model. Lengths are metres, times seconds, angles radians; x points right, y away from the camera, z up, and the floor is z = 0.
"""

import numpy

ACTIVITIES = ("empty room", "walking", "falling", "waving", "sitting down")
CLIP_SECONDS = 4  # one activity, from its begin to its end
JOINTS = ("pelvis", "neck", "head", "left elbow", "left hand", "right elbow", "right hand", "left knee", "left foot", "right knee", "right foot")
# Joints that a limb connects, and the radius of the limb.
LIMBS = (("pelvis", "neck", 0.15), ("head", "head", 0.12), ("neck", "left elbow", 0.06), ("left elbow", "left hand", 0.05),
         ("neck", "right elbow", 0.06), ("right elbow", "right hand", 0.05), ("pelvis", "left knee", 0.09), ("left knee", "left foot", 0.07),
         ("pelvis", "right knee", 0.09), ("right knee", "right foot", 0.07))
UP = numpy.array([0.0, 0.0, 1.0])


def generator(seed, index):
    """The random numbers of clip `index`: each clip can be made without the others."""
    return numpy.random.default_rng([seed, index])


def ramp(time, begin, duration):
    """0 before `begin`, 1 after begin + duration, smooth between."""
    part = numpy.clip((time - begin) / duration, 0, 1)
    return part * part * (3 - 2 * part)


class Pose:
    """The angles of the figure over time; standing still unless an activity changes them."""

    def __init__(self, time, rng):
        still = numpy.zeros_like(time)
        self.size = rng.uniform(0.9, 1.1)  # of a person of 1.75 m
        self.heading = rng.uniform(0, 2 * numpy.pi)  # the direction of walking, falling and sitting, on the floor
        self.x = rng.uniform(-1.2, 1.2) + 0.015 * numpy.sin(2 * numpy.pi * rng.uniform(0.2, 0.5) * time + rng.uniform(0, 6))
        self.y = rng.uniform(2.6, 4.2) + still
        self.height = 0.86 + still  # of the pelvis, for a size of 1
        self.lean = 0.03 * numpy.sin(2 * numpy.pi * rng.uniform(0.2, 0.6) * time + rng.uniform(0, 6))
        self.thigh, self.knee = [still, still], [still + 0.05, still + 0.05]
        self.arm, self.elbow, self.raised = [still + 0.1, still - 0.1], [still + 0.2, still + 0.2], [still + 0.15, still + 0.15]

    def fidget(self, time, rng, weight):
        """Small movements of arms and legs, where `weight` is not 0."""
        for angles in (self.arm, self.elbow, self.thigh):
            for side in (0, 1):
                turn = 2 * numpy.pi * rng.uniform(0.5, 1.6) * time + rng.uniform(0, 6)
                angles[side] = angles[side] + weight * rng.uniform(0.08, 0.25) * numpy.sin(turn)


def walk(pose, time, rng):
    speed, steps = rng.uniform(0.6, 1.4), 2 * numpy.pi * rng.uniform(0.75, 1.1) * time + rng.uniform(0, 6)
    # There and back between x = -1.6 and 1.6, mostly across the view.
    pose.heading = rng.uniform(-0.5, 0.5)
    way = pose.x + 1.6 + rng.choice([-1, 1]) * speed * time
    pose.x = numpy.abs((way % 6.4) - 3.2) - 1.6
    pose.y = pose.y + (pose.x * numpy.sin(pose.heading))
    for side, sign in ((0, 1), (1, -1)):
        pose.thigh[side] = 0.45 * sign * numpy.sin(steps)
        pose.knee[side] = 0.1 + 0.7 * numpy.maximum(0, sign * numpy.cos(steps))
        pose.arm[side] = -0.4 * sign * numpy.sin(steps)
    pose.height = pose.height + 0.02 * numpy.cos(2 * steps)


def fall(pose, time, rng):
    begin, duration = rng.uniform(0.3, 1.0), rng.uniform(0.5, 0.9)
    down = numpy.clip((time - begin) / duration, 0, 1) ** 2  # faster and faster
    flail = (1 - ramp(time, begin + duration, 0.2)) * ramp(time, begin - 0.4, 0.3)
    turn = 2 * numpy.pi * rng.uniform(1.5, 2.5) * time
    pose.lean = pose.lean + down * rng.uniform(1.35, 1.55)
    pose.height = pose.height + down * (0.15 - 0.86)
    for side in (0, 1):
        pose.thigh[side] = pose.thigh[side] - down * rng.uniform(1.1, 1.5)
        pose.knee[side] = pose.knee[side] + down * rng.uniform(0.0, 0.6)
        pose.raised[side] = pose.raised[side] + flail * (0.8 + 0.5 * numpy.sin(turn + 3 * side))
    pose.fidget(time, rng, ramp(time, begin + duration, 0.3))


def wave(pose, time, rng):
    side, turn = rng.integers(2), 2 * numpy.pi * rng.uniform(0.9, 2.0) * time + rng.uniform(0, 6)
    pose.raised[side] = rng.uniform(1.2, 1.8) + 0.15 * numpy.sin(turn)
    pose.elbow[side] = 1.2 + rng.uniform(0.5, 0.9) * numpy.sin(turn)
    pose.fidget(time, rng, 0.1)


def sit_down(pose, time, rng):
    begin, duration = rng.uniform(0.3, 1.2), rng.uniform(0.8, 1.5)
    down = ramp(time, begin, duration)
    back = 0.35 * down
    pose.x, pose.y = pose.x - back * numpy.cos(pose.heading), pose.y - back * numpy.sin(pose.heading)
    pose.height = pose.height + down * (0.45 - 0.86)
    pose.lean = pose.lean + rng.uniform(0.4, 0.8) * numpy.sin(numpy.pi * down)
    for side in (0, 1):
        pose.thigh[side] = pose.thigh[side] + 1.45 * down
        pose.knee[side] = pose.knee[side] + 1.4 * down
        pose.arm[side] = pose.arm[side] + 0.6 * down
    pose.fidget(time, rng, 0.6 * down)


def find_joints(pose):
    """Positions of JOINTS: an array [times, joints, 3]."""
    forward = numpy.array([numpy.cos(pose.heading), numpy.sin(pose.heading), 0.0])
    sideways = numpy.cross(UP, forward)
    size, column = pose.size, lambda values: numpy.asarray(values)[:, None]
    trunk = column(numpy.cos(pose.lean)) * UP + column(numpy.sin(pose.lean)) * forward
    front = column(numpy.cos(pose.lean)) * forward - column(numpy.sin(pose.lean)) * UP
    at = {"pelvis": numpy.stack([pose.x, pose.y, size * pose.height], axis=1)}
    at["neck"] = at["pelvis"] + 0.52 * size * trunk
    at["head"] = at["neck"] + 0.22 * size * trunk
    for side, (name, sign) in enumerate((("left", 1), ("right", -1))):
        shoulder = at["neck"] + sign * 0.18 * size * sideways
        for joint, angle, start in (("elbow", pose.raised[side], shoulder), ("hand", pose.raised[side] + pose.elbow[side], None)):
            swing = column(numpy.sin(pose.arm[side])) * front - column(numpy.cos(pose.arm[side])) * trunk
            direction = column(numpy.cos(angle)) * swing + column(sign * numpy.sin(angle)) * sideways
            at[f"{name} {joint}"] = (at[f"{name} elbow"] if start is None else start) + 0.28 * size * direction
        hip = at["pelvis"] + sign * 0.1 * size * sideways
        for joint, angle, start in (("knee", pose.thigh[side], hip), ("foot", pose.thigh[side] - pose.knee[side], None)):
            direction = column(numpy.sin(angle)) * forward - column(numpy.cos(angle)) * UP
            at[f"{name} {joint}"] = (at[f"{name} knee"] if start is None else start) + 0.42 * size * direction
    places = numpy.stack([at[name] for name in JOINTS], axis=1)
    places[..., 2] = numpy.maximum(places[..., 2], 0.05)  # nothing sinks into the floor
    return places


def figure(activity, time, rng):
    """The joints of a person at these times, or None for an empty room."""
    if activity not in ACTIVITIES:
        raise ValueError(f"no activity {activity}: {', '.join(ACTIVITIES)}")
    if activity == "empty room":
        return None
    pose = Pose(time, rng)
    {"walking": walk, "falling": fall, "waving": wave, "sitting down": sit_down}[activity](pose, time, rng)
    return find_joints(pose)
