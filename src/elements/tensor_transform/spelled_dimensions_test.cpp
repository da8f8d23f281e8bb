// tensor_transform between caps that spell equal dimensions with more or fewer trailing 1s
// (docs/compatibility/types-and-caps.md 1.4 and 1.5).
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tests/element_test_support.hpp"

namespace spelled_dimensions_test {

using namespace weir::test;

struct Case {
  const char* mode;
  const char* out;                     // of 3:4:4:1
  std::vector<const char*> spellings;  // equal to `out`
};
const std::vector<Case> kCases{
    {"typecast option=float32", "3:4:4:1", {"3:4:4", "3:4:4:1", "3:4:4:1:1"}},
    {"arithmetic option=add:1", "3:4:4:1", {"3:4:4", "3:4:4:1:1:1"}},
    {"clamp option=0:9", "3:4:4:1", {"3:4:4", "3:4:4:1:1"}},
    {"stand option=default", "3:4:4:1", {"3:4:4", "3:4:4:1:1"}},
    {"transpose option=1:2:0:3", "4:4:3:1", {"4:4:3", "4:4:3:1:1"}},
    {"dimchg option=0:2", "4:4:3:1", {"4:4:3", "4:4:3:1:1"}},
    {"padding option=left:1,bottom:1", "4:5:4:1", {"4:5:4", "4:5:4:1:1"}},
};

std::string tensor(const std::string& dimension) {
  return "other/tensor,dimension=(string)" + dimension;
}
std::string with_capsfilter(const Case& c, const std::string& caps) {
  return std::string("tensor_transform mode=") + c.mode + " ! capsfilter caps=\"" + caps + "\"";
}
const std::string kInput = tensor("3:4:4:1") + ",type=uint8,framerate=30/1";

TEST(SpelledDimensions, EachModeAcceptsTheSpellingOfACapsfilter) {
  for (const Case& c : kCases)
    for (const char* spelling : c.spellings) {
      auto h = make_harness(with_capsfilter(c, tensor(spelling)), kInput);
      Errors errors(h);
      EXPECT_EQ(gst_harness_push(h.get(), frame(Bytes(48))), GST_FLOW_OK)
          << c.mode << errors.next();
      EXPECT_SAYS(caps_text(h), std::string("dimension=(string)") + spelling + ",") << c.mode;
    }
}

TEST(SpelledDimensions, ListsKeepTheSpellingOfACapsfilter) {
  auto h = make_harness(
      "tensor_transform mode=typecast option=int16 ! capsfilter "
      "caps=\"other/tensors,format=static,dimensions=(string)\\\"3:4:1:1,5\\\"\"",
      tensors("uint8,uint8", "3:4,5:1"));
  GstBuffer* in = gst_buffer_append(frame(Bytes(12)), frame(Bytes(5)));
  EXPECT_EQ(gst_harness_push(h.get(), in), GST_FLOW_OK);
  EXPECT_SAYS(caps_text(h), "dimensions=(string)\"3:4:1:1\\,5\"");
}

// An upstream capsfilter queries with its own spelling as the filter.
TEST(SpelledDimensions, ACapsQueryUsesTheSpellingOfItsFilter) {
  for (const Case& c : kCases)
    for (const char* in : {"3:4:4", "3:4:4:1", "3:4:4:1:1"}) {
      const auto h = make_harness(with_capsfilter(c, tensor(c.spellings.front())));
      const auto filter = Ref<GstCaps>::adopt(gst_caps_from_string(tensor(in).c_str()));
      const auto caps = Ref<GstCaps>::adopt(gst_pad_peer_query_caps(h->srcpad, filter.get()));
      EXPECT_FALSE(gst_caps_is_empty(caps.get())) << c.mode << " after " << in;
    }
}

TEST(SpelledDimensions, TwoTransformsKeepTheSpellingOfTwoCapsfilters) {
  auto h = make_harness("capsfilter caps=\"" + tensor("3:4:4") + "\" ! " +
                            with_capsfilter(kCases[0], tensor("3:4:4:1")) + " ! " +
                            with_capsfilter(kCases[4], tensor("4:4:3")),
                        tensor("3:4:4") + ",type=uint8,framerate=30/1");
  EXPECT_EQ(gst_harness_push(h.get(), frame(Bytes(48))), GST_FLOW_OK);
  EXPECT_SAYS(caps_text(h), "dimension=(string)4:4:3,");
}

TEST(SpelledDimensions, AnotherDimensionIsRejected) {
  for (const Case& c : kCases)
    for (const std::string more : {":2", ":1:2"}) {
      auto h = make_harness(with_capsfilter(c, tensor(c.spellings.front() + more)));
      Errors errors(h);
      gst_harness_set_src_caps_str(h.get(), kInput.c_str());
      EXPECT_EQ(gst_harness_push(h.get(), frame(Bytes(48))), GST_FLOW_NOT_NEGOTIATED) << c.mode;
      EXPECT_SAYS(errors.next(),
                  "the element downstream of tensor_transform does not accept its output");
    }
}

TEST(SpelledDimensions, AQueryForAnotherDimensionReturnsEmptyCaps) {
  for (const Case& c : kCases) {
    if (std::string(c.mode).starts_with("padding")) continue;  // accepts any dimensions
    const auto h = make_harness(with_capsfilter(c, tensor(c.spellings.front())));
    const auto filter = Ref<GstCaps>::adopt(gst_caps_from_string(tensor("3:4:4:2").c_str()));
    const auto caps = Ref<GstCaps>::adopt(gst_pad_peer_query_caps(h->srcpad, filter.get()));
    EXPECT_TRUE(gst_caps_is_empty(caps.get())) << c.mode;
  }
}

}  // namespace spelled_dimensions_test
