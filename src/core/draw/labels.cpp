// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/draw/labels.hpp"

#include <algorithm>
#include <cmath>

namespace weir::draw {
namespace {

constexpr size_t kKept = 4096;  // texts; a stream with ever new ones clears the cache

}  // namespace

Labels::Labels(ClassNames names, bool scores, std::shared_ptr<TextPainter> painter,
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

void Labels::begin_picture() {
  if (by_text_.size() > kKept) by_text_.clear();
}

const PlaneMask* Labels::text(const std::string& text) {
  const auto known = by_text_.find(text);
  return known != by_text_.end() ? &known->second
                                 : &by_text_.emplace(text, paint(text)).first->second;
}

const PlaneMask* Labels::name(uint32_t source, uint32_t class_index) {
  if (source >= names_.size() || names_[source].empty()) return nullptr;
  const auto& names = names_[source];
  return text(class_index < names.size() ? names[class_index] : std::to_string(class_index));
}

const PlaneMask* Labels::score(float score) const {
  if (scores_.empty()) return nullptr;
  const double percent = std::clamp(std::floor(double{score} * 100 + 0.5), 0.0, 100.0);
  return &scores_[static_cast<size_t>(percent)];
}

}  // namespace weir::draw
