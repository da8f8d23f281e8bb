// The table of all elements for the bad-input tests: how to make each one and its valid input.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstring>
#include <fstream>
#include <functional>
#include <ostream>
#include <string>
#include <vector>

#include "elements/tests/element_parts_test_support.hpp"
#include "elements/tests/many_tensors_test_support.hpp"

namespace weir::testing_bad_input {

inline GstBuffer* zeros(size_t bytes) {
  GstBuffer* buffer = gst_buffer_new_allocate(nullptr, bytes, nullptr);
  gst_buffer_memset(buffer, 0, 0, bytes);
  return buffer;
}
inline GstBuffer* buffer_with(const std::vector<uint8_t>& bytes) {
  GstBuffer* buffer = gst_buffer_new_allocate(nullptr, bytes.size(), nullptr);
  gst_buffer_fill(buffer, 0, bytes.data(), bytes.size());
  return buffer;
}

// How an element handles a buffer that has not the size of a frame.
enum class Sizes {
  Exact,    // an error
  Any,      // passed on
  Video,    // an error below one frame and from two frames up
  Words,    // any multiple of 4 bytes is accepted
  Rows,     // any multiple of 16 bytes is accepted
  Headers,  // a frame starts with a header: zeros of any size are an error
};

// Another input of the element, which gets valid frames.
struct Companion {
  enum class Brings {
    Nothing,    // only caps
    OneFrame,   // at the start; the element repeats it
    EachFrame,  // with each buffer of the input under test
  };
  std::string pad, caps;
  Brings brings = Brings::Nothing;
  std::vector<uint8_t> frame{};
};

struct Subject {
  const char* name;
  std::string line, caps;
  size_t bytes;  // of one frame
  Sizes sizes = Sizes::Exact;
  std::string pad = "sink";      // the input under test; requested if it does not exist
  std::vector<uint8_t> frame{};  // a valid frame; empty: zeros
  std::vector<Companion> companions{};
  std::string partner = "";          // the other end of a loop
  const char* counter = "received";  // its counter in `stats`; "" = none
  bool makes_outputs = true;

