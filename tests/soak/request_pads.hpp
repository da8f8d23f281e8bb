// RequestPads: paths from a tee to additional pads of an element, requested and released while it
// plays.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <string>
#include <vector>

#include "gstcpp/element/ref.hpp"

namespace weir::soak {

class RequestPads {
 public:
  // Both are in the same pipeline.
  RequestPads(GstElement* tee, GstElement* element);

  size_t size() const { return ways_.size(); }
  // Returns what is wrong, as remove() does.
  std::string add();
  // Removes path `index` and drops its frames. Returns what is wrong, or "".
  std::string remove(size_t index);

 private:
  struct Way {
    gst::Ref<GstPad> tee_pad, request_pad;
    gst::Ref<GstElement> queue;
  };

  gst::Ref<GstElement> pipeline_, tee_, element_;
  std::vector<Way> ways_;
};

}  // namespace weir::soak
