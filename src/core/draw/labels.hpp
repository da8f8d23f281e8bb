// Labels: the texts of classes and scores as masks, each painted once.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <string>
#include <unordered_map>
#include <vector>

#include "core/draw/mask.hpp"

namespace weir::draw {

// Renders text; implemented where fonts are available.
class TextPainter {
 public:
  virtual ~TextPainter() = default;
  // Returns masks of the same height for all texts.
  virtual Mask paint(const std::string& text) = 0;
};

class Labels {
 public:
  // `names` are indexed by class; empty means that classes have no names. A class beyond a
  // non-empty list is labelled with its number. Paints the scores now and each name on first use.
  Labels(std::vector<std::string> names, bool scores, std::shared_ptr<TextPainter> painter,
         const preprocess::PictureFormat& format);

  // Null if there is nothing to show. Valid until the next call.
  const PlaneMask* name(uint32_t class_index);
  const PlaneMask* score(float score) const;  // in per cent, 0 to 100
  uint64_t painted() const noexcept { return painted_; }

 private:
  PlaneMask paint(const std::string& text);

  std::vector<std::string> names_;
  std::shared_ptr<TextPainter> painter_;
  preprocess::PictureFormat format_;
  std::vector<PlaneMask> scores_;
  std::unordered_map<uint32_t, PlaneMask> by_class_;
  uint64_t painted_ = 0;
};

}  // namespace weir::draw
