// Lists the elements of a pipeline and the pads of an element.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <string>
#include <vector>

namespace weir::pipeline {

struct ElementName {
  std::string name, kind;  // kind: the factory name, for example "valve"
  int depth = 0;           // 0: named in the text; above: inside an element that is a bin
};
std::vector<ElementName> element_list(GstBin* bin);

struct PadName {
  std::string name;
  bool source = false;
};
std::vector<PadName> pad_list(GstElement* element);

}  // namespace weir::pipeline
