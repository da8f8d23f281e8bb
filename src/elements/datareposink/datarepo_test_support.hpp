// Helpers of the tests of datareposink and datareposrc: a folder, and pipelines that are played.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/app/gstappsink.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "elements/tests/pipeline_test_support.hpp"

namespace weir::test {

// A folder of its own for each test, for whose files pipelines have the names.
class DatarepoTest : public ::testing::Test {
 protected:
  DatarepoTest() { std::filesystem::create_directories(folder_); }
  DatarepoTest(const DatarepoTest&) = delete;
  DatarepoTest& operator=(const DatarepoTest&) = delete;
  ~DatarepoTest() override { std::filesystem::remove_all(folder_); }

  std::string path(const std::string& name) const { return folder_ / name; }
  std::string read(const std::string& name) const {
    std::ifstream file(path(name), std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  bool exists(const std::string& name) const { return std::filesystem::exists(path(name)); }
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(path(name), std::ios::binary) << text;
  }
  // "location=... json=..."
  std::string files(const std::string& location = "data",
                    const std::string& json = "data.json") const {
    return "location=" + path(location) + " json=" + path(json);
  }
  std::string sink() const { return "datareposink " + files(); }

 private:
  std::filesystem::path folder_ = std::filesystem::path(testing::TempDir()) /
                                  ("weir-datarepo-" + std::to_string(getpid()) + "-" +
                                   testing::UnitTest::GetInstance()->current_test_info()->name());
};

inline std::string text_of(const Bytes& bytes) {
  return {bytes.begin(), bytes.end()};
}
inline Bytes bytes_of(const std::string& text) {
  return {text.begin(), text.end()};
}
inline Bytes joined(const std::vector<Bytes>& parts) {
  Bytes out;
  for (const auto& part : parts) out.insert(out.end(), part.begin(), part.end());
  return out;
}
inline GstBuffer* buffer_of(const std::vector<Bytes>& memories) {
  GstBuffer* out = gst_buffer_new();
  for (const auto& memory : memories) gst_buffer_append_memory(out, make_memory(memory));
  return out;
}

// What a source pushed until EOS or an error.
struct Played {
  std::vector<std::vector<Bytes>> memories;  // of each buffer
  std::vector<GstClockTime> times, durations;
  std::string caps, error, warning;
  bool is_refused = false;  // the state change failed

  std::vector<Bytes> frames() const {
    std::vector<Bytes> out;
    for (const auto& frame : memories) out.push_back(joined(frame));
    return out;
  }
};

// Plays elements that end with a source pad.
inline Played play(const std::string& launch) {
  Played out;
  const auto pipeline = lone_element(launch + " ! appsink name=played sync=false");
  const auto bus = Ref<GstBus>::adopt(gst_element_get_bus(pipeline.get()));
  const auto sink = Ref<GstElement>::adopt(gst_bin_get_by_name(GST_BIN(pipeline.get()), "played"));
  out.is_refused =
      gst_element_set_state(pipeline.get(), GST_STATE_PLAYING) == GST_STATE_CHANGE_FAILURE;
  while (!out.is_refused) {
    const auto sample = Unique<GstSample, gst_sample_unref>(
        gst_app_sink_try_pull_sample(GST_APP_SINK(sink.get()), kTimeout));
    if (!sample) break;
    out.caps = gst::UniqueText(gst_caps_to_string(gst_sample_get_caps(sample.get()))).get();
    GstBuffer* buffer = gst_sample_get_buffer(sample.get());
    out.times.push_back(GST_BUFFER_PTS(buffer));
    out.durations.push_back(GST_BUFFER_DURATION(buffer));
    auto& memories = out.memories.emplace_back();
    for (guint i = 0; i < gst_buffer_n_memory(buffer); ++i)
      memories.push_back(content(gst_buffer_peek_memory(buffer, i)));
  }
  constexpr auto kTypes = GstMessageType(GST_MESSAGE_ERROR | GST_MESSAGE_WARNING);
  while (const auto message = Ref<GstMessage>::adopt(gst_bus_pop_filtered(bus.get(), kTypes))) {
    const bool is_error = GST_MESSAGE_TYPE(message.get()) == GST_MESSAGE_ERROR;
    std::string& text = is_error ? out.error : out.warning;
    if (text.empty()) text = get_text(message.get());
  }
  gst_element_set_state(pipeline.get(), GST_STATE_NULL);
  return out;
}

}  // namespace weir::test
