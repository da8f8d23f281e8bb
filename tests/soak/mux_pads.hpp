// MuxPads: ways from a tee to further pads of a tensor_mux, requested and released while it plays.
#pragma once
#include <gst/gst.h>

#include <string>
#include <vector>

#include "gstcpp/ref.hpp"

namespace weir::soak {

class MuxPads {
 public:
  // Both are in one pipeline.
  MuxPads(GstElement* tee, GstElement* mux);

  size_t size() const { return ways_.size(); }
  // Returns what is wrong, as remove() does.
  std::string add();
  // Takes the way `index` out; what lies in it is dropped. Returns what is wrong, "" for nothing.
  std::string remove(size_t index);

 private:
  struct Way {
    gst::Ref<GstPad> tee_pad, mux_pad;
    gst::Ref<GstElement> queue;
  };

  gst::Ref<GstElement> pipeline_, tee_, mux_;
  std::vector<Way> ways_;
};

}  // namespace weir::soak
