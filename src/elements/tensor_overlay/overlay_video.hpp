// OverlayVideo: draws results on the video buffers of one stream.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/video/video.h>

#include <memory>

#include "core/draw/overlay.hpp"
#include "core/ledger/ledger.hpp"
#include "weir/result.hpp"

namespace weir {

// FORMAT_UNSUPPORTED for caps of a format that cannot be drawn into.
Status check_drawable(const GstCaps* caps);

class OverlayVideo {
 public:
  // A null `painter` draws no text. FORMAT_UNSUPPORTED.
  static Result<OverlayVideo> make(const GstCaps* caps, draw::ClassNames names, bool show_scores,
                                   std::shared_ptr<draw::TextPainter> painter);

  // Replaces the names of classes; without a painter they have no effect.
  void set_names(draw::ClassNames names) {
    if (labels_) labels_->set_names(std::move(names));
  }
  // `buffer` is writable; bytes copied for mapping are counted in `ledger`.
  // Errors: MappedPicture::map(), Canvas::make().
  Result<draw::Drawn> draw(const draw::Detections& detections, const draw::Style& style,
                           const draw::Trails* trails, GstBuffer* buffer, Ledger* ledger);

 private:
  OverlayVideo(const GstVideoInfo& video, const preprocess::Picture& picture)
      : video_(video), picture_(picture) {}

  GstVideoInfo video_;
  preprocess::Picture picture_;
  std::unique_ptr<draw::Labels> labels_;
};

}  // namespace weir
