// Labels: the texts of classes and scores as masks, each painted once.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <string>
#include <unordered_map>
#include <vector>

#include "core/draw/detections.hpp"
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
  // Names are indexed by source, then by class; without names for a source, its classes have none.
  // A class beyond a non-empty list is labelled with its number. Paints the scores now and each
  // other text on first use.
  Labels(ClassNames names, bool scores, std::shared_ptr<TextPainter> painter,
         const preprocess::PictureFormat& format);

  void set_names(ClassNames names) { names_ = std::move(names); }

  // Masks stay valid until the next call of this function, which bounds the cache: call it before
  // each picture.
  void begin_picture();
  // Null if there is nothing to show.
  const PlaneMask* name(uint32_t source, uint32_t class_index);
  const PlaneMask* score(float score) const;  // in per cent, 0 to 100
  const PlaneMask* text(const std::string& text);
  uint64_t painted() const noexcept { return painted_; }

 private:
  PlaneMask paint(const std::string& text);

  ClassNames names_;
  std::shared_ptr<TextPainter> painter_;
  preprocess::PictureFormat format_;
  std::vector<PlaneMask> scores_;
  std::unordered_map<std::string, PlaneMask> by_text_;
  uint64_t painted_ = 0;
};

}  // namespace weir::draw
