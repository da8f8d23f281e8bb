// Results as flexible tensors through whole pipelines: which rows come out of mux, demux, crop, if,
// rate, join and loops, and the columns and the source of each tensor.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstring>

#include "core/tensor/tensor_header.hpp"
#include "elements/tests/pipeline_test_support.hpp"
#include "gstcpp/buffer/tensor_caps.hpp"

namespace weir::test {
namespace result_stream_test {

constexpr char kFlexible[] = "other/tensors,format=flexible,framerate=10/1";
constexpr char kBoxColumns[] = "x1,y1,x2,y2,score,class";
constexpr size_t kLength = 6;  // numbers of a row

std::string results_caps(const std::string& columns, const std::string& source) {
  return std::string(kFlexible) + ",weir-columns=(string)\"" + columns +
         "\",weir-source=(string)\"" + source + "\"";
}
const std::string kBoxes = results_caps(std::string(kBoxColumns) + ";masks", "yolo;yolo");

Bytes with_header(ElementType type, const Shape& shape, const void* numbers, size_t bytes) {
  TensorHeader header;
  header.format = Format::Flexible;
  header.spec = {type, shape, {}};
  Bytes out(kTensorHeaderBytes + bytes);
  write_tensor_header(header, std::as_writable_bytes(std::span(out)).first<kTensorHeaderBytes>());
  std::memcpy(out.data() + kTensorHeaderBytes, numbers, bytes);
  return out;
}
// A row for each score, with a box and a class that differ; and as many masks of 2x1.
struct Frame {
  std::vector<float> scores;
  uint8_t mask = 0;
};
Ref<GstBuffer> make_buffer(const Frame& frame, GstClockTime time) {
  std::vector<float> rows;
  for (size_t i = 0; i < frame.scores.size(); ++i) {
    const auto at = static_cast<float>(i);
    rows.insert(rows.end(), {at, at, at + 2, at + 3, frame.scores[i], at + 1});
  }
  const auto count = static_cast<uint32_t>(frame.scores.size());
  const Bytes masks(size_t{2} * count, frame.mask);
  auto out = Ref<GstBuffer>::adopt(gst_buffer_new());
  gst_buffer_append_memory(
      out.get(), make_memory(with_header(ElementType::Float32, Shape{kLength, count}, rows.data(),
                                         rows.size() * sizeof(float))));
  gst_buffer_append_memory(
      out.get(),
      make_memory(with_header(ElementType::UInt8, Shape{2, 1, count}, masks.data(), masks.size())));
  GST_BUFFER_PTS(out.get()) = time;
  GST_BUFFER_DURATION(out.get()) = 100 * GST_MSECOND;
  return out;
}

// "float32 6:2 x1,...|yolo: 0.5 0.25": a tensor with its columns and source; of rows the scores.
std::string text_of_tensor(const Bytes& bytes, const ResultRole& role) {
  const auto header = read_tensor_chunk(std::as_bytes(std::span(bytes)));
  if (!header) return header.error().what;
  std::string out = header->spec.to_string() + " " + role.columns + "|" + role.source + ":";
  const auto payload = std::span(bytes).subspan(kTensorHeaderBytes);
  if (header->spec.type != ElementType::Float32) return out + " " + std::to_string(payload[0]);
  std::vector<float> numbers(payload.size() / sizeof(float));
  std::memcpy(numbers.data(), payload.data(), payload.size());
  for (size_t i = 4; i < numbers.size(); i += kLength) {
    char text[32];
    std::snprintf(text, sizeof text, " %g", static_cast<double>(numbers[i]));
    out += text;
  }
  return out;
}
using Texts = std::vector<std::string>;

class Streams {
 public:
  // `line` has an appsrc `in0`, `in1` for each of `caps`, and an appsink `out`.
  Streams(const std::string& line, const std::vector<std::string>& caps) : pipeline_(line) {
    for (size_t i = 0; i < caps.size(); ++i) {
      const auto parsed = Ref<GstCaps>::adopt(gst_caps_from_string(caps[i].c_str()));
      g_object_set(input(i).get(), "caps", parsed.get(), "format", GST_FORMAT_TIME, nullptr);
    }
    bus_ = Ref<GstBus>::adopt(gst_element_get_bus(pipeline_.get()));
    gst_element_set_state(pipeline_.get(), GST_STATE_PLAYING);
  }
  void push(size_t index, const Ref<GstBuffer>& buffer) {
    GstFlowReturn flow = GST_FLOW_OK;
    g_signal_emit_by_name(input(index).get(), "push-buffer", buffer.get(), &flow);
  }
  void push(size_t index, const std::vector<Frame>& frames) {
    for (const Frame& frame : frames) push(index, make_buffer(frame, time_++ * 100 * GST_MSECOND));
  }
  void end(size_t index) {
    GstFlowReturn flow = GST_FLOW_OK;
    g_signal_emit_by_name(input(index).get(), "end-of-stream", &flow);
  }
  // The tensors of the next frame; "end", or "error: ..." if there is none.
  Texts next() {
    GstSample* raw = nullptr;
    g_signal_emit_by_name(pipeline_.find("out").get(), "try-pull-sample", 20 * GST_SECOND, &raw);
    const Unique<GstSample, gst_sample_unref> sample(raw);
    const std::string error = take_message(bus_.get(), GST_MESSAGE_ERROR);
    if (!sample) return {error.empty() ? "end" : "error: " + error};
    auto roles = gst::roles_from_caps(gst_sample_get_caps(sample.get()));
    GstBuffer* const buffer = gst_sample_get_buffer(sample.get());
    roles.resize(std::max<size_t>(roles.size(), gst_buffer_n_memory(buffer)));
    Texts out;
    for (guint i = 0; i < gst_buffer_n_memory(buffer); ++i)
      out.push_back(text_of_tensor(content(gst_buffer_peek_memory(buffer, i)), roles[i]));
    return out;
  }
  std::string error() { return take_message(bus_.get(), GST_MESSAGE_ERROR); }

