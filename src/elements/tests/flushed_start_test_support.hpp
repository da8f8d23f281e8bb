// Starts of a source while another thread flushes it.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <atomic>
#include <string>
#include <thread>

#include "elements/tests/element_test_support.hpp"

namespace weir::test {

// Starts and stops it several times.
inline void start_while_flushed(const std::string& launch) {
  constexpr int kStarts = 20;
  const auto source = lone_element(launch);
  const auto pad = Ref<GstPad>::adopt(gst_element_get_static_pad(source.get(), "src"));
  std::atomic<bool> ended{false};
  std::thread flushes([&] {
    while (!ended) {
      gst_pad_send_event(pad.get(), gst_event_new_flush_start());
      gst_pad_send_event(pad.get(), gst_event_new_flush_stop(TRUE));
    }
  });
  for (int i = 0; i < kStarts; ++i) {
    EXPECT_NE(gst_element_set_state(source.get(), GST_STATE_PAUSED), GST_STATE_CHANGE_FAILURE);
    EXPECT_EQ(gst_element_set_state(source.get(), GST_STATE_NULL), GST_STATE_CHANGE_SUCCESS);
  }
  ended = true;
  flushes.join();
}

}  // namespace weir::test
