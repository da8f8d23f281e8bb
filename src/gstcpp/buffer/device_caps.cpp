// Lists which GStreamer element downloads pictures from which memory.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/buffer/device_caps.hpp"

#include <array>

namespace weir::gst {
namespace {

struct Device {
  const char* feature;
  const char* download;
};

constexpr std::array kDevices{
    Device{"memory:GLMemory", "glcolorconvert ! gldownload"},
    Device{"memory:DMABuf", "glupload ! glcolorconvert ! gldownload"},
    Device{"memory:VAMemory", "vapostproc"},
    Device{"memory:CUDAMemory", "cudadownload"},
    Device{"memory:NVMM", "nvvideoconvert"},
};

}  // namespace

Ref<GstCaps> video_of_devices() {
  auto all = Ref<GstCaps>::adopt(gst_caps_new_empty());
  for (const auto& device : kDevices)
    gst_caps_append_structure_full(all.get(), gst_structure_new_empty("video/x-raw"),
                                   gst_caps_features_new(device.feature, nullptr));
  return all;
}

Status check_memory(const GstCaps* caps, const std::string& element) {
  if (gst_caps_is_any(caps) || gst_caps_is_empty(caps)) return ok();
  const GstCapsFeatures* features = gst_caps_get_features(caps, 0);
  for (const auto& device : kDevices)
    if (gst_caps_features_contains(features, device.feature))
      return Error{.code = Code::FORMAT_UNSUPPORTED,
                   .what = "the video is in device memory",
                   .offered = UniqueText(gst_caps_features_to_string(features)).get(),
                   .needed = "memory:SystemMemory",
                   .fix = std::string(device.download) + " ! " + element};
  return ok();
}

}  // namespace weir::gst
