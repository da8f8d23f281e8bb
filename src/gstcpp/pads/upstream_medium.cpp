// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/pads/upstream_medium.hpp"

#include <optional>
#include <string_view>

#include "gstcpp/element/internal_links.hpp"

namespace weir::gst {
namespace {

// nullopt for tensors, and where no caps are set.
std::optional<Medium> medium_at(GstPad* source) {
  const auto caps = Ref<GstCaps>::adopt(gst_pad_get_current_caps(source));
  if (!caps || gst_caps_get_size(caps.get()) == 0) return std::nullopt;
  const std::string_view name = gst_structure_get_name(gst_caps_get_structure(caps.get(), 0));
  if (name.starts_with("other/tensor")) return std::nullopt;
  return name.starts_with("video/") || name.starts_with("image/") ? Medium::Video : Medium::Other;
}

// Whether the tensors that leave the element are its results, and no longer pixels or samples.
bool makes_results(GstPad* source) {
  const auto element = Ref<GstElement>::adopt(gst_pad_get_parent_element(source));
  const auto* const factory = element ? gst_element_get_factory(element.get()) : nullptr;
  const std::string_view name = factory ? GST_OBJECT_NAME(factory) : "";
  return name == "tensor_filter" || name == "tensor_decoder" || name == "tensor_crop";
}

}  // namespace

Medium find_upstream_medium(GstPad* sink) {
  constexpr int kMaxElements = 100;
  auto pad = Ref<GstPad>::share(sink);
  for (int i = 0; pad && i < kMaxElements; ++i) {
    const auto source = Ref<GstPad>::adopt(gst_pad_get_peer(pad.get()));
    if (!source) return Medium::Unknown;
    if (const auto medium = medium_at(source.get())) return *medium;
    if (makes_results(source.get())) return Medium::Unknown;
    // The sink pads of the element, or the pad within a bin.
    const auto inputs = linked_inside(source.get());
    pad = inputs.empty() ? Ref<GstPad>() : inputs[0];
  }
  return Medium::Unknown;
}

}  // namespace weir::gst
