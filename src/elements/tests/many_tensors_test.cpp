// 1 to 20 tensors of ranks 1 to 16, static and flexible, through each element.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tests/many_tensors_test_support.hpp"

#include "elements/tensor_mux/many_inputs_test_support.hpp"
#include "elements/tests/branches_test_support.hpp"
#include "elements/tests/element_test_support.hpp"

namespace weir::test {
namespace many_tensors_test {

using Memories = std::vector<Bytes>;

class ManyTensors : public ::testing::TestWithParam<Sweep> {
 protected:
  std::vector<size_t> all() const { return make_range(0, GetParam().count); }
  Memories memories() const { return make_memories(GetParam(), all()); }
  std::string caps() const { return make_caps(GetParam(), all()); }
  // Of tensors copied into a packed memory.
  uint64_t packed_bytes(const std::vector<size_t>& tensors) const {
    uint64_t out = 0;
    for (size_t i = 15; tensors.size() > 16 && i < tensors.size(); ++i)
      out += make_tensor(GetParam(), tensors[i]).size();
    return out;
  }
};
class ManyStaticTensors : public ManyTensors {};

// The first tensor arrives on one pad and the others on the next, or the last one alone.
TEST_P(ManyTensors, TensorMuxCombinesThem) {
  const size_t count = GetParam().count;
  for (const size_t cut : {size_t{1}, count - 1}) {
    if (count == 1 && cut == 0) continue;
    ManyInputs mux("tensor_mux");
    Memories first = make_memories(GetParam(), make_range(0, cut)), second;
    mux.add(make_caps(GetParam(), make_range(0, cut)).c_str());
    if (count > cut) {
      second = make_memories(GetParam(), make_range(cut, count));
      mux.add(make_caps(GetParam(), make_range(cut, count)).c_str());
    }
    mux.play();
    auto push = mux.push_later(0, make_buffer(first, 40));
    if (count > cut) {
      EXPECT_EQ(mux.push(1, make_buffer(second, 40)), GST_FLOW_OK);
    }
    EXPECT_EQ(push.get(), GST_FLOW_OK) << mux.error();
    ASSERT_EQ(mux.buffers().size(), 1u);
    EXPECT_EQ(read_memories(mux.buffers()[0].get()), memories()) << "cut at " << cut;
    const auto expected = Ref<GstCaps>::adopt(gst_caps_from_string(caps().c_str()));
    const auto got = Ref<GstCaps>::adopt(gst_caps_from_string(mux.caps().c_str()));
    EXPECT_TRUE(gst_caps_is_equal(got.get(), expected.get())) << mux.caps();
    EXPECT_EQ(mux.stat("bytes-copied"), packed_bytes(all()));
  }
}

TEST_P(ManyTensors, TensorDemuxSeparatesThem) {
  Branches demux("tensor_demux");
  demux.caps(caps());
  ASSERT_EQ(demux.push(make_frame(memories())), GST_FLOW_OK) << demux.error();
  for (const size_t i : all()) {
    const auto out = demux.take("src_" + std::to_string(i));
    ASSERT_TRUE(out);
    EXPECT_EQ(read_memories(out.get()), Memories{make_tensor(GetParam(), i)});
  }
  EXPECT_EQ(demux.added().size(), GetParam().count);
  EXPECT_EQ(demux.stat("bytes-copied"), 0u);
}

// Compares the last value of the last tensor, and picks all tensors in reverse order.
TEST_P(ManyStaticTensors, TensorIfComparesAndPicks) {
  const size_t last = GetParam().count - 1;
  const auto dimensions = make_dimensions(GetParam(), last);
  const std::string at = join(dimensions, ":", [](uint32_t d) { return std::to_string(d - 1); });
  std::vector<size_t> turned;
  for (size_t i = last + 1; i-- > 0;) turned.push_back(i);
  const std::string picked = join(turned, ",", [](size_t i) { return std::to_string(i); });
  const unsigned number = number_at(last, count_elements(dimensions) - 1);
  for (const unsigned supplied : {number, number + 1}) {
    Branches element("tensor_if compared-value-option=" + at + "," + std::to_string(last) +
                     " operator=EQ supplied-value=" + std::to_string(supplied) +
                     " then=TENSORPICK then-option=" + picked);
    element.caps(caps());
    GstBuffer* const in = make_frame(memories());
    ASSERT_EQ(element.push(in), GST_FLOW_OK) << element.error();
    const bool holds = supplied == number;
    ASSERT_TRUE(element.has(holds ? "src_0" : "src_1"));
    EXPECT_FALSE(element.has(holds ? "src_1" : "src_0"));
    const auto out = element.take(holds ? "src_0" : "src_1");
    if (!holds) {
      EXPECT_EQ(out.get(), in);
      EXPECT_EQ(element.stat("bytes-copied"), 0u);
      continue;
    }
    EXPECT_EQ(read_memories(out.get()), make_memories(GetParam(), turned));
    EXPECT_SAYS(element.branch("src_0").caps(), "num_tensors=(int)" + std::to_string(last + 1));
    EXPECT_EQ(element.stat("bytes-copied"), packed_bytes(turned));
  }
}

TEST_P(ManyStaticTensors, TensorIfComputesTheAverageOfTheLast) {
  const size_t last = GetParam().count - 1,
               elements = count_elements(make_dimensions(GetParam(), last));
  unsigned sum = 0;
  for (size_t i = 0; i < elements; ++i) sum += number_at(last, i);
  // Integers below and above the mean: truncated to an integer, it is the lower one.
  const auto below = std::to_string(sum / elements), above = std::to_string(sum / elements + 1);
  for (const auto& [range, way] :
       {std::pair(below + "," + above, "src_0"), std::pair(above + "," + above + "00", "src_1")}) {
    Branches element("tensor_if compared-value=TENSOR_AVERAGE_VALUE compared-value-option=" +
                     std::to_string(last) + " operator=RANGE_INCLUSIVE supplied-value=" + range);
    element.caps(caps());
    ASSERT_EQ(element.push(make_frame(memories())), GST_FLOW_OK) << element.error();
    EXPECT_TRUE(element.has(way)) << range;
    EXPECT_EQ(element.added().size(), 1u);
    EXPECT_EQ(element.stat("bytes-copied"), 0u);
  }
}

// Regions are cut out of the first tensor; its dimensions above the second are ignored.
TEST_P(ManyTensors, TensorCropCropsTheFirst) {
  auto dimensions = make_dimensions(GetParam(), 0);
  dimensions.resize(std::max<size_t>(dimensions.size(), 3), 1);
  const size_t channels = dimensions[0], width = dimensions[1], height = dimensions[2];
  const std::vector<uint32_t> regions{0, 0, 2, 2, 1, 0, 1, 2, 0, 1, 2, 1};
  Memories expected;
  for (size_t r = 0; r < regions.size(); r += 4) {
    const size_t right = std::min<size_t>(regions[r] + regions[r + 2], width);
    const size_t bottom = std::min<size_t>(regions[r + 1] + regions[r + 3], height);
    if (regions[r] >= right || regions[r + 1] >= bottom) continue;
    Bytes out;
    append_word(&out, 0xfeedcced, 4);
    append_word(&out, 0xDE001000, 4);
    append_word(&out, get_numbers(0).code, 4);
    append_dimensions(&out,
                      {static_cast<uint32_t>(channels), static_cast<uint32_t>(right - regions[r]),
                       static_cast<uint32_t>(bottom - regions[r + 1]), 1});
    append_word(&out, 1, 4);  // flexible
    append_word(&out, 4, 4);
    out.resize(128);
    for (size_t y = regions[r + 1]; y < bottom; ++y)
      for (size_t x = regions[r]; x < right; ++x)
        for (size_t c = 0; c < channels; ++c)
          out.push_back(
              static_cast<uint8_t>(number_at(0, c + channels * (x + width * y))));  // uint8
    expected.push_back(std::move(out));
  }
  Bytes info;
  append_word(&info, 0xfeedcced, 4);
  append_word(&info, 0xDE001000, 4);
  append_word(&info, 1, 4);
  append_dimensions(&info, {4, 3});
  append_word(&info, 1, 4);
  append_word(&info, 4, 4);
  info.resize(128);
  for (const uint32_t number : regions) append_word(&info, number, 4);

  ManyInputs crop("tensor_crop");
  crop.add(caps().c_str(), "raw");
  crop.add("other/tensors,format=flexible,framerate=30/1", "info");
  crop.play();
  auto raw = crop.push_later(0, make_buffer(memories(), 0));
  EXPECT_EQ(crop.push(1, info, 0), GST_FLOW_OK);
  EXPECT_EQ(raw.get(), GST_FLOW_OK) << crop.error();
  ASSERT_EQ(crop.buffers().size(), 1u);
  EXPECT_EQ(read_memories(crop.buffers()[0].get()), expected);
}

// A buffer has 16 memories at most.
TEST_P(ManyTensors, OctetStreamContainsTheirBytes) {
  ManyInputs decoder("tensor_decoder mode=octet_stream");
  decoder.add(caps().c_str(), "sink");
  decoder.play();
  Memories expected(std::min<size_t>(GetParam().count, 16));
  for (const size_t i : all()) {
    const Bytes payload = make_payload(GetParam(), i);
    Bytes& memory = expected[std::min<size_t>(i, 15)];
    memory.insert(memory.end(), payload.begin(), payload.end());
  }
  for (int frame = 0; frame < 2; ++frame)
    ASSERT_EQ(decoder.push(0, make_buffer(memories(), 0)), GST_FLOW_OK) << decoder.error();
  ASSERT_EQ(decoder.buffers().size(), 2u);
  for (const auto& buffer : decoder.buffers()) EXPECT_EQ(read_memories(buffer.get()), expected);
  const size_t copied = GetParam().count > 16 ? expected[15].size() : 0;
  EXPECT_EQ(decoder.stat("bytes-copied"), 2 * copied);
}

// Elements that forward frames unchanged must keep every memory.
TEST_P(ManyTensors, PassThroughElementsDoNotChangeThem) {
  std::vector<std::pair<const char*, const char*>> lines{{"join", "sink_%u"},
                                                         {"tensor_debug", "sink"}};
  if (!GetParam().flexible) lines.emplace_back("tensor_rate framerate=60/1", "sink");
  for (const auto& [line, pad] : lines) {
    ManyInputs element(line);
    element.add(caps().c_str(), pad);
    element.play();
    for (const GstClockTime time : {0, 100})
      ASSERT_EQ(element.push(0, make_buffer(memories(), time * GST_MSECOND)), GST_FLOW_OK)
          << line << element.error();
    const auto out = element.buffers();
    ASSERT_GE(out.size(), 2u) << line;
    for (const auto& buffer : out) EXPECT_EQ(read_memories(buffer.get()), memories()) << line;
    EXPECT_EQ(element.stat("bytes-copied"), 0u) << line;
  }
}

// All tensors, and only the first and the last.
TEST_P(ManyTensors, TensorTransformTransformsAllOrSome) {
  const size_t last = GetParam().count - 1;
  for (const bool some : {false, true}) {
    std::string line = "tensor_transform mode=arithmetic option=add:1";
    if (some) line += " apply=0," + std::to_string(last);
    ManyInputs transform(line);
    transform.add(caps().c_str(), "sink");
    transform.play();
    for (int frame = 0; frame < 2; ++frame)
      ASSERT_EQ(transform.push(0, make_buffer(memories(), 0)), GST_FLOW_OK) << transform.error();
    Memories expected = memories();
    for (size_t i = 0, at = 19224; i <= last; ++i) {
      const bool packed = last >= 16 && i >= 15;
      const size_t begin = (packed ? at : 0) + (GetParam().flexible ? 128 : 0);
      const Numbers& numbers = get_numbers(i);
      const size_t elements = count_elements(make_dimensions(GetParam(), i));
      for (size_t e = 0; e < elements && (!some || i == 0 || i == last); ++e)
        numbers.write(number_at(i, e) + 1,
                      expected[packed ? 15 : i].data() + begin + e * numbers.bytes);
      if (packed) at += make_tensor(GetParam(), i).size();
    }
    ASSERT_EQ(transform.buffers().size(), 2u);
    for (const auto& buffer : transform.buffers())
      EXPECT_EQ(read_memories(buffer.get()), expected) << line;
  }
}

// First zeros of the number and size that the caps give, then what the sink received.
TEST_P(ManyStaticTensors, ALoopCarriesThem) {
  const auto sink = test::make_harness("tensor_reposink", caps());
  auto source = test::make_harness("tensor_reposrc slot-index=0");
  const auto wanted = Ref<GstCaps>::adopt(gst_caps_from_string(caps().c_str()));
  g_object_set(test::find_element(source, "tensor_reposrc").get(), "caps", wanted.get(), nullptr);
  gst_harness_play(source.get());
  ASSERT_EQ(gst_harness_push(sink.get(), make_frame(memories())), GST_FLOW_OK);
  const auto zeros = Ref<GstBuffer>::adopt(gst_harness_pull(source.get()));
  const auto frame = Ref<GstBuffer>::adopt(gst_harness_pull(source.get()));
  ASSERT_TRUE(zeros && frame);
  Memories expected = memories();
  for (size_t i = 0; i < expected.size(); ++i) {
    const bool packed = GetParam().count > 16 && i == 15;
    std::fill(expected[i].begin() + (packed ? 19224 : 0), expected[i].end(), uint8_t{0});
  }
  EXPECT_EQ(read_memories(zeros.get()), expected);
  EXPECT_EQ(read_memories(frame.get()), memories());
}

std::string make_test_name(const ::testing::TestParamInfo<Sweep>& info) {
  return std::to_string(info.param.count) + "FromRank" + std::to_string(info.param.first_rank) +
         (info.param.flexible ? "Flexible" : "");
}
INSTANTIATE_TEST_SUITE_P(Sweep, ManyTensors, ::testing::ValuesIn(sweep()), make_test_name);
INSTANTIATE_TEST_SUITE_P(Sweep, ManyStaticTensors, ::testing::ValuesIn(sweep(false)),
                         make_test_name);

}  // namespace many_tensors_test
}  // namespace weir::test
