// Tests of tensor_decoder's modes json, webvtt, coco and mot through the C ABI.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <nlohmann/json.hpp>

#include "core/decoders/decoder_test_support.hpp"
#include "weir/source_map.hpp"

namespace weir::decoders {
namespace record_decoders_test {

constexpr char kColumns[] = "x1,y1,x2,y2,score,class";
const std::vector<float> kRow{1, 2, 3, 4, 0.5f, 1};

// Checks that the text contains each of these.
void expect_says(const std::string& text, std::initializer_list<const char*> all) {
  for (const char* words : all) EXPECT_SAYS(text, words);
}

// Runs a mode on frames as the element does.
class RecordRun {
 public:
  explicit RecordRun(const std::string& mode, const DecoderOptions& options = {}) {
    infer::ModuleLibrary library;
    library.add_builtin(&builtin_decoders());
    const auto type = library.decoder(mode);
    if (!type) {
      error = type.error().message();
      return;
    }
    auto opened = infer::Decoder::open(**type, options);
    if (opened)
      decoder = *std::move(opened);
    else
      error = opened.error().message();
  }
  bool configure(const std::string& columns, const std::vector<TestTensor>& tensors = {},
                 const std::string& sources = "") {
    DecoderOptions fields;
    if (!columns.empty()) fields.emplace_back("weir-columns", columns);
    if (!sources.empty()) fields.emplace_back("weir-source", sources);
    decoder->set_caps(fields);
    std::vector<weir_tensor_info> infos;
    for (const auto& tensor : tensors) infos.push_back(tensor.info());
    Sink sink(this);
    const auto status = decoder->configure(infos, &sink);
    error = status ? "" : status.error().message();
    return bool(status);
  }
  // The text of a frame; "(dropped)" if there is none.
  std::string decode(const std::vector<TestTensor>& tensors, int64_t running_time = -1,
                     const SourceMap* map = nullptr, int64_t duration = -1) {
    std::vector<weir_tensor> memory;
    for (const auto& tensor : tensors) memory.push_back(tensor.tensor());
    weir_frame frame{};
    frame.struct_size = sizeof frame;
    frame.n_tensors = static_cast<uint32_t>(memory.size());
    frame.tensors = memory.data();
    frame.duration = duration;
    const weir_source_map maps = map ? abi_map(*map) : weir_source_map{};
    if (map) frame.n_maps = 1, frame.maps = &maps;
    Sink sink(this);
    output.clear();
    decoder->set_times(running_time, -1);
    const auto kept = decoder->decode(frame, &sink);
    error = kept ? "" : kept.error().message();
    return kept && !*kept ? "(dropped)" : output;
  }

  std::unique_ptr<infer::Decoder> decoder;
  std::string caps, error, output;

