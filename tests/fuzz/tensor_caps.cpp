// Fuzz target: caps of tensor streams. A spec parsed from caps equals the one parsed from its
// formatted caps.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/buffer/tensor_caps.hpp"

#include <string>

#include "fuzz_input.hpp"
#include "gstcpp/buffer/caps_text.hpp"
#include "gstcpp/element/ref.hpp"

using weir::fuzz::require;

namespace {

// A pad without a template accepts all caps; those of another format omit the tensors.
void check_written(const weir::FrameSpec& spec) {
  const auto pad =
      weir::gst::Ref<GstPad>::adopt(GST_PAD(gst_object_ref_sink(gst_pad_new("src", GST_PAD_SRC))));
  const auto caps = weir::gst::possible_caps(pad.get(), spec, nullptr);
  bool found = false;
  for (guint i = 0; i < gst_caps_get_size(caps.get()); ++i) {
    const auto one = weir::gst::Ref<GstCaps>::adopt(gst_caps_copy_nth(caps.get(), i));
    const auto again = weir::gst::fixed_spec_from_caps(one.get());
    require(static_cast<bool>(again), "caps that are written can be read");
    require(again->format != spec.format || *again == spec, "a spec comes back from its caps");
    found = found || *again == spec;
  }
  require(found, "every spec has caps");
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  gst_init(nullptr, nullptr);
  gst_debug_set_default_threshold(GST_LEVEL_NONE);
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  const auto read = weir::gst::caps_from_text(text);
  if (!read) return 0;
  const auto& caps = *read;
  const auto spec = weir::gst::spec_from_caps(caps.get());
  if (!spec) {
    require(!spec.error().what.empty(), "an error has a text");
    return 0;
  }
  require(spec->tensors.size() <= weir::kTensorLimit, "a frame has at most 256 tensors");
  const auto fixed = weir::gst::fixed_spec_from_caps(caps.get());
  if (!fixed) return 0;
  require(fixed->valid(), "fixed caps give a valid spec");
  check_written(*fixed);
  return 0;
}
