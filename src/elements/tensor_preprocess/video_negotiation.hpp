// How tensor_preprocess handles caps queries, and its choice of caps.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include "core/preprocess/request.hpp"
#include "gstcpp/element/ref.hpp"
#include "weir/result.hpp"

namespace weir {

// Regions without a limit: their number varies by frame.
inline bool is_flexible(const preprocess::Request& request) {
  return request.regions && request.max_regions == 0;
}

// The tensors that one structure of video caps can be converted to.
gst::Ref<GstCaps> tensors_for(GstPad* source, const GstStructure* video,
                              const Result<preprocess::Request>& request, const GstCaps* filter);
// Any video: a mismatch is reported when caps arrive, because an empty result carries no reason.
gst::Ref<GstCaps> video_for(GstPad* sink, const GstStructure* tensors);
// Fixes what the request and downstream leave open; the result may not be fixed. Consumes `open`.
gst::Ref<GstCaps> closed(GstPad* source, gst::Ref<GstCaps> open,
                         const Result<preprocess::Request>& request);

// Adds unsupported formats during linking, and when `filter` allows no others, so that such caps
// reach the element, which posts an error. Consumes `known`.
gst::Ref<GstCaps> with_other_formats(GstPad* sink, gst::Ref<GstCaps> known, const GstCaps* filter);
// FORMAT_UNSUPPORTED: GStreamer cannot parse the caps of raw video, or they lack a field.
Error unreadable_video(std::string caps);
// Why the caps of raw video are rejected; ok for caps that the pads may check.
Status check_video(const GstCaps* caps);

Error tensor_mismatch(const Result<preprocess::Request>& request, std::string offered,
                      std::string needed, std::string difference);
// The error after caps without a common tensor; nullopt when there is one.
std::optional<Error> downstream_mismatch(GstPad* source, const Result<preprocess::Request>& request,
                                         const GstCaps* ours);

}  // namespace weir
