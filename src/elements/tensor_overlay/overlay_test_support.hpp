// Helpers of the tensor_overlay tests: a harness for each input, and boxes drawn pixel by pixel.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/video/video.h>

#include "core/draw/color.hpp"
#include "elements/tests/element_test_support.hpp"

namespace weir::overlay_test {

using namespace weir::test;

// Rows of K numbers.
inline std::string floats(int k, int rows) {
  return tensors("float32", std::to_string(k) + ":" + std::to_string(rows), "10/1");
}
inline GstBuffer* timed(GstBuffer* buffer, GstClockTime time) {
  GST_BUFFER_PTS(buffer) = time;
  return buffer;
}

// Both inputs, and the sizes of 720 rows; results are linked first because the first harness starts
// the element.
struct Both {
  Harness results, pictures;
  Ref<GstElement> element;

  explicit Both(const std::string& properties, const std::string& picture_caps = video("RGB", 8, 6),
                const std::string& result_caps = floats(6, 1))
      : element(lone_element("tensor_overlay show-scores=false auto-size=false " + properties)) {
    results = Harness{gst_harness_new_with_element(element.get(), "results", nullptr)};
    pictures = Harness{gst_harness_new_with_element(element.get(), "sink", "src")};
    if (!result_caps.empty()) gst_harness_set_src_caps_str(results.get(), result_caps.c_str());
    if (!picture_caps.empty()) gst_harness_set_src_caps_str(pictures.get(), picture_caps.c_str());
  }
  GstFlowReturn push(const std::vector<float>& numbers, GstClockTime time) const {
    return gst_harness_push(results.get(), frame(numbers, time));
  }
  // The output for a picture of zeros.
  Bytes picture(size_t bytes, GstClockTime time) const {
    return pushed(timed(frame(Bytes(bytes)), time));
  }
  Bytes pushed(GstBuffer* in) const {
    if (gst_harness_push(pictures.get(), in) != GST_FLOW_OK) return {};
    const auto out = Ref<GstBuffer>::adopt(gst_harness_try_pull(pictures.get()));
    return out ? content(out.get()) : Bytes{};
  }
  uint64_t stat(const char* name) const { return test::stat(element.get(), name); }
  // received = drawn + replaced + unused + flushed + refused + held
  void expect_results_balance() const {
    EXPECT_EQ(stat("results-received"), stat("results-drawn") + stat("results-replaced") +
                                            stat("results-unused") + stat("results-flushed") +
                                            stat("results-refused") + stat("results-held"));
    EXPECT_EQ(stat("received"), stat("consumed") + stat("dropped") + stat("held"));
  }
};

constexpr size_t kSmall = 8 * 6 * 3;  // bytes of the 8x6 RGB picture

// The black small picture with box lines in the colours of their classes, two pixels wide.
struct Lines {
  int left, top, right, bottom;
  unsigned class_index = 0;
};
inline Bytes small_with(const std::vector<Lines>& boxes) {
  Bytes out(kSmall);
  for (const Lines& b : boxes)
    for (int y = 0; y < 6; ++y)
      for (int x = 0; x < 8; ++x) {
        const bool in = x >= b.left && x < b.right && y >= b.top && y < b.bottom;
        const bool inner = x >= b.left + 2 && x < b.right - 2 && y >= b.top + 2 && y < b.bottom - 2;
        if (!in || inner) continue;
        const auto color = draw::class_color(b.class_index);
        const auto at = static_cast<size_t>(y * 8 + x) * 3;
        out[at] = color.red, out[at + 1] = color.green, out[at + 2] = color.blue;
      }
  return out;
}

}  // namespace weir::overlay_test
