// tensor_reposrc in a harness: the first frame, caps, errors, EOS.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <list>
#include <map>

#include "becomes.hpp"
#include "core/results/empty_frame.hpp"
#include "core/tensor/tensor_header.hpp"
#include "elements/tests/element_test_support.hpp"
#include "gstcpp/element/result_events.hpp"

namespace weir::test {
namespace tensor_reposrc_test {

std::string tensor(const std::string& type, const std::string& dimension,
                   const std::string& rate = "30/1") {
  return "other/tensor,dimension=(string)" + dimension + ",type=(string)" + type +
         ",framerate=(fraction)" + rate;
}
const std::string kFloats = tensor("float32", "2:1:1:1");

// Quoted for gst_parse_launch().
std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? "\\\"" : std::string(1, c);
  return out + "\"";
}
std::string source(const std::string& caps, const std::string& more = "slot-index=0") {
  return "tensor_reposrc " + more + " caps=" + quoted(caps);
}
Harness playing(const std::string& launch) {
  Harness h = make_harness(launch);
  gst_harness_play(h.get());
  return h;
}
Ref<GstBuffer> pulled(const Harness& h) {
  return Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
}
bool ends(const Harness& h) {
  while (const auto event = Ref<GstEvent>::adopt(gst_harness_pull_event(h.get())))
    if (GST_EVENT_TYPE(event.get()) == GST_EVENT_EOS) return true;
  return false;
}
// The error of a source with `needed` whose sink receives a frame of `offered`; "" if none.
std::string get_mismatch(const std::string& offered, const std::string& needed, size_t bytes) {
  const Harness h = make_harness(source(needed));
  Errors errors(h);
  gst_harness_play(h.get());
  const Harness sink = make_harness("tensor_reposink", offered);
  EXPECT_EQ(gst_harness_push(sink.get(), frame(ramp(bytes))), GST_FLOW_OK);
  gst_harness_push_event(sink.get(), gst_event_new_eos());
  EXPECT_TRUE(ends(h));
  return errors.next();
}

TEST(TensorReposrc, FollowsCapsThatAreSetWhilePlaying) {
  const Harness h = playing(source(tensor("uint8", "2"), "slot-index=40"));
  EXPECT_EQ(gst_buffer_get_size(pulled(h).get()), 2u) << "zeros";
  const auto element = find_element(h, "tensor_reposrc");
  Errors messages(h);
  const Harness sink = make_harness("tensor_reposink slot-index=40", tensor("uint8", "2"));
  const auto wanted = Ref<GstCaps>::adopt(gst_caps_from_string(tensor("uint8", "3").c_str()));
  g_object_set(element.get(), "caps", wanted.get(), nullptr);
  gst_harness_push(sink.get(), frame(ramp(2)));
  EXPECT_EQ(gst_buffer_get_size(pulled(h).get()), 2u) << "an earlier frame";
  gst_harness_set_src_caps_str(sink.get(), tensor("uint8", "3").c_str());
  gst_harness_push(sink.get(), frame(ramp(3)));
  EXPECT_EQ(gst_buffer_get_size(pulled(h).get()), 3u);
  EXPECT_SAYS(caps_text(h), "dimension=(string)3");
  const auto open = Ref<GstCaps>::adopt(gst_caps_from_string("other/tensors,format=flexible"));
  g_object_set(element.get(), "caps", open.get(), nullptr);
  EXPECT_SAYS(messages.next_warning(), "WEIR-");
  GstCaps* raw = nullptr;
  g_object_get(element.get(), "caps", &raw, nullptr);
  const auto read = Ref<GstCaps>::adopt(raw);
  EXPECT_TRUE(gst_caps_is_equal(read.get(), wanted.get()));
}

TEST(TensorReposrc, CapsThatDownstreamRejectsAreRejectedAndRestored) {
  const Harness h = make_harness(source(tensor("uint8", "2"), "slot-index=41") +
                                 " ! capsfilter caps=other/tensor,dimension=(string)2");
  Errors messages(h);
  gst_harness_play(h.get());
  EXPECT_TRUE(pulled(h));
  const auto element = find_element(h, "tensor_reposrc");
  const auto wanted = Ref<GstCaps>::adopt(gst_caps_from_string(tensor("uint8", "3").c_str()));
  g_object_set(element.get(), "caps", wanted.get(), nullptr);
  const Harness sink = make_harness("tensor_reposink slot-index=41", tensor("uint8", "3"));
  gst_harness_push(sink.get(), frame(ramp(3)));
  EXPECT_TRUE(ends(h));
  EXPECT_SAYS(messages.next_warning(),
              "fix: tensor_reposrc slot-index=41 caps=\"other/tensor, dimension=(string)2");
  EXPECT_SAYS(messages.next(), "the frames of the tensor_reposink do not match the property caps");
  GstCaps* raw = nullptr;
  g_object_get(element.get(), "caps", &raw, nullptr);
  const auto read = Ref<GstCaps>::adopt(raw);
  EXPECT_FALSE(gst_caps_is_equal(read.get(), wanted.get()));
}

TEST(TensorReposrc, StartsWithTheDocumentedValues) {
  const auto element = lone_element("tensor_reposrc");
  guint index = 0;
  gint count = 0;
  gboolean timestamp = TRUE, silent = FALSE;
  GstCaps* caps = nullptr;
  g_object_get(element.get(), "slot-index", &index, "num-buffers", &count, "do-timestamp",
               &timestamp, "silent", &silent, "caps", &caps, nullptr);
  EXPECT_EQ(index, 4294967295u);
  EXPECT_EQ(count, -1);
  EXPECT_FALSE(timestamp);
  EXPECT_TRUE(silent);
  EXPECT_EQ(caps, nullptr);
  const auto* spec = g_object_class_find_property(G_OBJECT_GET_CLASS(element.get()), "slot-index");
  EXPECT_EQ(G_PARAM_SPEC_UINT(spec)->maximum, 4294967294u);
}

TEST(TensorReposrc, ReturnsTheCapsThatWereSet) {
  const auto element = lone_element(source(kFloats));
  GstCaps* raw = nullptr;
  g_object_get(element.get(), "caps", &raw, nullptr);
  const auto caps = Ref<GstCaps>::adopt(raw);
  const auto expected = Ref<GstCaps>::adopt(gst_caps_from_string(kFloats.c_str()));
  ASSERT_TRUE(caps);
  EXPECT_TRUE(gst_caps_is_equal(caps.get(), expected.get()));
}

TEST(TensorReposrc, StartsWithUntimedZeros) {
  const Harness h = playing(source(kFloats));
  const auto first = pulled(h);
  EXPECT_EQ(values<float>(first.get()), (std::vector<float>{0, 0}));
  EXPECT_FALSE(GST_BUFFER_PTS_IS_VALID(first.get()));
  EXPECT_FALSE(GST_BUFFER_DTS_IS_VALID(first.get()));
  EXPECT_FALSE(GST_BUFFER_DURATION_IS_VALID(first.get()));
  EXPECT_EQ(stat(h, "tensor_reposrc", "pushed"), 1u);
  EXPECT_EQ(stat(h, "tensor_reposrc", "received"), 0u);
}

TEST(TensorReposrc, StartsWithOneMemoryForEachTensor) {
  const Harness h = playing(source(tensors("uint8,int16", "3:1:1:1,5:1:1:1")));
  const auto first = pulled(h);
  ASSERT_EQ(gst_buffer_n_memory(first.get()), 2u);
  EXPECT_EQ(gst_memory_get_sizes(gst_buffer_peek_memory(first.get(), 0), nullptr, nullptr), 3u);
  EXPECT_EQ(gst_memory_get_sizes(gst_buffer_peek_memory(first.get(), 1), nullptr, nullptr), 10u);
}

// 15 memories of 1 byte, and one with the packed header and the bytes of 5 tensors.
TEST(TensorReposrc, StartsWithPackedTensorsBeyond16) {
  std::string types = "uint8", dimensions = "1";
  for (int i = 1; i < 20; ++i) types += ",uint8", dimensions += ",1";
  const Harness h = playing(source(tensors(types, dimensions)));
  const auto first = pulled(h);
  ASSERT_EQ(gst_buffer_n_memory(first.get()), 16u);
  EXPECT_EQ(gst_buffer_get_size(first.get()), 15u + 19224u + 5u);
  const Bytes bytes = content(first.get());
  EXPECT_TRUE(std::all_of(bytes.begin(), bytes.begin() + 15, [](auto b) { return b == 0; }));
  EXPECT_TRUE(std::all_of(bytes.end() - 5, bytes.end(), [](auto b) { return b == 0; }));
}

TEST(TensorReposrc, UsesTheDownstreamSpellingOfItsCaps) {
  const Harness h = playing(source(tensor("float32", "2")) +
                            " ! capsfilter caps=other/tensors,dimensions=(string)2:1:1:1");
  EXPECT_TRUE(pulled(h));
  EXPECT_SAYS(caps_text(h), "dimensions=(string)2:1:1:1");
}

TEST(TensorReposrc, ReportsUnsetProperties) {
  const std::string no_slot = start_error(source(kFloats, ""));
  EXPECT_SAYS(no_slot, "WEIR-1004");
  EXPECT_SAYS(no_slot, "the property slot-index is not set");
  EXPECT_SAYS(no_slot, "fix: tensor_reposrc slot-index=0");
  const std::string no_caps = start_error("tensor_reposrc slot-index=0");
  EXPECT_SAYS(no_caps, "WEIR-1004");
  EXPECT_SAYS(no_caps, "the property caps is not set");
  EXPECT_SAYS(no_caps, "caps=\"other/tensor,dimension=");
}

TEST(TensorReposrc, ReportsCapsThatAreNotFixedStaticTensors) {
  EXPECT_SAYS(start_error(source("other/tensor,dimension=(string)2,type=(string)uint8")),
              "do not describe the tensors completely");
  EXPECT_SAYS(start_error(source(tensor("{ uint8, int8 }", "2"))), "not fixed");
  EXPECT_SAYS(start_error(source("other/tensors,format=(string)sparse,framerate=30/1")),
              "a loop carries static or flexible tensors only");
  EXPECT_NE(start_error(source("video/x-raw,format=RGB,width=2,height=2,framerate=30/1")), "");
}

const std::string kFlexible = "other/tensors,format=(string)flexible,framerate=30/1";
std::string of_results(const std::string& columns, const std::string& source = "net") {
  return kFlexible + ",weir-columns=(string)\"" + columns + "\",weir-source=(string)\"" + source +
         "\"";
}

GstBuffer* empty_results(const std::string& columns) {
  GstBuffer* const out = gst_buffer_new();
  std::list<Bytes> memories;
  results::write_empty(parse_roles(columns, ""), [&](size_t bytes) {
    return std::as_writable_bytes(std::span(memories.emplace_back(bytes)));
  });
  for (const Bytes& bytes : memories) gst_buffer_append_memory(out, make_memory(bytes));
  return out;
}

TEST(TensorReposrc, ReportsFlexibleCapsWhoseFirstFrameIsNotKnown) {
  const std::string text = start_error(source(kFlexible));
  EXPECT_SAYS(text, "WEIR-2002: the caps do not describe the first frame of the loop");
  EXPECT_SAYS(text, "for flexible tensors weir-columns");
  EXPECT_SAYS(text, "weir-columns=(string)\"x1,y1,x2,y2,score,class\"");
  EXPECT_SAYS(start_error(source(of_results("x1,y1"))), "WEIR-1001");
  EXPECT_SAYS(start_error(source(of_results("masks"))), "masks");
}

TEST(TensorReposrc, ReportsResultsThatDoNotFit) {
  const auto error_of_frames = [](const std::string& offered, GstBuffer* buffer) {
    const Harness h = make_harness(source(of_results("score,class")));
    Errors errors(h);
    gst_harness_play(h.get());
    const Harness sink = make_harness("tensor_reposink", offered);
    EXPECT_EQ(gst_harness_push(sink.get(), buffer), GST_FLOW_OK);
    gst_harness_push_event(sink.get(), gst_event_new_eos());
    EXPECT_TRUE(ends(h));
    return errors.next();
  };
  EXPECT_EQ(error_of_frames(of_results("score,class", "other"), empty_results("score,class")), "");
  EXPECT_EQ(error_of_frames(kFlexible, empty_results("score,class")), "");
  EXPECT_SAYS(error_of_frames(of_results("score,track"), empty_results("score,track")),
              "weir-columns is score,track, needed is score,class");
  EXPECT_SAYS(error_of_frames(tensor("uint8", "2"), frame(ramp(2))),
              "format is static, needed is flexible");
}

TEST(TensorReposrc, StartsALoopOfResultsWithNone) {
  const Harness h = playing(source(of_results("x1,y1,x2,y2,score;text")));
  const auto first = pulled(h);
  ASSERT_EQ(gst_buffer_n_memory(first.get()), 2u);
  const Bytes rows = content(gst_buffer_peek_memory(first.get(), 0));
  const auto header = read_tensor_chunk(std::as_bytes(std::span(rows)));
  ASSERT_TRUE(header);
  EXPECT_EQ(header->spec.to_string(), "float32 5:1");
  EXPECT_EQ(Bytes(rows.begin() + kTensorHeaderBytes, rows.end()), Bytes(20));
  EXPECT_FALSE(GST_BUFFER_PTS_IS_VALID(first.get()));
  const std::string many = std::string(20, ';') + "score";
  const auto packed = pulled(playing(source(of_results(many))));
  EXPECT_EQ(gst_buffer_n_memory(packed.get()), 16u) << "the last one has the other tensors";
}

TEST(TensorReposrc, SendsTheFieldsOfTheFrames) {
  const auto fields_after_a_frame = [](const std::string& property, const std::string& frames,
                                       GstBuffer* buffer) {
    const Harness h = playing(source(property));
    EXPECT_TRUE(pulled(h));
    const Harness sink = make_harness("tensor_reposink", frames);
    gst_harness_push(sink.get(), buffer);
    EXPECT_TRUE(pulled(h));
    return caps_text(h);
  };
  EXPECT_SAYS(fields_after_a_frame(of_results("score,class"), of_results("score,class", "yolo"),
                                   empty_results("score,class")),
              "weir-source=(string)yolo");
  EXPECT_SAYS(
      fields_after_a_frame(of_results("score,class"), kFlexible, empty_results("score,class")),
      "weir-source=(string)net");
  const std::string rows = tensors("float32", "2:1"),
                    fields = ",weir-columns=(string)\"score,class\"";
  EXPECT_SAYS(fields_after_a_frame(rows, rows + fields, frame(ramp(8))),
              "weir-columns=(string)\"score\\,class\"");
  EXPECT_EQ(fields_after_a_frame(rows, rows, frame(ramp(8))).find("weir-"), std::string::npos);
}

std::map<std::string, std::vector<std::string>> get_labels(const Harness& h) {
  std::map<std::string, std::vector<std::string>> out;
  const auto pad = Ref<GstPad>::adopt(gst_element_get_static_pad(h->element, "src"));
  gst_pad_sticky_events_foreach(
      pad.get(),
      [](GstPad*, GstEvent** event, gpointer all) -> gboolean {
        if (auto labels = gst::parse_labels_event(*event))
          (*static_cast<decltype(out)*>(all))[labels->source] = labels->labels;
        return TRUE;
      },
      &out);
  return out;
}

TEST(TensorReposrc, SendsTheLabelsOfTheFrames) {
  const Harness h = playing(source(of_results("score,class")));
  const Harness sink = make_harness("tensor_reposink", of_results("score,class"));
  const auto labels_after = [&](std::vector<gst::LabelsOfSource> events) {
    for (const auto& event : events)
      gst_harness_push_event(sink.get(), gst::make_labels_event(event).release());
    gst_harness_push(sink.get(), empty_results("score,class"));
    EXPECT_TRUE(pulled(h));
    return get_labels(h);
  };
  using Labels = decltype(get_labels(h));
  EXPECT_TRUE(pulled(h));
  EXPECT_EQ(labels_after({}), Labels{});
  EXPECT_EQ(labels_after({{"net", {"cat"}}, {"other", {"red"}}}),
            (Labels{{"net", {"cat"}}, {"other", {"red"}}}));
  EXPECT_EQ(labels_after({{"net", {"cat", "dog"}}}),
            (Labels{{"net", {"cat", "dog"}}, {"other", {"red"}}}));
  // A new stream, whose labels are not those of the one before.
  gst_harness_push_event(sink.get(), gst_event_new_stream_start("another"));
  EXPECT_EQ(labels_after({{"other", {"blue"}}}), (Labels{{"net", {}}, {"other", {"blue"}}}));
}

TEST(TensorReposrc, LabelsTravelWithTheFrameThatFollowsThem) {
  const Harness sink = make_harness("tensor_reposink", of_results("score,class"));
  gst_harness_push(sink.get(), empty_results("score,class"));
  gst_harness_push_event(sink.get(), gst::make_labels_event({"net", {"cat"}}).release());
  const Harness h = playing(source(of_results("score,class")));
  EXPECT_TRUE(pulled(h));
  EXPECT_TRUE(pulled(h));
  EXPECT_TRUE(get_labels(h).empty());
}

TEST(TensorReposrc, AcceptsEqualTensorsInAnySpelling) {
  EXPECT_EQ(get_mismatch(tensor("float32", "2"), kFloats, 8), "");
  EXPECT_EQ(get_mismatch(tensor("float32", "2:1"), tensors("float32", "2"), 8), "");
  EXPECT_EQ(get_mismatch(tensors("float32", "2:1:1"), tensor("float32", "2"), 8), "");
}

TEST(TensorReposrc, ReportsBothCapsOfFramesThatDoNotFit) {
  const std::string text = get_mismatch(tensor("uint8", "3:1:1:1"), kFloats, 3);
  EXPECT_SAYS(text, "WEIR-2001");
  EXPECT_SAYS(text, "dimension=(string)3:1:1:1, type=(string)uint8");
  EXPECT_SAYS(text, "dimension=(string)2:1:1:1, type=(string)float32");
  EXPECT_SAYS(text, "tensor 0: type is uint8, needed is float32");
  EXPECT_SAYS(text, "fix: tensor_reposrc slot-index=0 caps=\"other/tensor, dimension=(string)3");
  EXPECT_SAYS(get_mismatch(tensor("float32", "3:1:1:1"), kFloats, 12), "tensor 0: ");
  EXPECT_SAYS(get_mismatch(tensors("float32,float32", "2,2"), kFloats, 16), "first difference: ");
}

TEST(TensorReposrc, ReportsAFrameRateThatDoesNotFit) {
  const std::string text = get_mismatch(tensor("float32", "2:1:1:1", "15/1"), kFloats, 8);
  EXPECT_SAYS(text, "framerate is 15/1, needed is 30/1");
  EXPECT_EQ(get_mismatch(tensor("float32", "2:1:1:1", "60/2"), kFloats, 8), "");
}

TEST(TensorReposrc, ChecksCapsThatChangeLater) {
  const Harness h = make_harness(source(kFloats));
  Errors errors(h);
  gst_harness_play(h.get());
  const Harness sink = make_harness("tensor_reposink", kFloats);
  gst_harness_push(sink.get(), frame(ramp(8)));
  EXPECT_TRUE(pulled(h));
  EXPECT_EQ(content(pulled(h).get()), ramp(8));
  gst_harness_set_src_caps_str(sink.get(), tensor("int32", "2:1:1:1").c_str());
  gst_harness_push(sink.get(), frame(ramp(8)));
  EXPECT_TRUE(ends(h));
  EXPECT_SAYS(errors.next(), "type is int32, needed is float32");
  EXPECT_EQ(stat(h, "tensor_reposrc", "dropped-error"), 1u);
  EXPECT_EQ(stat(h, "tensor_reposrc", "received"), 2u);
  EXPECT_EQ(stat(h, "tensor_reposrc", "held"), 0u);
}

TEST(TensorReposrc, ANewSlotIndexMovesTheWait) {
  const Harness h = playing(source(kFloats));
  EXPECT_TRUE(pulled(h));
  const Harness sink = make_harness("tensor_reposink slot-index=5", kFloats);
  gst_harness_push(sink.get(), frame(ramp(8)));
  g_object_set(find_element(h, "tensor_reposrc").get(), "slot-index", 5u, nullptr);
  EXPECT_EQ(content(pulled(h).get()), ramp(8));
}

TEST(TensorReposrc, WarnsThatNoSinkSendsFrames) {
  const Harness h = make_harness(source(kFloats, "slot-index=6"));
  Errors errors(h);
  gst_harness_play(h.get());
  EXPECT_TRUE(pulled(h));
  std::string warning;
  EXPECT_TRUE(
      becomes_true([&] { return !(warning = errors.next_warning()).empty(); }, "a warning"));
  EXPECT_SAYS(warning, "WEIR-5001: a loop has only one end");
  EXPECT_SAYS(warning, "fix: tensor_reposink slot-index=6");
  const Harness sink = make_harness("tensor_reposink slot-index=6", kFloats);
  gst_harness_push(sink.get(), frame(ramp(8)));
  EXPECT_EQ(content(pulled(h).get()), ramp(8)) << "it kept waiting";
}

TEST(TensorReposrc, WarnsThatAnotherSourceReadsItsSlot) {
  const Harness first = make_harness(source(kFloats, "slot-index=6"));
  Errors of_first(first);
  gst_harness_play(first.get());
  const Harness second = make_harness(source(kFloats, "slot-index=6"));
  Errors of_second(second);
  gst_harness_play(second.get());
  const std::string warning = of_second.next_warning();
  EXPECT_SAYS(warning, "WEIR-5001: two sources read frames from one slot");
  EXPECT_SAYS(warning, "offered: another tensor_reposrc slot-index=6");
  EXPECT_SAYS(warning, "fix: tensor_reposrc slot-index=7");
  EXPECT_EQ(of_first.next_warning(), "") << "it was the only source when it started";
}

TEST(TensorReposrc, StopsWaitingWhenTheElementStops) {
  const Harness h = playing(source(kFloats));
  EXPECT_TRUE(pulled(h));
  EXPECT_EQ(gst_element_set_state(h->element, GST_STATE_PAUSED), GST_STATE_CHANGE_SUCCESS);
  EXPECT_EQ(gst_element_set_state(h->element, GST_STATE_NULL), GST_STATE_CHANGE_SUCCESS);
}

TEST(TensorReposrc, EndsOnAnEosEvent) {
  const Harness h = playing(source(kFloats));
  EXPECT_TRUE(pulled(h));
  EXPECT_TRUE(gst_element_send_event(h->element, gst_event_new_eos()));
  EXPECT_TRUE(ends(h));
}

// The loop carries only frames: queries and QoS events end at the source.
TEST(TensorReposrc, AnswersLatencyAndForwardsNoQos) {
  const Harness h = playing(source(kFloats));
  EXPECT_TRUE(pulled(h));
  const Harness sink = make_harness("tensor_reposink", kFloats);
  const Unique<GstQuery, gst_query_unref> query(gst_query_new_latency());
  EXPECT_TRUE(gst_pad_peer_query(h->sinkpad, query.get()));
  gboolean live = TRUE;
  GstClockTime min = 1;
  gst_query_parse_latency(query.get(), &live, &min, nullptr);
  EXPECT_FALSE(live);
  EXPECT_EQ(min, 0u);
  gst_harness_push_upstream_event(
      h.get(), gst_event_new_qos(GST_QOS_TYPE_UNDERFLOW, 1.5, GST_SECOND, GST_SECOND));
  while (const auto event = Ref<GstEvent>::adopt(gst_harness_try_pull_upstream_event(sink.get())))
    EXPECT_NE(GST_EVENT_TYPE(event.get()), GST_EVENT_QOS);
}

}  // namespace tensor_reposrc_test
}  // namespace weir::test
