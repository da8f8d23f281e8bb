// The caps fields weir-columns and weir-source through elements that pass tensors on.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/results/empty_frame.hpp"
#include "elements/tensor_mux/many_inputs_test_support.hpp"
#include "elements/tests/element_test_support.hpp"
#include "gstcpp/buffer/tensor_caps.hpp"

namespace result_caps_test {

using namespace weir;
using namespace weir::test;

std::string with_fields(const std::string& caps, const std::string& columns,
                        const std::string& source) {
  return caps + ",weir-columns=(string)\"" + columns + "\",weir-source=(string)\"" + source + "\"";
}
const std::string kTwo = tensors("float32,uint8", "6:2,3");  // rows and a table
const std::string kResults = with_fields(kTwo, "x1,y1,x2,y2,score,class;masks", "yolo;yolo");
GstBuffer* frame_of_two() {
  return weir::test::make_buffer({Bytes(48), Bytes(3)}, 0).release();
}

// The roles of the output's caps: "columns|source" of each tensor.
std::vector<std::string> roles(const std::string& text) {
  const auto caps = Ref<GstCaps>::adopt(gst_caps_from_string(text.c_str()));
  std::vector<std::string> out;
  for (const auto& role : gst::roles_from_caps(caps.get()))
    out.push_back(role.columns + "|" + role.source);
  return out;
}
using Roles = std::vector<std::string>;
const std::string kRows = "x1,y1,x2,y2,score,class|yolo", kMasks = "masks|yolo";

Roles through(const std::string& line, const std::string& caps, GstBuffer* buffer) {
  const auto element = lone_element(line);
  const Harness h{gst_harness_new_with_element(element.get(), "sink", nullptr)};
  const auto added = +[](GstElement*, GstPad* pad, gpointer to) {
    gst_harness_add_element_src_pad(static_cast<GstHarness*>(to), pad);
  };
  // Some pads come with the frame.
  if (const auto pad = Ref<GstPad>::adopt(gst_element_get_static_pad(element.get(), "src")))
    added(nullptr, pad.get(), h.get());
  else
    g_signal_connect(element.get(), "pad-added", G_CALLBACK(added), h.get());
  gst_harness_play(h.get());
  gst_harness_set_src_caps_str(h.get(), caps.c_str());
  EXPECT_EQ(gst_harness_push(h.get(), buffer), GST_FLOW_OK) << line;
  EXPECT_TRUE(gst_harness_push_event(h.get(), gst_event_new_eos()));  // what is held comes out
  EXPECT_TRUE(Ref<GstBuffer>::adopt(gst_harness_pull(h.get()))) << line;
  return roles(caps_text(h));
}

TEST(ResultCaps, PassElementsThatDoNotChangeFrames) {
  for (const char* element : {"queue", "tensor_debug", "tensor_rate", "tensor_rate framerate=15/1"})
    EXPECT_EQ(through(element, kResults, frame_of_two()), (Roles{kRows, kMasks})) << element;
}

TEST(ResultCaps, OfFlexibleStreamsPassTensorRate) {
  const std::string caps =
      with_fields("other/tensors,format=flexible,framerate=30/1", "score,class", "net");
  const auto h = make_harness("tensor_rate framerate=15/1", caps);
  EXPECT_EQ(roles(caps_text(h)), (Roles{"score,class|net"}));
}

TEST(ResultCaps, ArePickedWithTensors) {
  EXPECT_EQ(through("tensor_demux tensorpick=1", kResults, frame_of_two()), (Roles{kMasks}));
  EXPECT_EQ(through("tensor_demux tensorpick=1:0", kResults, frame_of_two()),
            (Roles{kMasks, kRows}));
  EXPECT_EQ(through("tensor_if compared-value=A_VALUE compared-value-option=0:0,1 operator=EQ "
                    "supplied-value=0 then=TENSORPICK then-option=1 else=SKIP",
                    kResults, frame_of_two()),
            (Roles{kMasks}));
  EXPECT_EQ(through("tensor_if compared-value=A_VALUE compared-value-option=0:0,1 operator=EQ "
                    "supplied-value=0 then=PASSTHROUGH else=SKIP",
                    kResults, frame_of_two()),
            (Roles{kRows, kMasks}));
}

TEST(ResultCaps, AreNotOfTensorsThatWereComputed) {
  EXPECT_EQ(through("tensor_transform mode=typecast option=float64", kResults, frame_of_two()),
            Roles{});
}

// Caps and a frame of a stream.
struct Stream {
  std::string caps;
  Ref<GstBuffer> frame;
};
Stream results_of_two() {
  return {kResults, Ref<GstBuffer>::adopt(frame_of_two())};
}
Stream plain() {
  return {tensors("uint8,uint8", "2,2"), weir::test::make_buffer({Bytes(2), Bytes(2)}, 0)};
}
Stream flexible(const std::string& columns, const std::string& source) {
  std::vector<Bytes> memories;
  const auto made = columns.empty() ? ResultRoles(1) : parse_roles(columns, source);
  EXPECT_TRUE(results::write_empty(made, [&](size_t bytes) {
    return std::as_writable_bytes(std::span(memories.emplace_back(bytes)));
  }));
  const std::string caps = "other/tensors,format=flexible,framerate=30/1";
  return {columns.empty() ? caps : with_fields(caps, columns, source),
          weir::test::make_buffer(memories, 0)};
}
Roles joined(const std::vector<Stream>& streams) {
  weir::test::ManyInputs mux("tensor_mux");
  for (const auto& stream : streams) mux.add(stream.caps.c_str());
  mux.play();
  std::vector<std::future<GstFlowReturn>> pushes;
  for (size_t i = 0; i < streams.size(); ++i) pushes.push_back(mux.push_later(i, streams[i].frame));
  for (auto& push : pushes) EXPECT_EQ(push.get(), GST_FLOW_OK);
  EXPECT_EQ(mux.error(), "");
  return roles(mux.caps());
}

TEST(ResultCaps, OfStreamsSideBySideAreJoined) {
  EXPECT_EQ(joined({results_of_two(), results_of_two()}), (Roles{kRows, kMasks, kRows, kMasks}));
  EXPECT_EQ(joined({plain(), results_of_two()}), (Roles{"|", "|", kRows, kMasks}));
  EXPECT_EQ(joined({results_of_two(), plain()}), (Roles{kRows, kMasks, "|", "|"}));
  EXPECT_EQ(joined({plain(), plain()}), Roles{});
}

TEST(ResultCaps, OfFlexibleStreamsSayHowManyTensorsThereAre) {
  EXPECT_EQ(joined({flexible("score,class;;text", "net;;net"), results_of_two()}),
            (Roles{"score,class|net", "|", "text|net", kRows, kMasks}));
  EXPECT_EQ(joined({results_of_two(), flexible("", ""), results_of_two()}), (Roles{kRows, kMasks}))
      << "after a stream of an unknown number of tensors, places are not known";
}

TEST(ResultCaps, ThatChangeInTheMiddleChangeTheJoinedCaps) {
  weir::test::ManyInputs mux("tensor_mux");
  mux.add(kResults.c_str());
  mux.play();
  EXPECT_EQ(mux.push(0, results_of_two().frame), GST_FLOW_OK);
  mux.set_caps(0, with_fields(kTwo, "score,class;text", "a;b").c_str());
  EXPECT_EQ(mux.push(0, results_of_two().frame), GST_FLOW_OK);
  EXPECT_EQ(roles(mux.caps()), (Roles{"score,class|a", "text|b"}));
}

}  // namespace result_caps_test
