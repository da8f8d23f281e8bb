// Measures a round of a loop through tensor_reposink and tensor_reposrc above the same elements in
// a line, and that it does not grow with the frame.
// in a line, and that it does not grow with the frame.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/gst.h>

#include <stdexcept>
#include <string>

#include "gstcpp/element/ref.hpp"
#include "launched.hpp"
#include "rounds.hpp"

namespace {

using weir::gst::Ref;

constexpr int kTurns = 30000, kRounds = 9;

std::string caps(size_t bytes) {
  return "other/tensor,dimension=(string)" + std::to_string(bytes) +
         ":1:1:1,type=(string)uint8,framerate=(fraction)30/1";
}
std::string loop(size_t bytes, const std::string& between) {
  return "tensor_reposrc slot-index=0 num-buffers=" + std::to_string(kTurns) +
         " caps=" + caps(bytes) + " ! " + between + " ! tensor_reposink slot-index=0";
}
std::string line(size_t bytes, const std::string& between) {
  return "fakesrc format=time filltype=nothing sizetype=fixed sizemax=" + std::to_string(bytes) +
         " num-buffers=" + std::to_string(kTurns) + " ! capsfilter caps=" + caps(bytes) + " ! " +
         between + " ! fakesink async=false sync=false enable-last-sample=false";
}

void play(const std::string& launch) {
  const auto pipeline = weir::bench::launched(launch);
  const auto bus = Ref<GstBus>::adopt(gst_element_get_bus(pipeline.get()));
  gst_element_set_state(pipeline.get(), GST_STATE_PLAYING);
  const auto message = Ref<GstMessage>::adopt(gst_bus_timed_pop_filtered(
      bus.get(), GST_CLOCK_TIME_NONE, GstMessageType(GST_MESSAGE_EOS | GST_MESSAGE_ERROR)));
  const bool ended = GST_MESSAGE_TYPE(message.get()) == GST_MESSAGE_EOS;
  gst_element_set_state(pipeline.get(), GST_STATE_NULL);
  if (!ended) throw std::runtime_error(launch + " fails");
}

}  // namespace

int main(int argc, char** argv) {
  gst_init(&argc, &argv);
  const std::string work = "tensor_transform mode=arithmetic option=add:1";
  const auto costs = weir::bench::medians(
      {[&] { play(line(1024, work)); }, [&] { play(loop(1024, work)); },
       [] { play(loop(1024, "identity")); }, [] { play(loop(size_t{1} << 20, "identity")); }},
      kRounds);
  weir::bench::report("cost of a round of 1 KB through tensor_reposink and tensor_reposrc",
                      "fakesrc to fakesink, the same tensor_transform between",
                      (costs[1].cpu - costs[0].cpu) / kTurns * 1e6, "us", 1.5);
  weir::bench::report("a round of 1 MB through tensor_reposink and tensor_reposrc: time",
                      "a round of 1 KB", costs[3].cpu / costs[2].cpu, "x", 1.2);
}