 private:
  Ref<GstElement> input(size_t index) const {
    return pipeline_.find(("in" + std::to_string(index)).c_str());
  }
  PlayedPipeline pipeline_;
  Ref<GstBus> bus_;
  GstClockTime time_ = 0;  // of the next frame, in frames
};

constexpr char kOut[] = "appsink name=out sync=false";
// The frames that come out of `line` between one input and the output.
std::vector<Texts> through(const std::string& line, const std::vector<Frame>& frames,
                           const std::string& caps = kBoxes) {
  Streams streams("appsrc name=in0 ! " + line + kOut, {caps});
  streams.push(0, frames);
  streams.end(0);
  std::vector<Texts> out;
  for (Texts next = streams.next(); next != Texts{"end"}; next = streams.next()) {
    out.push_back(next);
    if (next[0].starts_with("error")) break;
  }
  return out;
}
std::string rows(const std::string& scores, size_t count, const std::string& source = "yolo") {
  return "float32 6:" + std::to_string(count) + " " + kBoxColumns + "|" + source + ": " + scores;
}
std::string masks(int value, size_t count, const std::string& source = "yolo") {
  return "uint8 2:1:" + std::to_string(count) + " masks|" + source + ": " + std::to_string(value);
}
const std::vector<Frame> kTwo{{{0.5f, 0.25f}, 7}, {{0.75f}, 9}};
const Texts kFirst{rows("0.5 0.25", 2), masks(7, 2)}, kSecond{rows("0.75", 1), masks(9, 1)};

TEST(ResultStream, PassesTensorIfByAValueOfEachFrame) {
  const std::string condition =
      "tensor_if name=f compared-value=A_VALUE compared-value-option=4:0,0 operator=GT "
      "supplied-value=0.6 ";
  EXPECT_EQ(through(condition + "then=PASSTHROUGH else=SKIP f.src_0 ! ", kTwo),
            std::vector<Texts>{kSecond});
  EXPECT_EQ(through(condition + "then=SKIP else=PASSTHROUGH f.src_1 ! ", kTwo),
            std::vector<Texts>{kFirst});
  EXPECT_EQ(through(condition + "then=TENSORPICK then-option=1 else=SKIP f.src_0 ! ", kTwo),
            (std::vector<Texts>{{masks(9, 1)}}));
  EXPECT_EQ(through(condition + "then=SKIP else=TENSORPICK else-option=1,0 f.src_1 ! ", kTwo),
            (std::vector<Texts>{{masks(7, 2), rows("0.5 0.25", 2)}}));
}

TEST(ResultStream, PassesTensorIfByTheAverageOfATensorOfEachSize) {
  EXPECT_EQ(through("tensor_if name=f compared-value=TENSOR_AVERAGE_VALUE compared-value-option=1 "
                    "operator=EQ supplied-value=9 then=PASSTHROUGH else=SKIP f.src_0 ! ",
                    {{{0.5f, 0.25f, 0.125f}, 9}, {{1}, 8}, {{0.75f}, 9}}),
            (std::vector<Texts>{{rows("0.5 0.25 0.125", 3), masks(9, 3)}, kSecond}));
}

TEST(ResultStream, TensorIfReportsWhatAFrameLacks) {
  const auto error = [](const std::string& properties) {
    const auto out = through(
        "tensor_if name=f operator=GE supplied-value=0 else=SKIP " + properties + " f.src_0 ! ",
        {{{0.5f}, 1}});
    return out.empty() ? std::string() : out.back()[0];
  };
  const std::string row = error("compared-value-option=4:1,0");
  EXPECT_SAYS(row, "WEIR-1004: compared-value-option names an element that does not exist");
  EXPECT_SAYS(row, "coordinate 1 in dimension 1");
  EXPECT_SAYS(row, "tensor 0 is float32 6:1");
  EXPECT_SAYS(error("compared-value-option=0,2"), "there are 2 tensors");
  EXPECT_SAYS(error("compared-value-option=0,0 then=TENSORPICK then-option=0,5"),
              "then-option names a tensor that does not exist");
}

TEST(ResultStream, PassesTensorRate) {
  EXPECT_EQ(through("tensor_rate framerate=10/1 ! ", kTwo), (std::vector<Texts>{kFirst, kSecond}));
  EXPECT_EQ(through("tensor_rate framerate=20/1 ! ", kTwo).front(), kFirst);
}

TEST(ResultStream, IsPickedByTensorDemux) {
  EXPECT_EQ(through("tensor_demux name=d tensorpick=1 d.src_0 ! ", kTwo),
            (std::vector<Texts>{{masks(7, 2)}, {masks(9, 1)}}));
  EXPECT_EQ(
      through("tensor_demux name=d tensorpick=1:0 d.src_0 ! ", kTwo),
      (std::vector<Texts>{{masks(7, 2), rows("0.5 0.25", 2)}, {masks(9, 1), rows("0.75", 1)}}));
}

TEST(ResultStream, IsJoinedByTensorMux) {
  Streams streams(
      std::string("appsrc name=in0 ! m. appsrc name=in1 ! m. tensor_mux name=m ! ") + kOut,
      {kBoxes, results_caps(std::string(kBoxColumns) + ";masks", "ssd;ssd")});
  streams.push(0, make_buffer({{0.5f}, 1}, 0));
  streams.push(1, make_buffer({{0.25f, 0.125f}, 2}, 0));
  EXPECT_EQ(streams.next(),
            (Texts{rows("0.5", 1), masks(1, 1), rows("0.25 0.125", 2, "ssd"), masks(2, 2, "ssd")}));
}

TEST(ResultStream, ComesFromTheActiveBranchOfJoin) {
  Streams streams(std::string("appsrc name=in0 ! j. appsrc name=in1 ! j. join name=j ! ") + kOut,
                  {kBoxes, kBoxes});
  streams.push(0, make_buffer({{0.5f}, 1}, 0));
  EXPECT_EQ(streams.next(), (Texts{rows("0.5", 1), masks(1, 1)}));
  streams.push(1, make_buffer({{0.25f}, 2}, 100 * GST_MSECOND));
  EXPECT_EQ(streams.next(), (Texts{rows("0.25", 1), masks(2, 1)}));
}

// A region of one row of the rows: x, y, width, height in numbers and rows of the tensor 1:6:N.
TEST(ResultStream, KeepsItsFieldsThroughTensorCrop) {
  Streams streams(std::string("appsrc name=in0 ! c.raw appsrc name=in1 ! c.info "
                              "tensor_crop name=c ! ") +
                      kOut,
                  {results_caps(kBoxColumns, "yolo"), kFlexible});
  const std::vector<float> numbers{1, 2, 3, 4, 0.5f, 1, 5, 6, 7, 8, 0.25f, 2};
  auto raw = Ref<GstBuffer>::adopt(gst_buffer_new());
  gst_buffer_append_memory(raw.get(), make_memory(with_header(ElementType::Float32, Shape{1, 6, 2},
                                                              numbers.data(), 48)));
  GST_BUFFER_PTS(raw.get()) = 0;
  const uint32_t second_row[]{0, 1, 6, 1};
  auto info = Ref<GstBuffer>::adopt(gst_buffer_new());
  gst_buffer_append_memory(
      info.get(), make_memory(with_header(ElementType::UInt32, Shape{4, 1}, second_row, 16)));
  GST_BUFFER_PTS(info.get()) = 0;
  streams.push(0, raw);
  streams.push(1, info);
  EXPECT_EQ(streams.next(), (Texts{std::string("float32 1:6:1:1 ") + kBoxColumns + "|yolo: 0.25"}));
}

// Each frame meets the rows of the frame before it, as a tracker needs them.
TEST(ResultStream, GoesRoundALoop) {
  for (const char* source : {"", ",weir-source=(string)\\\"yolo;yolo\\\""}) {
    const std::string caps =
        std::string(kFlexible) + ",weir-columns=(string)\\\"" + kBoxColumns + ";masks\\\"" + source;
    Streams streams("appsrc name=in0 ! m.sink_0 tensor_reposrc slot-index=3 caps=\"" + caps +
                        "\" ! m.sink_1 tensor_mux name=m sync-mode=nosync ! tee name=t "
                        "t. ! queue ! tensor_demux name=d tensorpick=0:1 d.src_0 ! "
                        "tensor_reposink slot-index=3 t. ! queue ! " +
                        kOut,
                    {kBoxes});
    streams.push(0, kTwo);
    streams.push(0, {{{1}, 3}});
    const std::string known = *source ? "yolo" : "";
    EXPECT_EQ(streams.next(), (Texts{kFirst[0], kFirst[1], rows("0", 1, known),
                                     "uint8 1:1:1 masks|" + known + ": 0"}))
        << "the first frame of a loop is one without results";
    EXPECT_EQ(streams.next(), (Texts{kSecond[0], kSecond[1], kFirst[0], kFirst[1]}));
    EXPECT_EQ(streams.next(), (Texts{rows("1", 1), masks(3, 1), kSecond[0], kSecond[1]}));
    streams.end(0);
    EXPECT_EQ(streams.next(), Texts{"end"});
  }
}

}  // namespace result_stream_test
}  // namespace weir::test
