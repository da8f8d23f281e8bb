// Which elements a pipeline has, and which pads an element has.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <string>
#include <vector>

namespace weir::pipeline {

struct ElementName {
  std::string name, kind;  // kind: its factory, "valve"
  int depth = 0;  // 0: the text names it; above: inside an element that is a bin of its own
};
std::vector<ElementName> element_list(GstBin* bin);

struct PadName {
  std::string name;
  bool source = false;
};
std::vector<PadName> pad_list(GstElement* element);

}  // namespace weir::pipeline
