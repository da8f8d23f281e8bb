// What tensor_preprocess answers when caps are queried and chosen.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include "core/preprocess/request.hpp"
#include "gstcpp/ref.hpp"
#include "weir/result.hpp"

namespace weir {

// Regions of a frame without a limit: as many as there are.
inline bool is_flexible(const preprocess::Request& request) {
  return request.regions && request.most_regions == 0;
}

// The tensors that one structure of video caps can become.
gst::Ref<GstCaps> tensors_for(GstPad* source, const GstStructure* video,
                              const Result<preprocess::Request>& request, const GstCaps* filter);
// Any video: that no tensor fits is told when caps come, for an empty answer has no words.
gst::Ref<GstCaps> video_for(GstPad* sink, const GstStructure* tensors);
// Closes what the request and the stream behind both leave open; not fixed. Takes `open`.
gst::Ref<GstCaps> closed(GstPad* source, gst::Ref<GstCaps> open,
                         const Result<preprocess::Request>& request);

// A format that is not taken is shown while elements are linked and where `filter` has no other, so
// that its caps come to the element, which refuses them with words. Takes `known`.
gst::Ref<GstCaps> with_other_formats(GstPad* sink, gst::Ref<GstCaps> known, const GstCaps* filter);
// Why caps of a stream, raw video, are not taken; ok for those that pads may judge.
Status check_video(const GstCaps* caps);

Error tensor_mismatch(const Result<preprocess::Request>& request, std::string offered,
                      std::string needed, std::string difference);
// After caps for which no common tensor was found; nothing where there is one.
std::optional<Error> mismatch_behind(GstPad* source, const Result<preprocess::Request>& request,
                                     const GstCaps* ours);

}  // namespace weir
