// Lists elements; bins from parentheses, "( a ! b )", add no depth: their content is in the text.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "pipeline/element_list.hpp"

#include <algorithm>

#include "gstcpp/element/ref.hpp"
#include "pipeline/element_access.hpp"

namespace weir::pipeline {
namespace {

std::vector<gst::Ref<GstElement>> list_children(GstBin* bin) {
  std::vector<gst::Ref<GstElement>> out;
  GST_OBJECT_LOCK(bin);
  for (GList* at = GST_BIN_CHILDREN(bin); at; at = at->next)
    out.push_back(gst::Ref<GstElement>::share(GST_ELEMENT(at->data)));
  GST_OBJECT_UNLOCK(bin);
  std::reverse(out.begin(), out.end());  // bins list the newest first
  return out;
}

void add(GstBin* bin, int depth, std::vector<ElementName>* out) {
  for (const auto& child : list_children(bin)) {
    const std::string kind = get_factory_name(child.get());
    out->push_back({GST_OBJECT_NAME(child.get()), kind, depth});
    if (!GST_IS_BIN(child.get())) continue;
    const bool of_the_text = depth == 0 && (kind == "bin" || kind == "pipeline");
    add(GST_BIN(child.get()), of_the_text ? depth : depth + 1, out);
  }
}

}  // namespace

std::vector<ElementName> element_list(GstBin* bin) {
  std::vector<ElementName> out;
  add(bin, 0, &out);
  return out;
}

std::vector<PadName> pad_list(GstElement* element) {
  std::vector<PadName> out;
  GST_OBJECT_LOCK(element);
  for (GList* at = element->pads; at; at = at->next)
    out.push_back({GST_OBJECT_NAME(at->data), GST_PAD_IS_SRC(at->data) != FALSE});
  GST_OBJECT_UNLOCK(element);
  return out;
}

}  // namespace weir::pipeline
