// The event with which tensor_filter describes its model downstream.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/element/model_event.hpp"

#include "elements/tensor_filter/adder_test_support.hpp"

namespace tensor_filter_model_event_test {

using namespace weir;
using namespace weir::test;

// The types of the serialized events so far, "model" for that of the model.
std::vector<std::string> get_events(const Harness& h) {
  std::vector<std::string> out;
  while (const auto event = Ref<GstEvent>::adopt(gst_harness_try_pull_event(h.get())))
    if (gst_event_type_get_flags(GST_EVENT_TYPE(event.get())) & GST_EVENT_TYPE_SERIALIZED)
      out.push_back(gst::is_model_event(event.get())
                        ? "model"
                        : gst_event_type_get_name(GST_EVENT_TYPE(event.get())));
  return out;
}
// What the sticky event of the output says.
std::optional<DescribedModel> described_by(const Harness& h) {
  for (guint i = 0;; ++i) {
    const auto event = Ref<GstEvent>::adopt(
        gst_pad_get_sticky_event(h->sinkpad, GST_EVENT_CUSTOM_DOWNSTREAM_STICKY, i));
    if (!event) return std::nullopt;
    if (auto model = gst::parse_model_event(event.get())) return model;
  }
}
using Events = std::vector<std::string>;

TEST(ModelEventOfFilter, PrecedesTheCapsOnce) {
  const AdderFiles files;
  const auto h = make_harness(adder(files.model(1)), kAdderCaps);
  EXPECT_EQ(pushed_sum(h), 1);
  EXPECT_EQ(pushed_sum(h), 1);
  EXPECT_EQ(get_events(h), (Events{"stream-start", "model", "caps", "segment"}));
  const auto model = described_by(h);
  ASSERT_TRUE(model);
  EXPECT_EQ(model->path, files.model(1));
  ASSERT_EQ(model->inputs.size(), 1u);
  ASSERT_EQ(model->outputs.size(), 1u);
  EXPECT_EQ(model->outputs[0].type, ElementType::Float32);
  EXPECT_EQ(model->outputs[0].shape, (std::vector<int64_t>{1, 4}));
  EXPECT_EQ(model->outputs[0].scale, 0);
}

TEST(ModelEventOfFilter, IsSentInEveryMode) {
  const AdderFiles files;
  for (const char* mode : {"workers=2", "when-busy=block", "invoke-dynamic=true"}) {
    const auto h = make_harness(adder(files.model(1), mode), kAdderCaps);
    ASSERT_EQ(gst_harness_push(h.get(), frame<float>({0, 0, 0, 0})), GST_FLOW_OK);
    ASSERT_TRUE(Ref<GstBuffer>::adopt(gst_harness_pull(h.get()))) << mode;
    EXPECT_TRUE(described_by(h)) << mode;
    EXPECT_EQ(get_events(h), (Events{"stream-start", "model", "caps", "segment"})) << mode;
  }
}

TEST(ModelEventOfFilter, FollowsAModelThatIsReplaced) {
  const AdderFiles files;
  const auto h = make_harness(adder(files.model(1), "is-updatable=true"), kAdderCaps);
  EXPECT_EQ(pushed_sum(h), 1);
  get_events(h);
  g_object_set(find_element(h, "tensor_filter").get(), "model", files.model(2).c_str(), nullptr);
  EXPECT_EQ(pushed_sum(h), 2);
  EXPECT_EQ(get_events(h), Events{"model"});
  EXPECT_EQ(described_by(h)->path, files.model(2));
  EXPECT_EQ(pushed_sum(h), 2);
  EXPECT_EQ(get_events(h), Events{});
}

TEST(ModelEventOfFilter, FollowsPropertiesThatChange) {
  const AdderFiles files;
  const auto h = make_harness(adder(files.model(1)), kAdderCaps);
  EXPECT_EQ(pushed_sum(h), 1);
  get_events(h);
  g_object_set(find_element(h, "tensor_filter").get(), "inputname", "picture", nullptr);
  EXPECT_EQ(pushed_sum(h), 1);
  EXPECT_EQ(described_by(h)->inputs[0].name, "picture");
}

TEST(ModelEventOfFilter, DescribesWhatIsPushed) {
  const AdderFiles files;
  const auto h = make_harness(adder(files.model(1), "output-combination=i0,o0"), kAdderCaps);
  ASSERT_EQ(gst_harness_push(h.get(), frame<float>({0, 0, 0, 0})), GST_FLOW_OK);
  const auto model = described_by(h);
  ASSERT_TRUE(model);
  ASSERT_EQ(model->outputs.size(), 2u);
  EXPECT_EQ(model->inputs.size(), 1u);
  EXPECT_EQ(model->outputs[0].name, "") << "a tensor of the stream";
  EXPECT_EQ(model->outputs[0].shape.back(), 4);
}

TEST(ModelEventOfFilter, HasQuantisationAndMetadata) {
  const AdderFiles files;
  const auto path = files.write("quantised.bin", "x");
  const auto h = make_harness("tensor_filter framework=fake-models model=" + path,
                              tensors("uint8", "3:4:4:1"));
  ASSERT_EQ(gst_harness_push(h.get(), frame(Bytes(48))), GST_FLOW_OK);
  const auto model = described_by(h);
  ASSERT_TRUE(model);
  EXPECT_EQ(model->inputs[0].scale, 0.0078125f);
  EXPECT_EQ(model->inputs[0].zero_point, 128);
  EXPECT_EQ(model->inputs[0].name, "picture");
  EXPECT_EQ(model->inputs[0].shape, (std::vector<int64_t>{1, 4, 4, 3}));
  EXPECT_EQ(model->outputs[0].name, "classes");
  EXPECT_SAYS(model->metadata_json, "\"description\"");
}

TEST(ModelEventOfFilter, ReplacesThatOfAFilterUpstream) {
  const AdderFiles files;
  const auto h =
      make_harness(adder(files.model(1)) + " ! queue ! " + adder(files.model(2)), kAdderCaps);
  EXPECT_EQ(pushed_sum(h), 3);
  EXPECT_EQ(described_by(h)->path, files.model(2));
  const auto events = get_events(h);
  EXPECT_EQ(std::count(events.begin(), events.end(), "model"), 1);
}

TEST(ModelEventOfFilter, PassesElementsThatKeepTheTensors) {
  const AdderFiles files;
  for (const char* element : {"queue", "identity", "capsfilter", "tensor_debug", "tensor_rate",
                              "valve", "queue ! tensor_debug ! queue"}) {
    const auto h = make_harness(adder(files.model(1)) + " ! " + element, kAdderCaps);
    EXPECT_EQ(pushed_sum(h), 1) << element;
    ASSERT_TRUE(described_by(h)) << element;
    EXPECT_EQ(described_by(h)->path, files.model(1));
  }
}

TEST(ModelEventOfFilter, EndsWhereTensorsChange) {
  const AdderFiles files;
  for (const char* element :
       {"tensor_transform mode=typecast option=float32", "tensor_aggregator frames-out=1",
        "tensor_converter", "tensor_sparse_enc ! tensor_sparse_dec", "tensor_mux", "tensor_merge",
        "tensor_split tensorseg=4:1 ! identity", "tensor_mux ! tensor_demux ! identity"}) {
    const auto h = make_harness(adder(files.model(1)) + " ! " + element, kAdderCaps);
    EXPECT_EQ(gst_harness_push(h.get(), frame<float>({0, 0, 0, 0}, 0)), GST_FLOW_OK) << element;
    EXPECT_TRUE(gst_harness_push_event(h.get(), gst_event_new_eos()));
    EXPECT_TRUE(Ref<GstBuffer>::adopt(gst_harness_pull(h.get()))) << element;
    EXPECT_FALSE(described_by(h)) << element;
  }
}

}  // namespace tensor_filter_model_event_test
