// Two networks in one pipeline: the objects that the first finds are regions of the second, and the
// rows of both are in one frame.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_decoder/result_test_support.hpp"
#include "elements/tensor_filter/custom_easy_test_support.hpp"

namespace weir::testing_tensor_decoder {
namespace result_chain_test {

using In = std::span<const weir_tensor>;
using Out = std::span<weir_tensor>;

// Writes a head that sees `objects` into each picture of a batch.
void see(const std::vector<std::vector<Seen>>& pictures, Out out) {
  const auto numbers = weir::elements<float>(out[0]);
  for (size_t i = 0; i < pictures.size(); ++i) {
    const auto head = yolo(pictures[i]);
    std::copy(head.begin(), head.end(), numbers.begin() + static_cast<ptrdiff_t>(i * head.size()));
  }
}
FilterDescription network(int64_t batch) {
  return {.inputs = {tensor_info("picture", WEIR_UINT8, {batch, 32, 32, 3})},
          .outputs = {tensor_info("head", WEIR_FLOAT32, {batch, 7, 21})}};
}
constexpr char kReadHead[] = "tensor_decoder mode=detection custom=head:yolov8,input:32:32";

// Frames that the pipeline makes of pictures of 64 x 64.
class Chain {
 public:
  explicit Chain(std::vector<std::vector<Seen>> first_of_frames)
      : first_(
            "chain-first", network(1),
            [this, seen = std::move(first_of_frames)](In, Out out) {
              see({seen[std::min(frames_++, seen.size() - 1)]}, out);
            },
            functions()),
        // It sees the same in each region: the middle quarter.
        second_(
            "chain-second", network(3),
            [](In, Out out) {
              const std::vector<Seen> middle{{0, 16, 16, 16, 16, 2, 0.75f}};
              see({middle, middle, middle}, out);
            },
            functions()) {
    const std::string line =
        "appsrc name=in format=time caps=video/x-raw,format=RGB,width=64,height=64,framerate=10/1 "
        "! tee name=video "
        "video. ! queue ! tensor_preprocess width=32 height=32 ! "
        "tensor_filter framework=custom-easy model=chain-first ! " +
        std::string(kReadHead) +
        " ! tee name=found found. ! queue ! both.sink_0 "
        "video. ! queue ! tensor_preprocess name=cut regions=pad max-regions=3 width=32 height=32 "
        "! tensor_filter framework=custom-easy model=chain-second ! " +
        kReadHead +
        " ! queue ! both.sink_1 "
        "found. ! queue ! cut.regions "
        "tensor_mux name=both ! appsink name=out sync=false";
    pipeline_ = lone_element(line);
    bus_ = Ref<GstBus>::adopt(gst_element_get_bus(pipeline_.get()));
    gst_element_set_state(pipeline_.get(), GST_STATE_PLAYING);
  }
  ~Chain() { gst_element_set_state(pipeline_.get(), GST_STATE_NULL); }
  Chain(const Chain&) = delete;
  Chain& operator=(const Chain&) = delete;

  void push(GstClockTime time) {
    const auto in = named("in");
    GstFlowReturn flow = GST_FLOW_OK;
    const auto buffer = Ref<GstBuffer>::adopt(test::frame(Bytes(64 * 64 * 3), time, 1));
    g_signal_emit_by_name(in.get(), "push-buffer", buffer.get(), &flow);
    EXPECT_EQ(flow, GST_FLOW_OK);
  }
  // The rows of both networks in the next frame.
  std::pair<Rows, Rows> next() {
    const auto out = named("out");
    GstSample* raw = nullptr;
    g_signal_emit_by_name(out.get(), "try-pull-sample", 10 * GST_SECOND, &raw);
    const Unique<GstSample, gst_sample_unref> sample(raw);
    if (!sample) return {{"none: " + take_message(bus_.get(), GST_MESSAGE_ERROR)}, {}};
    GstBuffer* const buffer = gst_sample_get_buffer(sample.get());
    GstCaps* const caps = gst_sample_get_caps(sample.get());
    return {read_rows(buffer, caps, 0), read_rows(buffer, caps, 1)};
  }

 private:
  Ref<GstElement> named(const char* name) {
    return Ref<GstElement>::adopt(gst_bin_get_by_name(GST_BIN(pipeline_.get()), name));
  }
  size_t frames_ = 0;
  RegisteredFilter first_, second_;
  Ref<GstElement> pipeline_;
  Ref<GstBus> bus_;
};

using Frame = std::pair<Rows, Rows>;

TEST(ResultChain, ObjectsOfTheSecondNetworkBelongToThoseOfTheFirst) {
  Chain chain({kTwo});
  chain.push(0);
  // The picture is twice as large as the network's; the middle quarter of each box.
  EXPECT_EQ(chain.next(), (Frame{{"1:0.9@28,10,36,22^-1", "0:0.5@12,38,28,42^-1"},
                                 {"2:0.75@30,13,34,19^0", "2:0.75@16,39,24,41^1"}}));
}

TEST(ResultChain, PicturesWithoutObjectsHaveTwoEmptyTensorsAndNothingWaits) {
  const std::vector<Seen> one{kTwo[0]};
  Chain chain({{}, one, {}, one});
  for (GstClockTime i = 0; i < 4; ++i) chain.push(i * 100 * GST_MSECOND);
  const Frame nothing{{"background"}, {"background"}};
  const Frame found{{"1:0.9@28,10,36,22^-1"}, {"2:0.75@30,13,34,19^0"}};
  for (const Frame& expected : {nothing, found, nothing, found}) EXPECT_EQ(chain.next(), expected);
}

}  // namespace result_chain_test
}  // namespace weir::testing_tensor_decoder
