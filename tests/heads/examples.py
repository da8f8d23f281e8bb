# SPDX-License-Identifier: LGPL-2.1-or-later
"""The table of heads: who makes their outputs, in which orders and element types, and what must be set to read them."""

import dataclasses

import bodies
import detectors
import maps
import yolo

FLOATS, ALL = ("float32", "float16"), ("float32", "float16", "uint8", "int8")


@dataclasses.dataclass
class Entry:
    encode: object  # a function of order and element type that gives an Example
    modes: tuple
    orders: tuple = ("rows",)
    kinds: tuple = ALL
    unnamed: tuple = ()  # orders that other heads have too: without its name they are an error that names both
    likelier: tuple = ()  # orders that are read as those of another head, because models of that one are usual


PLANES = ("planes", "rows")
HEADS = {
    "blazeface": Entry(detectors.blazeface, ("detection", "pose"), ("short boxes first", "back scores first", "full boxes first")),
    "blazepose": Entry(bodies.blazepose, ("pose",), ("195", "165", "156", "132"), FLOATS),
    "blazepose-detection": Entry(detectors.blazepose_detection, ("detection", "pose"), ("224 boxes first", "128 scores first")),
    "class-map": Entry(maps.class_map, ("segmentation",), ("uint8", "int32", "int64"), ("float32",)),
    "classifier": Entry(maps.classifier, ("classification",), ("logits", "probabilities")),
    "ctc": Entry(maps.ctc, ("text",), ("CLASSES:STEPS", "CLASSES:1:STEPS", "CLASSES:1:STEPS logits")),
    "db": Entry(maps.db, ("text", "detection"), ("upright", "turned")),
    "deeplab": Entry(maps.deeplab, ("segmentation",), ("planes", "rows", "one class")),
    "depth": Entry(maps.depth, ("depth",), ("W:H", "1:W:H", "W:H:1")),
    "detection-output": Entry(detectors.detection_output, ("detection",), ("parts", "pixels"), unnamed=("parts", "pixels")),
    "detr": Entry(detectors.detr, ("detection",), ("logits first", "boxes first"), unnamed=("logits first", "boxes first")),
    "face-landmarks": Entry(bodies.face_landmarks, ("pose",), ("468", "478"), FLOATS),
    "fastestdet": Entry(yolo.fastestdet, ("detection",)),
    "hand-landmarks": Entry(bodies.hand_landmarks, ("pose",), ("right", "left"), FLOATS),
    "heat-maps": Entry(bodies.heat_maps, ("pose",), PLANES),
    "labels-boxes-scores": Entry(detectors.labels_boxes_scores, ("detection",),
                                 ("labels,boxes,scores", "boxes,labels,scores", "scores,boxes,labels", "dets,labels", "labels,dets")),
    "movenet": Entry(bodies.movenet, ("pose",)),
    "movenet-multipose": Entry(bodies.movenet_multipose, ("pose",)),
    "nanodet": Entry(yolo.nanodet, ("detection",), PLANES, likelier=("planes",)),
    "palm-detection": Entry(detectors.palm_detection, ("detection", "pose"), ("192 boxes first", "256 scores first")),
    "posenet": Entry(bodies.posenet, ("pose",), ("one", "two", "joined")),
    "rtdetr": Entry(detectors.rtdetr, ("detection",), ("logits first", "boxes first", "joined"), unnamed=("logits first", "boxes first")),
    "ssd": Entry(detectors.ssd, ("detection",), ("boxes first", "scores first")),
    "ssd-postprocess": Entry(detectors.ssd_postprocess, ("detection",),
                             ("boxes,classes,scores,count", "scores,count,boxes,classes")),
    "ultraface": Entry(detectors.ultraface, ("detection",), ("scores first", "boxes first")),
    "ultraface-raw": Entry(detectors.ultraface_raw, ("detection",), ("scores first", "boxes first"),
                           unnamed=("scores first", "boxes first")),
    "yolo-nas": Entry(yolo.yolo_nas, ("detection",), ("scores first", "boxes first", "boxes first planes")),
    "yolov10": Entry(yolo.yolov10, ("detection",), ("pixels", "parts"), ("float32", "float16", "uint8")),
    "yolov3-grids": Entry(yolo.yolov3_grids, ("detection",), (*PLANES, "anchors"), unnamed=(*PLANES, "anchors")),
    "yolov5": Entry(yolo.yolov5, ("detection",), PLANES),
    "yolov5-grids": Entry(yolo.yolov5_grids, ("detection",), (*PLANES, "anchors"), unnamed=(*PLANES, "anchors")),
    "yolov5-seg": Entry(yolo.yolov5_seg, ("segmentation",), PLANES),
    "yolov7-end2end": Entry(yolo.yolov7_end2end, ("detection",), ("pixels", "parts"), ("float32", "float16", "uint8"),
                            unnamed=("pixels", "parts")),
    "yolov7-grids": Entry(yolo.yolov7_grids, ("detection",), (*PLANES, "anchors"), unnamed=(*PLANES, "anchors")),
    "yolov8": Entry(yolo.yolov8, ("detection",), PLANES),
    "yolov8-obb": Entry(yolo.yolov8_obb, ("detection",), PLANES),
    "yolov8-pose": Entry(yolo.yolov8_pose, ("detection", "pose"), PLANES),
    "yolov8-seg": Entry(yolo.yolov8_seg, ("segmentation",), PLANES),
    "yolox": Entry(yolo.yolox, ("detection",), PLANES, likelier=("planes",)),
    "yunet": Entry(detectors.yunet, ("detection", "pose"), ("by kind", "by name")),
}
