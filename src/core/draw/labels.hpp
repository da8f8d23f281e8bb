// Labels: the texts of classes and scores as masks, each painted once.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <string>
#include <unordered_map>
#include <vector>

#include "core/draw/mask.hpp"

namespace weir::draw {

// Who knows fonts.
class TextPainter {
 public:
  virtual ~TextPainter() = default;
  // All masks of a painter are of one height.
  virtual Mask paint(const std::string& text) = 0;
};

class Labels {
 public:
  // `names` by class; empty: classes have none. Where there are names, a class beyond them is
  // called by its number. Paints the scores now and each name when it is first asked for.
  Labels(std::vector<std::string> names, bool scores, std::shared_ptr<TextPainter> painter,
         const preprocess::PictureFormat& format);

  // Null where none is wanted. Valid until the next call.
  const PlaneMask* name(uint32_t class_index);
  const PlaneMask* score(float score) const;  // in per cent, from 0 to 100
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
