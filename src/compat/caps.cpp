// Converts caps to tensor configurations and back.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "compat/guard.hpp"
#include "compat/spec.hpp"
#include "gstcpp/buffer/tensor_caps.hpp"
#include "gstcpp/element/ref.hpp"
#include "nnstreamer_plugin_api.h"

using namespace weir::compat;
using weir::gst::Ref;

namespace {

void set_rate(GstStructure* structure, const weir::Fraction& rate) {
  if (rate.valid())
    gst_structure_set(structure, "framerate", GST_TYPE_FRACTION, rate.numerator, rate.denominator,
                      nullptr);
}

// Returns whether each tensor has a type and dimensions.
bool known(const weir::FrameSpec& spec) {
  for (const auto& tensor : spec.tensors)
    if (!tensor.valid()) return false;
  return !spec.tensors.empty();
}

// Returns the result of `read`; FALSE, with the reason in the log, on an error.
template <class Read>
gboolean fill(const char* function, GstTensorsConfig* config, Read read) noexcept {
  return or_else(function, FALSE, [&]() -> gboolean {
    const auto spec = read();
    if (spec)
      write(*spec, config);
    else
      warn(function, spec.error());
    return spec ? TRUE : FALSE;
  });
}

GstCaps* make_caps(GstStructure* structure) {
  GstCaps* caps = gst_caps_new_empty();
  gst_caps_append_structure(caps, structure);
  return caps;
}

}  // namespace

gboolean gst_tensors_config_from_structure(GstTensorsConfig* config,
                                           const GstStructure* structure) {
  if (!given(__func__, {config})) return FALSE;
  gst_tensors_config_init(config);
  if (!given(__func__, {structure})) return FALSE;
  return fill(__func__, config, [&] {
    const auto caps = Ref<GstCaps>::adopt(make_caps(gst_structure_copy(structure)));
    return weir::gst::spec_from_caps(caps.get());
  });
}

gboolean gst_tensors_config_from_caps(GstTensorsConfig* config, const GstCaps* caps,
                                      gboolean validate) {
  if (!given(__func__, {config})) return FALSE;
  gst_tensors_config_init(config);
  if (!given(__func__, {caps})) return FALSE;
  return fill(__func__, config, [&] {
    return validate ? weir::gst::fixed_spec_from_caps(caps) : weir::gst::spec_from_caps(caps);
  });
}

gboolean gst_tensors_config_from_peer(GstPad* pad, GstTensorsConfig* config, gboolean* is_fixed) {
  if (is_fixed) *is_fixed = FALSE;
  if (!given(__func__, {config})) return FALSE;
  gst_tensors_config_init(config);
  if (!given(__func__, {pad}) || !GST_IS_PAD(pad)) return FALSE;
  return fill(__func__, config, [&]() -> weir::Result<weir::FrameSpec> {
    const auto peer = Ref<GstPad>::adopt(gst_pad_get_peer(pad));
    auto caps = Ref<GstCaps>::adopt(peer ? gst_pad_get_current_caps(peer.get()) : nullptr);
    if (!caps && peer) caps = Ref<GstCaps>::adopt(gst_pad_query_caps(peer.get(), nullptr));
    auto spec = weir::gst::spec_from_caps(caps.get());
    if (spec && is_fixed) *is_fixed = gst_caps_is_fixed(caps.get());
    return spec;
  });
}

GstCaps* gst_tensors_caps_from_config(const GstTensorsConfig* config) {
  if (!given(__func__, {config})) return nullptr;
  return or_else<GstCaps*>(__func__, nullptr, [&]() -> GstCaps* {
    const auto spec = to_spec(*config);
    GstStructure* structure = gst_structure_new_empty("other/tensors");
    if (spec.format != weir::Format::End)
      gst_structure_set(structure, "format", G_TYPE_STRING,
                        std::string(weir::to_string(spec.format)).c_str(), nullptr);
    if (spec.format == weir::Format::Static && !spec.tensors.empty())
      gst_structure_set(structure, "num_tensors", G_TYPE_INT, static_cast<int>(spec.tensors.size()),
                        nullptr);
    if (spec.format == weir::Format::Static && known(spec))
      gst_structure_set(structure, "dimensions", G_TYPE_STRING,
                        weir::join_shapes(spec.tensors).c_str(), "types", G_TYPE_STRING,
                        weir::join_types(spec.tensors).c_str(), nullptr);
    set_rate(structure, spec.rate);
    return make_caps(structure);
  });
}

GstCaps* gst_tensor_caps_from_config(const GstTensorsConfig* config) {
  if (!given(__func__, {config})) return nullptr;
  return or_else<GstCaps*>(__func__, nullptr, [&]() -> GstCaps* {
    const auto spec = to_spec(*config);
    GstStructure* structure = gst_structure_new_empty("other/tensor");
    if (!spec.tensors.empty() && spec.tensors[0].shape.valid())
      gst_structure_set(structure, "dimension", G_TYPE_STRING,
                        spec.tensors[0].shape.to_string().c_str(), nullptr);
    if (!spec.tensors.empty() && spec.tensors[0].type != weir::ElementType::End)
      gst_structure_set(structure, "type", G_TYPE_STRING,
                        std::string(weir::to_string(spec.tensors[0].type)).c_str(), nullptr);
    set_rate(structure, spec.rate);
    return make_caps(structure);
  });
}

GstCaps* gst_tensor_pad_caps_from_config(GstPad* pad, const GstTensorsConfig* config) {
  if (!given(__func__, {pad, config}) || !GST_IS_PAD(pad)) return nullptr;
  return or_else<GstCaps*>(__func__, nullptr, [&] {
    auto caps = weir::gst::choose_caps(pad, weir::gst::PeerCaps(pad), to_spec(*config));
    return caps ? gst_caps_ref(caps.get()) : nullptr;
  });
}
