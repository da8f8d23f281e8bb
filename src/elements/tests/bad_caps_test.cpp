// Caps changes during a stream, to valid and invalid caps.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tests/bad_input_bench_test_support.hpp"

namespace bad_caps_test {

using namespace weir::testing_bad_input;

struct Change {
  std::string element;
  const char* name;
  std::string caps;
  size_t bytes;         // of a frame
  const char* refused;  // the error text; "" = accepted
};
void PrintTo(const Change& change, std::ostream* out) {
  *out << change.element << " " << change.name;
}

const Subject& find_subject(const Change& change) {
  for (const auto& subject : subjects())
    if (subject.name == change.element) return subject;
  ADD_FAILURE() << change.element;
  return subjects()[0];
}

class ChangedCaps : public testing::TestWithParam<Change> {};

TEST_P(ChangedCaps, AreAcceptedOrReported) {
  const Change& change = GetParam();
  const Subject& subject = find_subject(change);
  Bench bench(subject);
  ASSERT_EQ(bench.start(subject.caps), "");
  EXPECT_EQ(bench.push(subject.good_frame()), "");
  const std::string error = bench.set_caps(change.caps);
  const std::string message = change.refused;
  EXPECT_EQ(error.empty(), message.empty()) << error;
  EXPECT_SAYS(error, message);
  if (error.empty()) {
    for (int i = 0; i < 2; ++i) EXPECT_EQ(bench.push(zeros(change.bytes)), "");
    EXPECT_EQ(bench.set_caps(subject.caps), "") << "back to the first caps";
    EXPECT_EQ(bench.push(subject.good_frame()), "");
  }
  expect_sound_again(bench, subject, bench.received());
}

std::vector<Change> changes() {
  std::vector<Change> all;
  for (const char* element : {"converter", "converter_chunks", "preprocess"}) {
    all.push_back({element, "size", video("RGB", 3, 5), 60, ""});
    all.push_back({element, "format", video("GRAY8", 8, 4), 32, ""});
    all.push_back({element, "rate", video("RGB", 8, 4, "25/1"), 96, ""});
    all.push_back({element, "no_rate", video("RGB", 8, 4, "0/1"), 96, ""});
  }
  all.push_back(
      {"converter", "not_a_tensor", video("NV12", 8, 4), 0, "WEIR-2002: this video format"});
  all.push_back({"converter", "no_size", "video/x-raw,format=RGB", 0, "WEIR-2002: "});
  all.push_back({"converter", "empty", video("RGB", 0, 0), 0, "WEIR-2006: "});
  all.push_back(
      {"converter", "audio", "audio/x-raw,format=U8,layout=interleaved,rate=8,channels=3", 9, ""});
  all.push_back({"converter_audio", "channels",
                 "audio/x-raw,format=S16LE,layout=interleaved,rate=8000,channels=7", 28, ""});
  all.push_back({"converter_audio", "format",
                 "audio/x-raw,format=F64LE,layout=interleaved,rate=44100,channels=2", 32, ""});
  all.push_back({"converter_audio", "not_a_tensor",
                 "audio/x-raw,format=S24LE,layout=interleaved,rate=8000,channels=2", 0,
                 "WEIR-2002: this audio format"});
  all.push_back(
      {"preprocess", "not_prepared", video("Y444", 8, 4), 0, "WEIR-2002: pictures of this"});
  all.push_back({"preprocess", "planes", video("I420", 6, 6), 72, ""});
  all.push_back({"overlay", "size", video("NV12", 3, 5), 96, ""});
  all.push_back({"overlay", "format", video("BGRx", 8, 4), 128, ""});
  all.push_back({"overlay", "not_drawable", video("Y42B", 8, 4), 0,
                 "WEIR-2002: tensor_overlay cannot draw into pictures of this format"});
  for (const char* element :
       {"transform_type", "transform_in_place", "transform_order", "decoder"}) {
    all.push_back({element, "size", tensors("2:3:5", "uint8"), 30, ""});
    all.push_back({element, "type", tensors("4:4", "int16"), 32, ""});
    all.push_back({element, "rate", tensors("4:4", "uint8", "25/1"), 16, ""});
  }
  for (const char* element : {"mux", "mux_second", "aggregator", "rate", "debug", "sparse_enc",
                              "demux", "if", "reposink"})
    all.push_back({element, "size", tensors("2:3:5", "uint8"), 30, ""});
  all.push_back({"join", "size", tensors("2:3:5", "uint8"), 0,
                 "WEIR-2001: the branches of join have different caps"});
  for (const std::string element : {"transform_type", "decoder", "filter", "sink", "mux",
                                    "aggregator", "demux", "sparse_enc", "reposink"}) {
    const bool sink = element == "sink";  // passes on what it can read
    const auto add = [&](const char* name, const std::string& caps, const char* refused) {
      all.push_back({element, name, caps, 16, refused});
    };
    add("no_extent", tensors("4:0:4", "uint8"), "WEIR-1002: a dimension cannot be read");
    add("words", tensors("a:b", "uint8"), "WEIR-1002: a dimension cannot be read");
    add("no_type", tensors("4:4", "uint9"), "WEIR-1003: an element type is unknown");
    add("too_few",
        "other/tensors,format=(string)static,num_tensors=(int)2,dimensions=(string)4:4,"
        "types=(string)uint8,framerate=30/1",
        sink ? "" : "WEIR-2002: the caps do not describe the tensors completely");
    add("too_big", tensors("4294967295:4294967295:4294967295", "uint8"), sink ? "" : "WEIR-2006: ");
  }
  all.push_back({"filter", "size", tensors("4:5", "float32"), 80, ""});
  all.push_back({"filter", "type", tensors("4:4", "uint8"), 0, "WEIR-2001: "});
  all.push_back({"filter", "rate", tensors("4:4", "float32", "25/1"), 64, ""});
  all.push_back({"decoder_video", "size", tensors("3:5:2", "uint8"), 30, ""});
  all.push_back({"decoder_video", "gray", tensors("1:4:4", "uint8"), 16, ""});
  all.push_back({"decoder_video", "no_picture", tensors("2:4:4", "uint8"), 0, "WEIR-2"});
  return all;
}
std::string make_test_name(const testing::TestParamInfo<Change>& info) {
  return info.param.element + "_" + info.param.name;
}
INSTANTIATE_TEST_SUITE_P(All, ChangedCaps, testing::ValuesIn(changes()), make_test_name);

// Sources retry rejected caps several times.
class RejectedCaps : public testing::TestWithParam<Change> {};

TEST_P(RejectedCaps, AreReportedOnceUntilSomethingChanges) {
  const Change& change = GetParam();
  const Subject& subject = find_subject(change);
  constexpr const char* kNoError = "rejected the caps";
  Bench bench(subject);
  ASSERT_EQ(bench.start(subject.caps), "");
  const std::string error = bench.set_caps(change.caps);
  EXPECT_SAYS(error, change.refused);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(bench.set_caps(change.caps), kNoError);
  EXPECT_EQ(bench.set_caps(subject.caps), "");
  EXPECT_EQ(bench.push(subject.good_frame()), "");
  EXPECT_EQ(bench.set_caps(change.caps), error) << "after accepted caps";
  EXPECT_EQ(bench.set_caps(change.caps), kNoError);
  bench.stop();
  EXPECT_EQ(bench.start(change.caps), error) << "after READY";
}

std::vector<Change> refusals() {
  auto all = changes();
  std::erase_if(all, [](const Change& change) { return change.refused[0] == 0; });
  return all;
}
INSTANTIATE_TEST_SUITE_P(All, RejectedCaps, testing::ValuesIn(refusals()), make_test_name);

}  // namespace bad_caps_test
