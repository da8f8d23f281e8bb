// Tells the YOLO families apart and opens them.
//
// Rows of one family are rows of another with other classes: 85 numbers are a box and 81 classes,
// or a box, an objectness and 80 classes. What decides is the task in the model's metadata, then
// the number of labels, then what is usual: models of the 80 classes of COCO, and planes (all cells
// of a number together) of v8 and later. Where these contradict, both families are certain, and the
// user is asked.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <optional>
#include <string_view>
#include <utility>

#include "core/heads/dense_head.hpp"
#include "core/heads/families.hpp"
#include "core/tensor/geometry.hpp"
#include "core/text/text.hpp"

namespace weir::heads {
namespace {

constexpr size_t kBoxValues = 4, kCocoClasses = 80;

// The outputs of a detector of cells: rows, and prototype masks if there are two.
struct YoloOutputs {
  size_t output = 0;
  DenseLayout layout;
  std::optional<PrototypeFacts> prototypes{};
};

// Numbers of key points of the model's metadata: "[17, 3]".
struct PointShape {
  size_t points = 0, length = 3;
};

// Prototypes have the input's aspect, usually a quarter of its width and height. Without an input
// size they are square.
std::optional<PrototypeFacts> find_prototypes(const Shape& shape, size_t output, Size input) {
  if (shape.min_rank() != 3) return std::nullopt;
  const auto is_grid = [&](uint32_t width, uint32_t height, uint32_t count) {
    if (input.width == 0) return width == height && count < width;
    return uint64_t{width} * input.height == uint64_t{height} * input.width;
  };
  if (is_grid(shape[0], shape[1], shape[2]))
    return PrototypeFacts{output, shape[0], shape[1], shape[2], false};
  if (is_grid(shape[1], shape[2], shape[0]))
    return PrototypeFacts{output, shape[1], shape[2], shape[0], true};
  return std::nullopt;
}

template <class FindLayout>
std::optional<YoloOutputs> find_outputs(const ModelSignature& model, bool has_prototypes,
                                        FindLayout find_layout) {
  if (model.outputs.size() != (has_prototypes ? 2 : 1)) return std::nullopt;
  for (size_t i = 0; i < model.outputs.size(); ++i) {
    const auto layout = find_layout(model.outputs[i].shape, model.input);
    if (!layout) continue;
    YoloOutputs out{.output = i, .layout = *layout};
    if (!has_prototypes) return out;
    const auto input = model.input.width > 0 ? model.input : layout->input;
    out.prototypes = find_prototypes(model.outputs[1 - i].shape, 1 - i, input);
    if (out.prototypes) return out;
  }
  return std::nullopt;
}

// nullopt if the outputs are not one of rows with `anchors` a cell, with or without prototypes.
std::optional<YoloOutputs> find_yolo_outputs(const ModelSignature& model, size_t anchors,
                                             bool has_prototypes) {
  return find_outputs(model, has_prototypes,
                      [&](const Shape& shape, Size input) -> std::optional<DenseLayout> {
                        auto layout = find_dense_layout(shape, input);
                        if (layout && layout->anchors == anchors) return layout;
                        return std::nullopt;
                      });
}

// For a family that the user named: rows whose number no grid explains too.
std::optional<YoloOutputs> any_yolo_outputs(const ModelSignature& model, bool has_prototypes) {
  return find_outputs(model, has_prototypes, any_dense_layout);
}

// Whether the model's metadata says that it is for `task` (detect, segment, pose, obb, as
// Ultralytics writes it); nullopt if it reports nothing.
std::optional<bool> is_for_task(const ModelSignature& model, std::string_view task) {
  const auto stated = metadata(model, "task");
  return stated.empty() ? std::nullopt : std::optional(equal_ignoring_case(stated, task));
}

std::optional<PointShape> point_shape(const ModelSignature& model) {
  std::string_view text = strip(metadata(model, "kpt_shape"));
  if (!text.starts_with('[') || !text.ends_with(']')) return std::nullopt;
  const auto parts = split(text.substr(1, text.size() - 2), ",");
  if (parts.size() != 2) return std::nullopt;
  const auto points = parse_unsigned(strip(parts[0])), length = parse_unsigned(strip(parts[1]));
  const bool is_good =
      points && length && *points > 0 && *points < 1024 && (*length == 2 || *length == 3);
  return is_good ? std::optional(PointShape{*points, *length}) : std::nullopt;
}

constexpr size_t kWithObjectness = kBoxValues + 1, kAngle = 1;
constexpr size_t kCocoPoints = size_t{3} * 17, kDotaClasses = 15;

// `usual`: what decides if neither metadata nor labels do.
Match make_fit(const ModelSignature& model, std::string_view task, size_t classes, bool usual) {
  if (const auto is_for = is_for_task(model, task)) return *is_for ? Match::Certain : Match::No;
  if (model.labels > 0 && model.labels == classes) return Match::Certain;
  return usual ? Match::Certain : Match::Possible;
}

// Whether the labels, or the classes of DOTA without labels, fit a reading of the row other than
// box and classes.
bool is_another(const ModelSignature& model, size_t values) {
  if (model.labels == 0) return values == kBoxValues + kDotaClasses + kAngle;
  return model.labels + kWithObjectness == values ||
         model.labels + kBoxValues + kCocoPoints == values;
}

Match fit_yolov8(const ModelSignature& model) {
  const auto outputs = find_yolo_outputs(model, 1, false);
  if (!outputs || outputs->layout.values <= kBoxValues) return Match::No;
  const size_t classes = outputs->layout.values - kBoxValues;
  const bool is_usual = outputs->layout.rows_are_inner || classes == kCocoClasses;
  return make_fit(model, "detect", classes, is_usual && !is_another(model, outputs->layout.values));
}

Match fit_yolov8_obb(const ModelSignature& model) {
  const auto outputs = find_yolo_outputs(model, 1, false);
  if (!outputs || outputs->layout.values <= kBoxValues + kAngle) return Match::No;
  const size_t classes = outputs->layout.values - kBoxValues - kAngle;
  const bool is_usual = model.labels == 0 && classes == kDotaClasses;
  const Match fit = make_fit(model, "obb", classes, is_usual);
  // Labels cannot tell an angle from an objectness; the order of dimensions can.
  const bool is_named = is_for_task(model, "obb").has_value();
  return fit == Match::Certain && !is_named && !outputs->layout.rows_are_inner ? Match::Possible
                                                                               : fit;
}

Match fit_yolox(const ModelSignature& model) {
  const auto outputs = find_yolo_outputs(model, 1, false);
  if (!outputs || outputs->layout.values <= kWithObjectness) return Match::No;
  if (!metadata(model, "task").empty()) return Match::No;
  const size_t classes = outputs->layout.values - kWithObjectness;
  const Match fit = make_fit(model, "", classes, model.labels == 0 && classes == kCocoClasses);
  const bool are_labels = model.labels > 0 && fit == Match::Certain;
  return are_labels && outputs->layout.rows_are_inner ? Match::Possible : fit;
}

// Numbers of key points in a row; nullopt if they do not fit.
std::optional<PointShape> points_in(const ModelSignature& model, size_t values) {
  if (const auto shape = point_shape(model))
    return shape->points * shape->length + kBoxValues < values ? shape : std::nullopt;
  for (const size_t classes : {model.labels, size_t{1}}) {
    if (classes == 0 || values <= kBoxValues + classes) continue;
    const size_t numbers = values - kBoxValues - classes;
    if (numbers % 3 == 0) return PointShape{numbers / 3, 3};
  }
  return std::nullopt;
}

Match fit_yolov8_pose(const ModelSignature& model) {
  const auto outputs = find_yolo_outputs(model, 1, false);
  if (!outputs) return Match::No;
  const auto shape = points_in(model, outputs->layout.values);
  if (!shape) return Match::No;
  if (const auto is_for = is_for_task(model, "pose")) return *is_for ? Match::Certain : Match::No;
  const size_t numbers = shape->points * shape->length;
  const size_t classes = outputs->layout.values - kBoxValues - numbers;
  const bool are_labels = model.labels == 0 || model.labels == classes;
  return numbers == kCocoPoints && are_labels ? Match::Certain : Match::Possible;
}

Match fit_yolov5(const ModelSignature& model) {
  const auto outputs = find_yolo_outputs(model, 3, false);
  return outputs && outputs->layout.values > kWithObjectness ? Match::Possible : Match::No;
}

// Rows with weights of prototypes.
Match fit_segmentation(const ModelSignature& model, size_t anchors, size_t fixed) {
  const auto outputs = find_yolo_outputs(model, anchors, true);
  return outputs && outputs->layout.values > fixed + outputs->prototypes->count ? Match::Possible
                                                                                : Match::No;
}
Match fit_yolov8_segmentation(const ModelSignature& model) {
  return fit_segmentation(model, 1, kBoxValues);
}
Match fit_yolov5_segmentation(const ModelSignature& model) {
  return fit_segmentation(model, 3, kWithObjectness);
}

// The outputs, with the exact layout where there is one.
YoloOutputs get_outputs(const ModelSignature& model, const Family& family, size_t anchors,
                        bool has_prototypes) {
  auto outputs = find_yolo_outputs(model, anchors, has_prototypes);
  if (!outputs) outputs = any_yolo_outputs(model, has_prototypes);
  if (!outputs) throw wrong_outputs(model, family);
  return *outputs;
}

// `extra`: numbers of a row after the classes.
std::unique_ptr<Head> open(const ModelSignature& model, const HeadOptions& options,
                           const Family& family, const YoloOutputs& outputs, DenseSpec spec,
                           size_t extra) {
  const size_t before = kBoxValues + (spec.has_objectness ? 1 : 0);
  if (outputs.layout.values <= before + extra) throw wrong_outputs(model, family);
  spec.layout = outputs.layout;
  spec.output = outputs.output;
  spec.prototypes = outputs.prototypes;
  spec.classes = outputs.layout.values - before - extra;
  if (!spec.may_be_cells) spec.unit = unit_setting(options);
  return std::make_unique<DenseHead>(std::move(spec), options.threshold);
}

std::unique_ptr<Head> open_yolov8(const ModelSignature& model, const HeadOptions& options) {
  return open(model, options, kYolov8, get_outputs(model, kYolov8, 1, false), {}, 0);
}

std::unique_ptr<Head> open_yolov8_obb(const ModelSignature& model, const HeadOptions& options) {
  return open(model, options, kYolov8Obb, get_outputs(model, kYolov8Obb, 1, false),
              {.has_angle = true}, kAngle);
}

std::unique_ptr<Head> open_yolov8_pose(const ModelSignature& model, const HeadOptions& options) {
  const YoloOutputs outputs = get_outputs(model, kYolov8Pose, 1, false);
  std::optional<PointShape> shape;
  if (const auto points = number_setting(options, "keypoints", 1, 1024)) {
    shape = {static_cast<size_t>(*points), 3};
    if (outputs.layout.values <= kBoxValues + shape->points * 3) shape->length = 2;
    if (outputs.layout.values <= kBoxValues + shape->points * 2)
      throw wrong_setting(options, "keypoints",
                          "key points of 2 or 3 numbers that fit into a row of " +
                              std::to_string(outputs.layout.values),
                          "17");
  } else {
    shape = points_in(model, outputs.layout.values);
  }
  if (!shape) throw wrong_outputs(model, kYolov8Pose);
  return open(model, options, kYolov8Pose, outputs,
              {.points = shape->points, .point_length = shape->length},
              shape->points * shape->length);
}

std::unique_ptr<Head> open_yolov8_segmentation(const ModelSignature& model,
                                               const HeadOptions& options) {
  const YoloOutputs outputs = get_outputs(model, kYolov8Segmentation, 1, true);
  return open(model, options, kYolov8Segmentation, outputs, {}, outputs.prototypes->count);
}

std::unique_ptr<Head> open_yolov5(const ModelSignature& model, const HeadOptions& options) {
  return open(model, options, kYolov5, get_outputs(model, kYolov5, 3, false),
              {.has_objectness = true}, 0);
}

std::unique_ptr<Head> open_yolov5_segmentation(const ModelSignature& model,
                                               const HeadOptions& options) {
  const YoloOutputs outputs = get_outputs(model, kYolov5Segmentation, 3, true);
  return open(model, options, kYolov5Segmentation, outputs, {.has_objectness = true},
              outputs.prototypes->count);
}

std::unique_ptr<Head> open_yolox(const ModelSignature& model, const HeadOptions& options) {
  const auto word = word_setting(options, "unit", {"pixels", "picture", "cells"});
  constexpr Unit kUnits[] = {Unit::Pixels, Unit::Picture, Unit::Cells};
  return open(model, options, kYolox, get_outputs(model, kYolox, 1, false),
              {.has_objectness = true,
               .unit = word ? kUnits[*word] : Unit::Automatic,
               .may_be_cells = true},
              0);
}

}  // namespace

const Family kYolov8{.name = "yolov8",
                     .aliases = "yolov9,yolov11,yolov12,yolo11,yolo12",
                     .tasks = kDetection,
                     .outputs = "1 tensor N:4+CLASSES or 4+CLASSES:N",
                     .custom = "unit",
                     .threshold = 0.25f,
                     .fit = fit_yolov8,
                     .open = open_yolov8};

const Family kYolov8Segmentation{
    .name = "yolov8-seg",
    .aliases = "yolov9-seg,yolov11-seg,yolov12-seg,yolo11-seg,yolo12-seg",
    .tasks = kDetection | kSegmentation,
    .outputs = "N:4+CLASSES+M or 4+CLASSES+M:N, and prototypes W:H:M or M:W:H",
    .custom = "unit",
    .threshold = 0.25f,
    .fit = fit_yolov8_segmentation,
    .open = open_yolov8_segmentation};

const Family kYolov8Pose{.name = "yolov8-pose",
                         .aliases = "yolov11-pose,yolov12-pose,yolo11-pose,yolo12-pose",
                         .tasks = kDetection | kPose,
                         .outputs = "1 tensor N:4+CLASSES+3*POINTS or 4+CLASSES+3*POINTS:N",
                         .custom = "unit,keypoints",
                         .threshold = 0.25f,
                         .fit = fit_yolov8_pose,
                         .open = open_yolov8_pose};

const Family kYolov8Obb{.name = "yolov8-obb",
                        .aliases = "yolov11-obb,yolov12-obb,yolo11-obb,yolo12-obb",
                        .tasks = kDetection,
                        .outputs = "1 tensor N:4+CLASSES+1 or 4+CLASSES+1:N, the angle last",
                        .custom = "unit",
                        .threshold = 0.25f,
                        .fit = fit_yolov8_obb,
                        .open = open_yolov8_obb};

const Family kYolov5{.name = "yolov5",
                     .aliases = "yolov3,yolov7",
                     .tasks = kDetection,
                     .outputs = "1 tensor 5+CLASSES:N or N:5+CLASSES, three rows a cell",
                     .custom = "unit",
                     .threshold = 0.25f,
                     .fit = fit_yolov5,
                     .open = open_yolov5};

const Family kYolov5Segmentation{
    .name = "yolov5-seg",
    .aliases = "yolov7-seg",
    .tasks = kDetection | kSegmentation,
    .outputs = "5+CLASSES+M:N or N:5+CLASSES+M, and prototypes W:H:M or M:W:H",
    .custom = "unit",
    .threshold = 0.25f,
    .fit = fit_yolov5_segmentation,
    .open = open_yolov5_segmentation};

const Family kYolox{.name = "yolox",
                    .aliases = "yolov6",
                    .tasks = kDetection,
                    .outputs = "1 tensor 5+CLASSES:N or N:5+CLASSES, one row a cell",
                    .custom = "unit",
                    .threshold = 0.25f,
                    .fit = fit_yolox,
                    .open = open_yolox};

}  // namespace weir::heads
