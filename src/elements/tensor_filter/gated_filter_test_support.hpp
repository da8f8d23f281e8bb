// A tensor_filter in a harness whose frames continue when the test opens a gate: the engine
// `gated`.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstring>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include "elements/tests/element_test_support.hpp"
#include "gate.hpp"

namespace weir::test {

inline const std::string& any_model_file() {
  static const std::string path = [] {
    std::string name = testing::TempDir() + "weir_gated_model.bin";
    std::ofstream(name) << "x";
    return name;
  }();
  return path;
}

inline Gate& gate() {
  return Gate::of_process();
}

constexpr char kFourFloats[] =
    "other/tensors,format=static,num_tensors=1,dimensions=(string)4,types=float32,framerate=30/1";

// A frame of four numbers, 16 bytes; its timestamp is that of the frame with this index.
inline GstBuffer* numbered(float number) {
  return frame<float>({number, number, number, number},
                      static_cast<GstClockTime>(number) * GST_SECOND / 30);
}

class GatedFilter {
 public:
  explicit GatedFilter(const std::string& properties, bool open = false) {
    gate().reset(open);
    harness_ = make_harness(
        "tensor_filter framework=gated model=" + any_model_file() + " " + properties, kFourFloats);
    element_ = find_element(harness_, "tensor_filter");
  }
  ~GatedFilter() { gate().open(); }  // before the harness waits for the frames in progress

  GstHarness* get() const { return harness_.get(); }
  GstElement* element() const { return element_.get(); }
  GstFlowReturn push(float number) { return gst_harness_push(get(), numbered(number)); }
  // Waits for the next frames and returns their first numbers.
  std::vector<float> pull(size_t count) {
    std::vector<float> out;
    for (size_t i = 0; i < count; ++i) {
      const auto buffer = Ref<GstBuffer>::adopt(gst_harness_pull(get()));
      out.push_back(buffer ? values<float>(buffer.get())[0] : -1);
    }
    return out;
  }
  guint waiting_outside() const { return gst_harness_buffers_in_queue(get()); }
  uint64_t stat(const char* name) const { return test::stat(element(), name); }
  void wait_for_stat(const char* name, uint64_t value) const {
    test::wait_for_stat(element(), name, value);
  }
  // received = consumed + dropped + held is always true; here nothing may be left.
  void expect_all_accounted() const {
    wait_for_stat("held", 0);
    EXPECT_EQ(stat("received"), stat("consumed") + stat("dropped"));
    EXPECT_EQ(stat("consumed"), stat("pushed"));
  }

 private:
  Harness harness_;
  Ref<GstElement> element_;
};

}  // namespace weir::test
