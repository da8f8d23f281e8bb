// Finds the sync-mode of the first synchronising element downstream.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_reposrc/sync_check.hpp"

#include <string>

#include "gstcpp/element/ref.hpp"

namespace weir {
namespace {

using gst::Ref;

constexpr int kMostElements = 64;  // a pipeline may contain loops

// "" for an element that does not synchronise.
std::string sync_mode_of(GstElement* element) {
  const auto* spec = g_object_class_find_property(G_OBJECT_GET_CLASS(element), "sync-mode");
  if (!spec || spec->value_type != G_TYPE_STRING) return "";
  char* raw = nullptr;
  g_object_get(element, "sync-mode", &raw, nullptr);
  const gst::UniqueText text{raw};
  return raw ? raw : "";
}

Error unfit(GstElement* element, const std::string& mode) {
  const gst::UniqueText name{gst_element_get_name(element)};
  return {.code = Code::GRAPH_STALLS,
          .what = std::string("a loop goes through ") + name.get() +
                  ", which synchronises by timestamps",
          .offered = "sync-mode=" + mode + ", while frames of a loop are one round old",
          .needed =
              "sync-mode=nosync: slowest and basepad drop these frames as late and wait; refresh "
              "never ends",
          .fix = std::string("name=") + name.get() + " sync-mode=nosync"};
}

}  // namespace

std::optional<Error> unfit_sync_mode(GstPad* source) {
  auto pad = Ref<GstPad>::share(source);
  for (int i = 0; pad && i < kMostElements; ++i) {
    const auto peer = Ref<GstPad>::adopt(gst_pad_get_peer(pad.get()));
    if (!peer) break;
    const auto element = Ref<GstElement>::adopt(gst_pad_get_parent_element(peer.get()));
    if (!element) break;
    if (const std::string mode = sync_mode_of(element.get()); !mode.empty()) {
      if (g_ascii_strcasecmp(mode.c_str(), "nosync") == 0) break;
      return unfit(element.get(), mode);
    }
    pad = Ref<GstPad>::adopt(gst_element_get_static_pad(element.get(), "src"));
  }
  return std::nullopt;
}

}  // namespace weir
