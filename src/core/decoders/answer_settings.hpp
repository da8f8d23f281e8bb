// The options that the modes detection, classification, segmentation, pose, depth and text share.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/detection/candidate.hpp"
#include "weir/module.hpp"

namespace weir::decoders {

struct AnswerSettings {
  std::optional<float> threshold;  // default: the head's
  float iou = 0.45f;
  size_t max_results = 100;
  std::vector<std::string> labels;
  std::vector<std::string> classes;  // names or numbers, as the user wrote them; empty = all
  std::string head;                  // "" = recognised
  detection::PictureSize input;      // of the model; 0 x 0 = from the stream
  std::string name;                  // weir-source; "" = the model's file
  std::map<std::string, std::string> custom;  // of the head

  // The class indices of `classes`, which are among `names` or numbers. Throws Failure
  // (OPTION_VALUE) for others.
  std::vector<int32_t> class_indices(const std::vector<std::string>& names) const;
};

// Throws Failure (OPTION_VALUE and those of label files) with the property's name.
AnswerSettings read_answer_settings(const Options& options);

// Declares these options for a mode whose heads have one of `tasks` (heads::Task).
std::string answer_options_json(uint32_t tasks);

}  // namespace weir::decoders