  GstBuffer* good_frame() const { return frame.empty() ? zeros(bytes) : buffer_with(frame); }
};

inline std::string tensors(const std::string& dims, const std::string& type,
                           const std::string& rate = "30/1") {
  return test::tensors(type, dims, rate);
}
inline std::string video(const std::string& format, int width, int height,
                         const std::string& rate = "30/1") {
  return "video/x-raw,format=" + format + ",width=" + std::to_string(width) +
         ",height=" + std::to_string(height) + ",interlace-mode=progressive,framerate=" + rate;
}
inline std::string fake_filter() {
  const std::string path = ::testing::TempDir() + "weir-bad-input.bin";
  std::ofstream(path) << "the engine looks at nothing of it";
  return "tensor_filter framework=fake model=" + path;
}
// A tensor with its header (docs/compatibility/types-and-caps.md 1.7): `format` 1 is flexible, 2
// sparse.
inline std::vector<uint8_t> with_header(uint32_t type, const std::vector<uint32_t>& dimensions,
                                        uint32_t format, const std::vector<uint8_t>& payload) {
  std::vector<uint8_t> out;
  test::append_word(&out, 0xfeedcced, 4);
  test::append_word(&out, 0xDE001000, 4);
  test::append_word(&out, type, 4);
  test::append_dimensions(&out, dimensions);
  test::append_word(&out, format, 4);
  test::append_word(&out, 4, 4);  // media: a tensor
  out.resize(128);                // all values of a sparse tensor are 0
  out.insert(out.end(), payload.begin(), payload.end());
  return out;
}
inline std::vector<uint8_t> one_region() {
  std::vector<uint8_t> numbers;
  for (const uint64_t number : {0, 0, 2, 2}) test::append_word(&numbers, number, 4);
  return with_header(1, {4, 1}, 1, numbers);
}

// A file with one line, written on the first call.
inline const std::string& zones_file() {
  static const std::string path = [] {
    const std::string out =
        ::testing::TempDir() + "weir-bad-input-zones-" + std::to_string(getpid()) + ".json";
    std::ofstream(out) << R"({"version":1,"zones":[{"name":"gate","line":[[0,0],[9,0]]}]})";
    return out;
  }();
  return path;
}

// Elements with one input and at most one output, in each mode that reads data differently.
inline const std::vector<Subject>& single_input_subjects() {
  static const std::vector<Subject> all{
      {"converter", "tensor_converter", video("RGB", 8, 4), 96, Sizes::Video},
      {"converter_chunks", "tensor_converter frames-per-tensor=2", video("RGB", 8, 4), 96,
       Sizes::Video},
      {"converter_audio", "tensor_converter",
       "audio/x-raw,format=S16LE,layout=interleaved,rate=8000,channels=2", 64, Sizes::Words},
      {"converter_bytes", "tensor_converter input-dim=16 input-type=uint8",
       "application/octet-stream,framerate=30/1", 16, Sizes::Rows},
      {"preprocess", "tensor_preprocess width=4 height=4", video("RGB", 8, 4), 96, Sizes::Video},
      {"preprocess_yuv", "tensor_preprocess width=4 height=4 method=area", video("NV12", 8, 4), 48,
       Sizes::Video},
      {"transform_type", "tensor_transform mode=typecast option=float32", tensors("4:4", "uint8"),
       16},
      {"transform_in_place", "tensor_transform mode=arithmetic option=add:1",
       tensors("4:4", "uint8"), 16},
      {"transform_order", "tensor_transform mode=transpose option=1:0:2:3", tensors("4:4", "uint8"),
       16},
      {"filter", fake_filter(), tensors("4:4", "float32"), 64},
      {"decoder", "tensor_decoder mode=octet_stream", tensors("4:4", "uint8"), 16},
      {"decoder_video", "tensor_decoder mode=direct_video", tensors("3:4:4", "uint8"), 48},
      {"decoder_classes", "tensor_decoder mode=image_segment option1=tflite-deeplab option2=2",
       tensors("3:4:4", "float32"), 192},
      {"decoder_pose", "tensor_decoder mode=pose_estimation option1=16:16 option2=2:2",
       tensors("14:2:2", "float32"), 224},
      {"decoder_json", "tensor_decoder mode=json", tensors("6:1", "float32"), 24},
      {"overlay", "tensor_overlay", video("NV12", 8, 4), 48, Sizes::Any},
      {"to_roi", "tensor_to_roi", video("NV12", 8, 4), 48, Sizes::Any},
      {"from_roi", "tensor_from_roi", video("NV12", 8, 4), 48, Sizes::Any},
      {"tracker", "tensor_tracker", tensors("6:1", "float32"), 24},
      // Each test replaces the frame rate at the end of the caps.
      {"zones", "tensor_zones zones=" + zones_file(),
       "other/tensors,weir-columns=(string)\"x1,y1,x2,y2,track\"" +
           tensors("5:1", "float32").substr(strlen("other/tensors")),
       20},
      {"sink", "tensor_sink", tensors("4:4", "uint8"), 16, Sizes::Any},
      {"datareposink",
       "datareposink sync=false location=" + ::testing::TempDir() +
           "weir-bad-samples json=" + ::testing::TempDir() + "weir-bad-samples.json",
       tensors("4:4", "uint8"), 16},
  };
  return all;
}

inline std::vector<Subject> many_pads_subjects() {
  using Brings = Companion::Brings;
  const std::string bytes = tensors("4:4", "uint8"), picture = tensors("1:4:4", "uint8");
  const std::string regions = "other/tensors,format=flexible,framerate=30/1";
  const std::string boxes = tensors("4:1", "uint32"), rows = tensors("6:1", "float32");
  const std::vector<Companion> second{
      {"sink_1", bytes, Brings::OneFrame, std::vector<uint8_t>(16)}};
  const std::vector<Companion> first{{"sink_0", bytes, Brings::OneFrame, std::vector<uint8_t>(16)}};
  std::vector<Subject> all;
  const auto add = [&all](Subject subject) { all.push_back(std::move(subject)); };
  add({"mux", "tensor_mux max-wait=1", bytes, 16, Sizes::Exact, "sink_0", {}, second});
  add({"mux_second", "tensor_mux max-wait=1", bytes, 16, Sizes::Exact, "sink_1", {}, first});
  add({"merge",
       "tensor_merge sync-mode=slowest max-wait=1",
       bytes,
       16,
       Sizes::Exact,
       "sink_0",
       {},
       second});
  add({"join", "join", bytes, 16, Sizes::Any, "sink_0", {}, {{"sink_1", bytes}}});
  add({"crop_raw",
       "tensor_crop",
       picture,
       16,
       Sizes::Exact,
       "raw",
       {},
       {{"info", regions, Brings::EachFrame, one_region()}}});
  add({"crop_info",
       "tensor_crop",
       regions,
       one_region().size(),
       Sizes::Headers,
       "info",
       one_region(),
       {{"raw", picture, Brings::EachFrame, std::vector<uint8_t>(16)}}});
  add({"overlay_results",
       "tensor_overlay",
       rows,
       24,
       Sizes::Exact,
       "results",
       {},
       {},
       "",
       "results-received",
       false});
  add({"to_roi_results",
       "tensor_to_roi",
       rows,
       24,
       Sizes::Exact,
       "results",
       {},
       {},
       "",
       "results-received",
       false});
  add({"preprocess_regions",
       "tensor_preprocess width=4 height=4 regions=pad",
       boxes,
       16,
       Sizes::Exact,
       "regions",
       {},
       {},
       "",
       "",
       false});
  return all;
}

inline std::vector<Subject> one_output_or_several_subjects() {
  const std::string bytes = tensors("4:4", "uint8");
  return {
      {"aggregator", "tensor_aggregator frames-out=2", bytes, 16},
      {"rate", "tensor_rate framerate=15/1", bytes, 16, Sizes::Any},
      {"debug", "tensor_debug", bytes, 16, Sizes::Any},
      {"sparse_enc", "tensor_sparse_enc", bytes, 16},
      {"sparse_dec", "tensor_sparse_dec", "other/tensors,format=sparse,framerate=30/1", 128,
       Sizes::Headers, "sink", with_header(5, {4, 4}, 2, {})},
      {"demux", "tensor_demux", bytes, 16},
      {"split", "tensor_split tensorseg=4:2,4:2", bytes, 16},
      {"if",
       "tensor_if compared-value=A_VALUE compared-value-option=0:0:0:0,0 operator=EQ "
       "supplied-value=0",
       bytes, 16},
  };
}

// Each has its own slot, which no other test uses.
inline std::vector<Subject> loop_subjects() {
  const std::string bytes = tensors("4:4", "uint8");
  const auto source = [&bytes](const std::string& slot) {
    return "tensor_reposrc slot-index=" + slot +
           " caps=\"other/tensor,dimension=(string)4:4,type=(string)uint8,framerate=30/1\"";
  };
  return {
      {"reposink",
       "tensor_reposink slot-index=901",
       bytes,
       16,
       Sizes::Exact,
       "sink",
       {},
       {},
       source("901"),
       "received",
       false},
      {"reposrc",
       source("902"),
       bytes,
       16,
       Sizes::Exact,
       "sink",
       {},
       {},
       "tensor_reposink slot-index=902",
       ""},
  };
}

// Every element of the plug-in.
inline const std::vector<Subject>& subjects() {
  static const std::vector<Subject> all = [] {
    auto out = single_input_subjects();
    for (const auto& more :
         {many_pads_subjects(), one_output_or_several_subjects(), loop_subjects()})
      out.insert(out.end(), more.begin(), more.end());
    return out;
  }();
  return all;
}

inline void PrintTo(const Subject& subject, std::ostream* out) {
  *out << subject.name;
}

}  // namespace weir::testing_bad_input
