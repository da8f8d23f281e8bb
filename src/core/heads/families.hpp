// The families of heads, and which of them fits a model.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/heads/head.hpp"

namespace weir::heads {

// In the order of the table of docs.
std::span<const Family* const> all_families();

// The family with this name or alias that has one of `tasks`. Throws Failure (OPTION_VALUE, with
// the names, and the nearest) if there is none. `option`: what comes before the name in the user's
// text.
const Family& family_named(std::string_view name, uint32_t tasks,
                           const std::string& option = "custom=head:");

// The families with one of `tasks` that fit the model: those that are certain, else those that are
// possible. Throws Failure (SPEC_MISMATCH) for outputs that open_head() refuses by their size.
std::vector<const Family*> fitting(const ModelSignature& model, uint32_t tasks);

// The only family of fitting(). Throws Failure (SPEC_MISMATCH): nothing_fits(); several fit, with
// custom=head: for each.
const Family& recognise(const ModelSignature& model, uint32_t tasks);

// The error that no family fits, with those that read the outputs if the user names them by
// `option` and their name, such as "--head ".
Error nothing_fits(const ModelSignature& model, uint32_t tasks, const std::string& option);

// Opens a head of this family. Throws Failure (SPEC_MISMATCH) for outputs without a size or with
// more than 2^31 elements, and what the family's open() throws.
std::unique_ptr<Head> open_head(const Family& family, const ModelSignature& model,
                                const HeadOptions& options);

// The families.

// Classifiers: one score for each class.
extern const Family kClassifier;

// Networks that give a depth for each pixel.
extern const Family kDepthMap;

// Detectors that give a set of objects: DETR, RT-DETR, and those that end in labels, boxes
// and scores.
extern const Family kDetr;    // logits with a class "no object", boxes
extern const Family kRtDetr;  // logits or probabilities, boxes
extern const Family kLabelsBoxesScores;

// Detectors that have removed duplicates themselves and give one row for each object.
// Rows of x1, y1, x2, y2, score, class.
extern const Family kYolov10;
// Rows of picture, x1, y1, x2, y2, class, score.
extern const Family kYolov7EndToEnd;
// Rows of picture, class, score, x1, y1, x2, y2: the layer DetectionOutput of Caffe and OpenVINO.
extern const Family kDetectionOutput;

// Face detectors: YuNet and UltraFace.
// Class, objectness, box and five key points of each cell of three grids.
extern const Family kYunet;
// Decoded boxes, and boxes relative to prior boxes.
extern const Family kUltraface, kUltrafaceRaw;

// Small detectors: FastestDet and NanoDet.
extern const Family kFastestDet, kNanoDet;
// YOLO-NAS, PP-YOLOE, DAMO-YOLO: the scores and the edges of the boxes are two outputs.
extern const Family kYoloNas;

// Networks that output one heat map for each key point, as HRNet does.
extern const Family kHeatMaps;
// The number of maps as that family reads them; 0 if it does not fit.
size_t points_of_heat_maps(const ModelSignature& model);
// Whether usual sets of key points have so many. Other maps may as well be scores of classes.
bool is_usual_of_points(size_t maps) noexcept;

// MediaPipe's landmark networks, which look at one hand, face or person.
extern const Family kBlazepose;      // 33 points with visibility
extern const Family kFaceLandmarks;  // 468 points, or 478 with irises
extern const Family kHandLandmarks;  // 21 points; class 0 = left, 1 = right

// MediaPipe's detectors of faces, palms and persons, which are relative to anchors.
extern const Family kBlazeface;           // 6 key points
extern const Family kPalmDetection;       // 7 key points, rotated boxes
extern const Family kBlazeposeDetection;  // 4 key points, rotated boxes of whole persons

// Networks that output the key points of persons: MoveNet.
extern const Family kMovenet;           // one person
extern const Family kMovenetMultipose;  // up to six

// PoseNet: heat maps, offsets, and vectors along the skeleton.
// Several persons if the model has the vectors between key points, otherwise the best one.
extern const Family kPosenet;

// Networks that give a class for each pixel.
extern const Family kDeepLab;   // scores of all classes, or of one
extern const Family kClassMap;  // numbers of classes

// SSD models: raw, and post-processed.
extern const Family kSsd;             // boxes relative to anchors, scores of classes
extern const Family kSsdPostprocess;  // TFLite_Detection_PostProcess

// Networks that find text (DB) and read it (CTC).
extern const Family kCtc;  // text recognition: characters of a line
extern const Family kDb;   // text detection: a map of probabilities

// YOLO v3, v5 and v7 whose boxes are not decoded: one output for each grid of cells.
extern const Family kYolov3Grids, kYolov5Grids, kYolov7Grids;

// The YOLO models whose coordinates are decoded, and YOLOX.
// v8, v9, v11 and v12: one anchor a cell, no objectness.
extern const Family kYolov8, kYolov8Segmentation, kYolov8Pose, kYolov8Obb;
// v3, v5 and v7: three anchors a cell, objectness.
extern const Family kYolov5, kYolov5Segmentation;
// YOLOX and v6: one anchor a cell, objectness.
extern const Family kYolox;

}  // namespace weir::heads
