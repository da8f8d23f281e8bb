// RequestWatch: follows the buffers of requests through the elements downstream of a source.
//
// It notes which element each request entered last, and drops a buffer before the next element when
// its client no longer waits. It drops only on the straight way from the source: where streams
// part, each branch must get every frame, because they may meet again.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <string>
#include <vector>

#include "gstcpp/element/ref.hpp"

namespace weir {

class RequestWatch {
 public:
  RequestWatch() = default;
  RequestWatch(const RequestWatch&) = delete;
  RequestWatch& operator=(const RequestWatch&) = delete;
  ~RequestWatch() { stop(); }
  // Watches the elements that are linked now.
  void start(GstPad* source);
  void stop();

 private:
  struct Probe {
    gst::Ref<GstPad> pad;
    gulong id;
  };
  std::vector<Probe> probes_;
};

// A property of the first element on the straight way downstream of `source` that has one of this
// name and a text in it; "" if there is none.
std::string property_downstream(GstPad* source, const char* name);
// The same upstream of `sink`, past elements with one input and one output.
std::string property_upstream(GstPad* sink, const char* name);

}  // namespace weir
