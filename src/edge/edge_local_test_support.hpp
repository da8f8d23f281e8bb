// A stream between an edgesink and an edgesrc with protocol=local, in a folder of its own.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <unistd.h>

#include <filesystem>

#include "elements/tests/element_test_support.hpp"

namespace weir::test {

inline constexpr char kLocalCaps[] =
    "other/tensor,dimension=(string)4,type=(string)uint8,framerate=30/1";

class EdgeLocal : public ::testing::Test {
 protected:
  EdgeLocal() {
    std::string name = std::filesystem::temp_directory_path() / "weir-edge-XXXXXX";
    folder_ = mkdtemp(name.data());
  }
  ~EdgeLocal() override { std::filesystem::remove_all(folder_); }
  std::string path() const { return folder_ + "/stream"; }
  std::string ends_with(const std::string& more = "") const {
    return " protocol=local path=" + path() + " " + more;
  }
  Harness sink(const std::string& more = "", const char* caps = kLocalCaps) const {
    return make_harness("edgesink sync=false" + ends_with(more), caps);
  }
  // An edgesrc that is connected.
  Harness source(const std::string& more = "") const {
    Harness h{gst_harness_new_parse(("edgesrc" + ends_with(more)).c_str())};
    gst_harness_play(h.get());
    return h;
  }
  static bool receivers_become(const Harness& sink, guint count) {
    const auto element = find_element(sink, "edgesink");
    return becomes_true(
        [&] {
          guint value = 0;
          gst_structure_get_uint(stats(element.get()).get(), "receivers", &value);
          return value == count;
        },
        std::to_string(count) + " receivers");
  }
  static Ref<GstBuffer> pull(const Harness& h) {
    return Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
  }

  std::string folder_;
};

}  // namespace weir::test