 private:
  struct Sink final : weir_sink {
    explicit Sink(RecordRun* to) : to_(to) {}
    Status set_caps(const std::string& text) override {
      to_->caps = text;
      return ok();
    }
    void* reserve(uint64_t bytes) override {
      to_->output.assign(bytes, '?');
      return to_->output.data();
    }
    Status share_input(uint32_t) override { return ok(); }
    RecordRun* to_;
  };
};

TEST(RecordDecoders, JsonHasTimeAndSizeOfTheFrame) {
  RecordRun run("json", {{"labels", file_with("records", "cat\ndog\n")}});
  ASSERT_TRUE(run.configure(kColumns, {}, "yolo")) << run.error;
  EXPECT_EQ(run.caps, "application/x-json");
  const SourceMap map = picture_as_it_is(640, 480, false);
  EXPECT_EQ(run.decode({{"6:1", kRow}}, 1500000000, &map),
            R"({"version":1,"time":1.5,"source":"yolo","size":[640,480],"detections":[)"
            R"({"box":[1,2,3,4],"score":0.5,"index":1,"label":"dog"}]})"
            "\n");
  // The times are those of one frame.
  run.decoder->set_times(-1, -1);
  EXPECT_EQ(run.decode({{"6:1", kRow}}),
            R"({"version":1,"source":"yolo","detections":[)"
            R"({"box":[1,2,3,4],"score":0.5,"index":1,"label":"dog"}]})"
            "\n");
}

TEST(RecordDecoders, EachSourceHasItsLabels) {
  const std::string one = file_with("one", "cat\n"), two = file_with("two", "red\nblue\n");
  RecordRun run("json", {{"labels", one + ";" + two}});
  ASSERT_TRUE(run.configure("score,class;score,class", {}, "a;b")) << run.error;
  const auto out = nlohmann::json::parse(run.decode({{"2:1", {1, 0}}, {"2:1", {1, 1}}}));
  EXPECT_EQ(out["labels"][0]["label"], "cat");
  EXPECT_EQ(out["labels"][1]["label"], "blue");
  EXPECT_EQ(out["labels"][1]["source"], "b");
}

TEST(RecordDecoders, LabelsOfTheModelCountWhereThereIsNoFile) {
  RecordRun run("json");
  weir_stream_model model{};
  model.struct_size = sizeof model;
  model.metadata_json = R"({"tflite.labels":"cat\ndog"})";
  run.decoder->set_model(&model);
  ASSERT_TRUE(run.configure(kColumns)) << run.error;
  EXPECT_EQ(nlohmann::json::parse(run.decode({{"6:1", kRow}}))["detections"][0]["label"], "dog");
}

TEST(RecordDecoders, RowsNeedNoColumns) {
  RecordRun run("mot");
  ASSERT_TRUE(run.configure("", {{"6:1", kRow}})) << run.error;
  EXPECT_EQ(run.caps, "text/csv");
  EXPECT_EQ(run.decode({{"6:1", kRow}}), "1,-1,2,3,2,2,0.5,2,1\n");
  EXPECT_EQ(run.decode({}), "(dropped)");
}

TEST(RecordDecoders, CuesLastAsLongAsTheFrameOrTheRateSays) {
  RecordRun run("webvtt");
  run.decoder->set_stream({10, 1}, Format::Flexible);
  ASSERT_TRUE(run.configure("score,class"));
  EXPECT_EQ(run.caps, "application/x-subtitle-vtt");
  EXPECT_EQ(run.decode({{"2:1", {1, 4}}}, 0),
            "WEBVTT\n\n00:00:00.000 --> 00:00:00.100\n4 100 %\n\n");
  EXPECT_EQ(run.decode({{"2:1", {1, 4}}}, 0, nullptr, 20000000),
            "00:00:00.000 --> 00:00:00.020\n4 100 %\n\n");
  run.decoder->reset();  // a flush
  EXPECT_EQ(run.decode({{"2:1", {1, 4}}}, 0).substr(0, 6), "WEBVTT");
}

TEST(RecordDecoders, RefuseOptionsThatCannotBeUsed) {
  expect_says(RecordRun("json", {{"threshold", "1.5"}}).error,
              {"WEIR-1004", "the value of threshold cannot be used", "offered: threshold=1.5",
               "a number from 0 to 1"});
  expect_says(RecordRun("json", {{"threshold", "nan"}}).error, {"threshold=nan"});
  expect_says(RecordRun("json", {{"masks", "png"}}).error,
              {"masks=png", "none or rle", "fix: custom=masks:rle"});
  expect_says(RecordRun("coco", {{"categories", "voc"}}).error, {"categories=voc"});
  expect_says(RecordRun("json", {{"labels", "/nonexistent/labels.txt"}}).error,
              {"WEIR-4001", "labels=/nonexistent/labels.txt"});
}

TEST(RecordDecoders, RefuseStreamsThatAreNotResults) {
  RecordRun run("json");
  EXPECT_FALSE(run.configure("x1,y1"));
  expect_says(run.error, {"WEIR-1001", "weir-columns=\"x1,y1\""});
  EXPECT_FALSE(run.configure(kColumns, {{"5:1", {1, 2, 3, 4, 5}}}));
  expect_says(run.error, {"WEIR-2001", "float32 5:1", "float32 6:N"});
  EXPECT_FALSE(run.configure("", {{ElementType::UInt8, "3:4:4", Bytes(48)}}));
  expect_says(run.error, {"WEIR-2001"});
}

TEST(RecordDecoders, RefuseFramesThatDoNotFitTheColumns) {
  RecordRun run("json");
  ASSERT_TRUE(run.configure(kColumns));
  run.decode({{"5:1", {1, 2, 3, 4, 5}}});
  expect_says(run.error, {"WEIR-2001", "a tensor of results does not match weir-columns"});
  TestTensor cut{"6:2", kRow};
  run.decode({cut});
  expect_says(run.error, {"WEIR-2004", "offered: 24 bytes", "needed: 48 bytes"});
  EXPECT_NE(run.decode({{"6:1", kRow}}), "");
  EXPECT_EQ(run.error, "");
}

}  // namespace record_decoders_test
}  // namespace weir::decoders
