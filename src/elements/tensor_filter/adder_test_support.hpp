// Helpers for tests with the engine "adder" of tests/support: model files, and pipes to and from
// the engine.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <fcntl.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "becomes.hpp"
#include "elements/tests/element_test_support.hpp"

namespace weir::test {

inline constexpr char kAdderCaps[] =
    "other/tensors,format=static,num_tensors=1,dimensions=(string)4:1,types=float32,framerate=30/1";

// A folder of model files, removed with the object.
class AdderFiles {
 public:
  AdderFiles() {
    std::string name = testing::TempDir() + "weir-adder-XXXXXX";
    folder_ = mkdtemp(name.data());
  }
  AdderFiles(const AdderFiles&) = delete;
  AdderFiles& operator=(const AdderFiles&) = delete;
  ~AdderFiles() { std::filesystem::remove_all(folder_); }
  // Writes a model that adds `add`.
  std::string model(int add, const std::string& more = "4") const {
    return write(std::to_string(add) + ".add", std::to_string(add) + " " + more);
  }
  std::string write(const std::string& name, const std::string& text) const {
    const std::string path = folder_ + "/" + name;
    std::ofstream(path) << text;
    return path;
  }

 private:
  std::string folder_;
};

// A pipe from or to the engine.
class Pipe {
 public:
  Pipe() { EXPECT_EQ(pipe(ends_), 0); }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;
  ~Pipe() { close(ends_[0]), close(ends_[1]); }
  std::string reader() const { return std::to_string(ends_[0]); }
  std::string writer() const { return std::to_string(ends_[1]); }
  // Waits for one byte.
  char next() const {
    char byte = 0;
    EXPECT_EQ(read(ends_[0], &byte, 1), 1);
    return byte;
  }
  // All bytes so far.
  std::string all() const {
    std::string out;
    char byte = 0;
    fcntl(ends_[0], F_SETFL, O_NONBLOCK);
    while (read(ends_[0], &byte, 1) == 1) out += byte;
    return out;
  }
  void put(char byte) const { EXPECT_EQ(write(ends_[1], &byte, 1), 1); }

 private:
  int ends_[2];
};

inline std::string adder(const std::string& model, const std::string& more = "") {
  return "tensor_filter framework=adder model=" + model + " " + more;
}

// The number that the model adds; -1 when no frame is pushed.
inline float pushed_sum(const Harness& h) {
  if (gst_harness_push(h.get(), frame<float>({0, 0, 0, 0})) != GST_FLOW_OK) return -1;
  const auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
  return out ? values<float>(out.get())[3] : -1;
}

inline std::string text_property(GstElement* element, const char* name) {
  gchar* raw = nullptr;
  g_object_get(element, name, &raw, nullptr);
  const gst::UniqueText text{raw};
  return raw ? raw : "";
}

inline bool is_suspended(GstElement* filter) {
  gboolean suspended = FALSE;
  EXPECT_TRUE(gst_structure_get_boolean(stats(filter).get(), "suspended", &suspended));
  return suspended;
}

inline void wait_until_suspended(GstElement* filter) {
  EXPECT_TRUE(becomes_true([&] { return is_suspended(filter); }, "the suspension of the model"));
}

}  // namespace weir::test
