// Helpers of the tests of filters that were built for NNStreamer: pipeline texts, frames and
// messages.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdlib>

#include "elements/tests/element_test_support.hpp"

namespace weir::test {

inline std::string filter_folder() {
  return std::getenv("WEIR_COMPAT_FILTERS");
}
inline std::string filter_file(const std::string& name) {
  return filter_folder() + "/" + name + ".so";
}
// The outputs for one frame; empty when it was dropped or rejected.
template <class T, class Out = T>
std::vector<Out> pushed(const Harness& h, const std::vector<T>& in) {
  if (gst_harness_push(h.get(), frame<T>(in)) != GST_FLOW_OK) return {};
  const auto out = Ref<GstBuffer>::adopt(gst_harness_try_pull(h.get()));
  return out ? values<Out>(out.get()) : std::vector<Out>{};
}
// The bus message when a frame is rejected.
template <class T>
std::string frame_error(const Harness& h, const std::vector<T>& in) {
  Errors errors(h);
  EXPECT_EQ(gst_harness_push(h.get(), frame<T>(in)), GST_FLOW_ERROR);
  return errors.next();
}

}  // namespace weir::test
