// tensor_decoder in modes that write results: the model of the stream, source maps, GAP events.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <filesystem>
#include <fstream>

#include "elements/tensor_decoder/result_test_support.hpp"
#include "gstcpp/element/file_digest.hpp"
#include "gstcpp/element/result_events.hpp"

namespace weir::testing_tensor_decoder {
namespace result_test {

const Rows kBoth{"1:0.9@14,5,18,11^-1", "0:0.5@6,19,14,21^-1"};

Rows decoded_rows(const Harness& h, GstBuffer* in) {
  if (gst_harness_push(h.get(), in) != GST_FLOW_OK) return {"not accepted"};
  const auto out = Ref<GstBuffer>::adopt(gst_harness_try_pull(h.get()));
  return out ? read_rows(h, out.get()) : Rows{"nothing"};
}
void send_model(const Harness& h, const DescribedModel& model) {
  EXPECT_TRUE(gst_harness_push_event(h.get(), gst::make_model_event(model).release()));
}
// Sends the events of a stream as upstream elements do when they link late.
void begin(const Harness& h, const std::string& caps, const DescribedModel* model = nullptr) {
  gst_harness_push_event(h.get(), gst_event_new_stream_start("test"));
  if (model) send_model(h, *model);
  gst_harness_push_event(
      h.get(), gst_event_new_caps(Ref<GstCaps>::adopt(gst_caps_from_string(caps.c_str())).get()));
  gst_harness_push_event(h.get(), time_segment());
}
std::string named(const std::string& head) {
  return "tensor_decoder mode=detection custom=head:" + head;
}

TEST(ResultDecoder, NamesTheModelOfTheStream) {
  const auto h = make_harness("tensor_decoder mode=detection");
  const auto model = yolo_model();
  begin(h, kYoloCaps, &model);
  EXPECT_SAYS(caps_text(h), "weir-source=(string)shapes");
  EXPECT_SAYS(caps_text(h), "weir-columns=(string)\"x1\\,y1\\,x2\\,y2\\,score\\,class");
  EXPECT_SAYS(caps_text(h), "framerate=(fraction)30/1");
  EXPECT_EQ(decoded_rows(h, frame(yolo(kTwo))), kBoth);
}

TEST(ResultDecoder, TakesTheModelOfAFlexibleStreamBeforeOrAfterItsCaps) {
  for (const bool before : {true, false}) {
    const auto h = make_harness("tensor_decoder mode=detection");
    Errors errors(h);
    const auto model = yolo_model();
    begin(h, kFlexible, before ? &model : nullptr);
    if (!before) {
      EXPECT_EQ(caps_text(h), "");
      send_model(h, yolo_model());
    }
    EXPECT_SAYS(caps_text(h), "weir-source=(string)shapes");
    EXPECT_EQ(decoded_rows(h, with_header(yolo(kTwo), {21, 7})), kBoth);
    EXPECT_EQ(errors.next(), "");
    EXPECT_EQ(stat(h, "received"), 1u);
    EXPECT_EQ(stat(h, "pushed"), 1u);
  }
}

TEST(ResultDecoder, SaysWithTheFirstFrameWhatAStreamWithoutAModelLacks) {
  const auto h = make_harness("tensor_decoder mode=detection");
  Errors errors(h);
  begin(h, kFlexible);
  EXPECT_EQ(errors.next(), "") << "the model may follow";
  EXPECT_EQ(decoded_rows(h, with_header(yolo(kTwo), {21, 7})), (Rows{"not accepted"}));
  EXPECT_SAYS(errors.next(), "the stream does not describe the model's outputs");
  EXPECT_EQ(stat(h, "received"), 1u);
  EXPECT_EQ(stat(h, "dropped"), 1u);
}

TEST(ResultDecoder, WarnsOnceOfValuesThatContradictTheReading) {
  const auto h = make_harness(named("yolov8,input:32:32,unit:picture"));
  begin(h, kYoloCaps);
  Errors messages(h);
  for (int i = 0; i < 2; ++i) gst_harness_push(h.get(), frame(yolo(kTwo)));
  const auto warning = messages.next_warning();
  EXPECT_SAYS(warning, "the coordinates contradict the setting unit");
  EXPECT_SAYS(warning, "custom=unit:pixels");
  EXPECT_EQ(messages.next_warning(), "");
  gst_harness_set(h.get(), "tensor_decoder", "threshold", 0.3, nullptr);  // opens it again
  gst_harness_push(h.get(), frame(yolo(kTwo)));
  EXPECT_EQ(messages.next_warning(), "") << "the same text";
}

TEST(ResultDecoder, IgnoresTheModelOfOtherTensors) {
  DescribedModel other = yolo_model("other");
  other.outputs[0].shape = {1, 7, 84};
  const auto h = make_harness(named("yolov8,input:32:32"));
  begin(h, kYoloCaps, &other);
  EXPECT_LACKS(caps_text(h), "other.onnx");
  EXPECT_LACKS(caps_text(h), "weir-source=(string)other");
  EXPECT_EQ(decoded_rows(h, frame(yolo(kTwo))), kBoth);
}

TEST(ResultDecoder, FollowsAModelThatChangesBetweenFrames) {
  const auto h = make_harness("tensor_decoder mode=detection");
  Errors errors(h);
  const auto model = yolo_model();
  begin(h, kYoloCaps, &model);
  EXPECT_EQ(decoded_rows(h, frame(yolo(kTwo))), kBoth);
  send_model(h, yolo_model());
  EXPECT_EQ(decoded_rows(h, frame(yolo(kTwo))), kBoth);
  EXPECT_SAYS(caps_text(h), "weir-source=(string)shapes");
  send_model(h, yolo_model("newer"));
  EXPECT_EQ(decoded_rows(h, frame(yolo(kTwo))), kBoth);
  EXPECT_SAYS(caps_text(h), "weir-source=(string)newer");
  EXPECT_EQ(errors.next(), "");
}

TEST(ResultDecoder, ForgetsTheModelWithItsStream) {
  const auto h = make_harness(named("yolov8,input:32:32"));
  const auto model = yolo_model();
  begin(h, kYoloCaps, &model);
  EXPECT_SAYS(caps_text(h), "weir-source=(string)shapes");
  begin(h, tensor("float32", "7:21:1"));  // with another start of the stream
  EXPECT_LACKS(caps_text(h), "shapes");
}

TEST(ResultDecoder, IgnoresEventsThatDescribeNoModel) {
  const auto h = make_harness(named("yolov8,input:32:32"));
  Errors errors(h);
  const auto send = [&](GstStructure* s) {
    gst_harness_push_event(h.get(), gst_event_new_custom(GST_EVENT_CUSTOM_DOWNSTREAM_STICKY, s));
  };
  send(gst_structure_new_empty("weir-model"));
  begin(h, kYoloCaps);
  send(gst_structure_new("weir-model", "version", G_TYPE_UINT, 1u, "outputs", G_TYPE_STRING, "?",
                         nullptr));
  EXPECT_EQ(decoded_rows(h, frame(yolo(kTwo))), kBoth);
  EXPECT_EQ(errors.next(), "");
  EXPECT_EQ(errors.next_warning(), "");
}

TEST(ResultDecoder, DoesNotPassTheModelOnBecauseResultsAreNotItsOutputs) {
  const auto h = make_harness("tensor_decoder mode=detection");
  const auto model = yolo_model();
  begin(h, kYoloCaps, &model);
  EXPECT_EQ(decoded_rows(h, frame(yolo(kTwo))), kBoth);
  EXPECT_FALSE(Ref<GstEvent>::adopt(
      gst_pad_get_sticky_event(h->sinkpad, GST_EVENT_CUSTOM_DOWNSTREAM_STICKY, 0)));
}

std::optional<gst::LabelsOfSource> sent_labels(const Harness& h) {
  const auto event = Ref<GstEvent>::adopt(
      gst_pad_get_sticky_event(h->sinkpad, GST_EVENT_CUSTOM_DOWNSTREAM_STICKY, 0));
  return event ? gst::parse_labels_event(event.get()) : std::nullopt;
}
using gst::LabelsOfSource;
const std::vector<std::string> kThree{"cat", "dog", "bird"};

TEST(ResultDecoder, NamesTheClassesOfTheModelDownstream) {
  const auto h = make_harness("tensor_decoder mode=detection");
  auto model = yolo_model();
  model.metadata_json = R"({"names":"{0: 'cat', 1: 'dog', 2: 'bird'}"})";
  begin(h, kYoloCaps, &model);
  EXPECT_EQ(sent_labels(h), (LabelsOfSource{"shapes", kThree}));
  EXPECT_EQ(decoded_rows(h, frame(yolo(kTwo))), kBoth);
  // A model of the same name without labels takes them back.
  send_model(h, yolo_model());
  EXPECT_EQ(sent_labels(h), (LabelsOfSource{"shapes", {}}));
}

TEST(ResultDecoder, NamesTheClassesOfTheUserDownstream) {
  const std::string path = testing::TempDir() + "weir-result-labels.txt";
  std::ofstream(path) << "one\ntwo\nthree\n";
  const auto h = make_harness("tensor_decoder mode=detection labels=" + path);
  auto model = yolo_model();
  model.metadata_json = R"({"names":"{0: 'cat', 1: 'dog', 2: 'bird'}"})";
  begin(h, kYoloCaps, &model);
  EXPECT_EQ(sent_labels(h), (LabelsOfSource{"shapes", {"one", "two", "three"}}));
  std::filesystem::remove(path);
}

std::vector<std::string> warnings_for_labels(const std::string& text) {
  const std::string path = testing::TempDir() + "weir-few-labels.txt";
  std::ofstream(path) << text;
  const auto h = make_harness("tensor_decoder mode=detection custom=head:yolov8 labels=" + path);
  Errors errors(h);
  const auto model = yolo_model();
  begin(h, kYoloCaps, &model);
  begin(h, kYoloCaps, &model);
  EXPECT_EQ(decoded_rows(h, frame(yolo(kTwo))), kBoth);
  std::vector<std::string> out;
  for (std::string one; !(one = errors.next_warning()).empty();) out.push_back(one);
  std::filesystem::remove(path);
  return out;
}

TEST(ResultDecoder, WarnsOnceOfFewerLabelsThanClasses) {
  const auto warnings = warnings_for_labels("one\ntwo\n");
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_SAYS(warnings[0], "WEIR-4002: there are fewer labels than classes");
  EXPECT_SAYS(warnings[0], "offered: 2 labels of labels=");
  EXPECT_SAYS(warnings[0], "weir-few-labels.txt");
  EXPECT_SAYS(warnings[0], "needed: 3 labels, one for each class of the model");
  EXPECT_SAYS(warnings[0], "fix: tensor_decoder labels=FILE with a line for each class");
}

TEST(ResultDecoder, DoesNotWarnOfEnoughLabels) {
  EXPECT_TRUE(warnings_for_labels("one\ntwo\nthree\n").empty());
  EXPECT_TRUE(warnings_for_labels("one\ntwo\nthree\nfour\n").empty());
}

// A model file with a card beside it.
class ResultCards : public testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::create_directories(folder_);
    std::ofstream(folder_ + "/shapes.onnx") << "a model";
    model_.path = folder_ + "/shapes.onnx";
    write_card(gst::compute_sha256(model_.path));
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  void write_card(const std::string& digest) const {
    std::ofstream(folder_ + "/shapes.card.json")
        << R"({"name":"shapes","model":"shapes.onnx","sha256":")" << digest
        << R"(","task":"detection","inputs":[{"name":"x","type":"uint8","shape":[1,32,32,3],)"
        << R"("layout":"NHWC","color":"RGB","resize":"stretch"}],"outputs":[],)"
        << R"("labels":["cat","dog","bird"],"decoder":"detection",)"
        << R"("provenance":{"source":"a test","licence":"none"}})";
  }
  const std::string folder_ = testing::TempDir() + "weir-result-cards";
  DescribedModel model_ = yolo_model();
};

TEST_F(ResultCards, NameTheClassesDownstream) {
  const auto h = make_harness("tensor_decoder mode=detection");
  begin(h, kYoloCaps, &model_);
  EXPECT_EQ(sent_labels(h), (LabelsOfSource{"shapes", kThree}));
  EXPECT_EQ(decoded_rows(h, frame(yolo(kTwo))), kBoth);
}

TEST_F(ResultCards, NameTheClassesOfACopyWithAnotherName) {
  std::filesystem::create_directories(folder_ + "/copies");
  model_.path = folder_ + "/copies/mine.onnx";
  std::filesystem::copy_file(folder_ + "/shapes.onnx", model_.path);
  const char* const before = g_getenv("WEIR_CARD_PATH");
  const std::string kept = before ? before : "";
  g_setenv("WEIR_CARD_PATH", folder_.c_str(), TRUE);
  const auto h = make_harness("tensor_decoder mode=detection");
  begin(h, kYoloCaps, &model_);
  before ? static_cast<void>(g_setenv("WEIR_CARD_PATH", kept.c_str(), TRUE))
         : g_unsetenv("WEIR_CARD_PATH");
  EXPECT_EQ(sent_labels(h), (LabelsOfSource{"mine", kThree}));
}

TEST_F(ResultCards, NameTheClassesWhenTheLabelsAreTakenBack) {
  const std::string file = folder_ + "/own.txt";
  std::ofstream(file) << "a\nb\nc\n";
  const auto h = make_harness("tensor_decoder mode=detection labels=" + file);
  begin(h, kYoloCaps, &model_);
  EXPECT_EQ(sent_labels(h), (LabelsOfSource{"shapes", {"a", "b", "c"}}));
  gst_harness_set(h.get(), "tensor_decoder", "labels", "", nullptr);
  decoded_rows(h, frame(yolo(kTwo)));
  EXPECT_EQ(sent_labels(h), (LabelsOfSource{"shapes", kThree}));
}

TEST_F(ResultCards, OfAnotherFileNameNothing) {
  write_card(std::string(64, '0'));
  const auto h = make_harness("tensor_decoder mode=detection");
  Errors errors(h);
  begin(h, kYoloCaps, &model_);
  EXPECT_FALSE(sent_labels(h));
  EXPECT_EQ(decoded_rows(h, frame(yolo(kTwo))), kBoth);
  EXPECT_EQ(errors.next(), "");
}

TEST_F(ResultCards, ThatCannotBeReadNameNothing) {
  std::ofstream(folder_ + "/shapes.card.json") << "{";
  const auto h = make_harness("tensor_decoder mode=detection");
  Errors errors(h);
  begin(h, kYoloCaps, &model_);
  EXPECT_FALSE(sent_labels(h));
  EXPECT_EQ(errors.next(), "");
}

TEST(ResultDecoder, ResultsAreInPixelsOfTheSourcePicture) {
  const auto h = make_harness("tensor_decoder mode=detection");
  const auto model = yolo_model();
  begin(h, kYoloCaps, &model);
  SourceMap map;
  map.xx = map.yy = 10, map.x0 = -5, map.y0 = 7;
  map.width = map.height = 32;
  map.source_width = 640, map.source_height = 480;
  GstBuffer* in = frame(yolo({kTwo[0]}));
  gst::set_source_maps(in, {map});
  ASSERT_EQ(gst_harness_push(h.get(), in), GST_FLOW_OK);
  const auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
  EXPECT_EQ(read_rows(h, out.get()), (Rows{"1:0.9@135,57,175,117^-1"}));
  const auto maps = gst::source_maps(out.get());
  ASSERT_EQ(maps.size(), 1u);
  EXPECT_EQ(maps[0].to_source({3, 4}).x, 3) << "the identity";
  EXPECT_EQ(maps[0].to_source({3, 4}).y, 4);
  EXPECT_EQ(maps[0].source_width, 640u);
  EXPECT_EQ(maps[0].height, 480u);
}

TEST(ResultDecoder, AGapBecomesAFrameWithoutResults) {
  const auto h = make_harness("tensor_decoder mode=detection");
  const auto model = yolo_model();
  begin(h, kYoloCaps, &model);
  ASSERT_TRUE(gst_harness_push_event(h.get(), gst_event_new_gap(50, 7)));
  const auto out = Ref<GstBuffer>::adopt(gst_harness_try_pull(h.get()));
  ASSERT_TRUE(out);
  EXPECT_EQ(read_rows(h, out.get()), (Rows{"background"}));
  EXPECT_EQ(GST_BUFFER_PTS(out.get()), 50u);
  EXPECT_EQ(GST_BUFFER_DURATION(out.get()), 7u);
  EXPECT_EQ(stat(h, "pushed"), 1u);
  EXPECT_EQ(stat(h, "received"), 0u);
}

TEST(ResultDecoder, AGapOfOtherModesStaysAGap) {
  const auto h = make_harness("tensor_decoder mode=octet_stream", kYoloCaps);
  ASSERT_TRUE(gst_harness_push_event(h.get(), gst_event_new_gap(50, 7)));
  EXPECT_FALSE(Ref<GstBuffer>::adopt(gst_harness_try_pull(h.get())));
  bool found = false;
  while (const auto event = Ref<GstEvent>::adopt(gst_harness_try_pull_event(h.get())))
    found = found || GST_EVENT_TYPE(event.get()) == GST_EVENT_GAP;
  EXPECT_TRUE(found);
}

}  // namespace result_test
}  // namespace weir::testing_tensor_decoder
