// Paints and caches the masks of class names and percentages.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/draw/labels.hpp"

#include <algorithm>
#include <cmath>

namespace weir::draw {
namespace {

constexpr size_t kKept = 4096;  // names; a stream with ever new class numbers clears the cache

}  // namespace

Labels::Labels(std::vector<std::string> names, bool scores, std::shared_ptr<TextPainter> painter,
               const preprocess::PictureFormat& format)
    : names_(std::move(names)), painter_(std::move(painter)), format_(format) {
  if (!scores) return;
  for (int percent = 0; percent <= 100; ++percent)
    scores_.push_back(paint(std::to_string(percent) + " %"));
}

PlaneMask Labels::paint(const std::string& text) {
  ++painted_;
  return for_planes(painter_->paint(text), format_);
}

const PlaneMask* Labels::name(uint32_t class_index) {
  if (names_.empty()) return nullptr;
  if (const auto known = by_class_.find(class_index); known != by_class_.end())
    return &known->second;
  if (by_class_.size() == kKept) by_class_.clear();
  const bool named = class_index < names_.size();
  auto mask = paint(named ? names_[class_index] : std::to_string(class_index));
  return &by_class_.emplace(class_index, std::move(mask)).first->second;
}

const PlaneMask* Labels::score(float score) const {
  if (scores_.empty()) return nullptr;
  const double percent = std::clamp(std::floor(double{score} * 100 + 0.5), 0.0, 100.0);
  return &scores_[static_cast<size_t>(percent)];
}

}  // namespace weir::draw
