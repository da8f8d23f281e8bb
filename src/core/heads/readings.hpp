// The modes of tensor_decoder in which the outputs of a model can be read.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/heads/head.hpp"

namespace weir::heads {

// The modes that read the outputs of models, the first one first.
inline constexpr std::pair<const char*, Task> kReadingModes[] = {
    {"text", kText},
    {"detection", kDetection},
    {"pose", kPose},
    {"segmentation", kSegmentation},
    {"classification", kClassification},
    {"depth", kDepth}};

// The tasks that the metadata of the model leaves, as Ultralytics writes them; else those of all
// kReadingModes.
uint32_t stated_tasks(const ModelSignature& facts);

struct Reading {
  std::string mode;
  const Family* family = nullptr;
};

// The families that can read the outputs, each with the first mode that shows it. `tasks` are those
// of kReadingModes that count.
std::vector<Reading> list_readings(const ModelSignature& facts, uint32_t tasks);

// Those that names or metadata make certain, if any; else those of rows and points, whose shapes
// say more than the shapes of maps and lists of scores do.
std::vector<Reading> likely(const std::vector<Reading>& readings, const ModelSignature& facts);

// The only likely one; nullopt for none or several.
std::optional<Reading> only_reading(const ModelSignature& facts);

}  // namespace weir::heads
