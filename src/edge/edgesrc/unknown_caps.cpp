// Proposes a capsfilter for what the downstream elements accept.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "edge/edgesrc/unknown_caps.hpp"

#include <string>

#include "gstcpp/element/ref.hpp"

namespace weir {
namespace {

struct Example {
  const char* media_type;
  const char* fields;
  const char* downstream;
};
constexpr Example kExamples[] = {
    {"other/tensors", "format=flexible,framerate=30/1", "tensor_sink"},
    {"video/x-raw", "format=RGB,width=640,height=480,framerate=30/1",
     "videoconvert ! autovideosink"},
    {"audio/x-raw", "format=S16LE,layout=interleaved,rate=16000,channels=1",
     "audioconvert ! autoaudiosink"},
};

std::string example_for(GstPad* pad) {
  const auto accepted = gst::Ref<GstCaps>::adopt(gst_pad_peer_query_caps(pad, nullptr));
  if (!accepted || gst_caps_is_any(accepted.get())) return "edgesrc ! CAPS ! fakesink";
  for (const auto& example : kExamples) {
    const auto caps = gst::Ref<GstCaps>::adopt(gst_caps_new_empty_simple(example.media_type));
    if (gst_caps_can_intersect(accepted.get(), caps.get()))
      return std::string("edgesrc ! ") + example.media_type + "," + example.fields + " ! " +
             example.downstream;
  }
  return "edgesrc ! CAPS ! fakesink";
}

}  // namespace

Error unknown_caps(GstPad* pad) {
  return Error{.code = Code::NOT_NEGOTIATED,
               .what = "the caps of the stream are not known",
               .offered = "an edgesink that did not announce its caps",
               .needed =
                   "a capsfilter with fixed caps, those of the sink pad of the edgesink: "
                   "gst-launch-1.0 -v prints them",
               .fix = example_for(pad)};
}

}  // namespace weir
