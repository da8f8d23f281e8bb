// Tests that caps become a FrameSpec and back, and which of several caps a source pad chooses.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/buffer/tensor_caps.hpp"

#include <gtest/gtest.h>

#include <string>

#include "says.hpp"

namespace weir::gst {
namespace tensor_caps_test {

using Caps = Ref<GstCaps>;

Caps caps_of(const std::string& text) {
  return Caps::adopt(gst_caps_from_string(text.c_str()));
}
Result<FrameSpec> spec_of(const std::string& text) {
  return spec_from_caps(caps_of(text).get());
}
std::string fixed_error(const std::string& text) {
  const auto spec = fixed_spec_from_caps(caps_of(text).get());
  return spec ? "" : spec.error().message();
}
FrameSpec static_spec(const std::string& dimensions, const std::string& types) {
  return *spec_of("other/tensors,format=static,dimensions=(string)" + dimensions +
                  ",types=(string)" + types + ",framerate=30/1");
}

constexpr const char* kTwo =
    "other/tensors,format=static,num_tensors=2,dimensions=(string)\"3:4:2,5\","
    "types=(string)\"uint8,float32\",framerate=30/1";

TEST(TensorCaps, OfStaticTensorsAreReadCompletely) {
  const auto spec = fixed_spec_from_caps(caps_of(kTwo).get());
  ASSERT_TRUE(spec) << spec.error().message();
  EXPECT_EQ(spec->to_string(), "2 tensors: uint8 3:4:2, float32 5");
  EXPECT_EQ(spec->bytes(), 3u * 4 * 2 + 5 * 4);
  EXPECT_EQ(spec->rate, (Fraction{30, 1}));
}

TEST(TensorCaps, OfOneTensorHaveTheirOwnNames) {
  const auto spec = fixed_spec_from_caps(
      caps_of("other/tensor,dimension=(string)7:2,type=int16,framerate=0/1").get());
  ASSERT_TRUE(spec) << spec.error().message();
  EXPECT_EQ(spec->to_string(), "1 tensor: int16 7:2");
}

TEST(TensorCaps, LeaveMissingPartsUnknown) {
  const auto open = spec_of("other/tensors,format=static,num_tensors=2");
  ASSERT_TRUE(open);
  EXPECT_EQ(open->tensors.size(), 2u);
  EXPECT_FALSE(open->tensors[0].valid() || open->rate.valid());
  EXPECT_EQ(spec_of("other/tensors,format=flexible")->format, Format::Flexible);
  EXPECT_EQ(spec_of("other/tensors")->format, Format::End);
}

TEST(TensorCaps, ThatDescribeNoTensorsAreErrors) {
  EXPECT_EQ(spec_from_caps(nullptr).error().code, Code::NOT_NEGOTIATED);
  EXPECT_EQ(spec_of("ANY").error().code, Code::NOT_NEGOTIATED);
  const Error video = spec_of("video/x-raw,format=RGB").error();
  EXPECT_EQ(video.code, Code::FORMAT_UNSUPPORTED);
  EXPECT_SAYS(video.message(), "offered: video/x-raw");
  EXPECT_SAYS(spec_of("other/tensor,dimension=(string)\"1,2\"").error().message(),
              "other/tensor caps hold one tensor only");
  EXPECT_EQ(spec_of("other/tensors,format=static,num_tensors=257").error().code,
            Code::LIMIT_EXCEEDED);
  EXPECT_EQ(spec_of("other/tensors,format=static,dimensions=(string)a:b").error().code,
            Code::DIMENSION_SYNTAX);
}

TEST(TensorCaps, OfAStreamMustBeFixedCompleteAndOfAPossibleSize) {
  EXPECT_EQ(fixed_error(kTwo), "");
  EXPECT_SAYS(
      fixed_error(
          "other/tensor,dimension=(string)3,type={(string)uint8,(string)int8},framerate=0/1"),
      "the caps are not fixed");
  EXPECT_SAYS(fixed_error("other/tensor,dimension=(string)3,framerate=0/1"),
              "the caps do not describe the tensors completely");
  EXPECT_SAYS(fixed_error("other/tensor,type=float64,framerate=0/1,dimension=(string)"
                          "4294967295:4294967295:4294967295"),
              "the tensors of the caps are too big");
}

TEST(TensorCaps, ToPasteAreReadAsTheSameTensors) {
  const FrameSpec spec = static_spec("\"3:4:2,5\"", "\"uint8,float32\"");
  const auto again = spec_of(caps_to_paste(spec));
  ASSERT_TRUE(again);
  EXPECT_EQ(first_difference(again->tensors, spec.tensors), "");
  EXPECT_EQ(caps_to_paste(*spec_of("other/tensors,format=flexible,framerate=1/1")),
            "other/tensors,format=flexible");
}

TEST(TensorCaps, WithoutDimensionsKeepTheRest) {
  const Caps open = without_dimensions(caps_of(kTwo));
  const GstStructure* s = gst_caps_get_structure(open.get(), 0);
  EXPECT_FALSE(gst_structure_has_field(s, "dimensions"));
  EXPECT_STREQ(gst_structure_get_string(s, "types"), "uint8,float32");
}

// A source pad, linked to a sink pad that accepts `accepted`.
class Link {
 public:
  explicit Link(const char* accepted)
      : source_(pad("src", GST_PAD_SRC,
                    WEIR_CAPS_TENSOR "; " WEIR_CAPS_TENSORS("{ static, flexible }"))),
        sink_(pad("sink", GST_PAD_SINK, accepted)) {
    EXPECT_EQ(gst_pad_link(source_.get(), sink_.get()), GST_PAD_LINK_OK);
  }
  std::string chosen(const FrameSpec& spec) const {
    const Caps caps = choose_caps(source_.get(), PeerCaps(source_.get()), spec);
    return caps ? UniqueText(gst_caps_to_string(caps.get())).get() : "none";
  }
  GstPad* source() const { return source_.get(); }

 private:
  static Ref<GstPad> pad(const char* name, GstPadDirection direction, const char* text) {
    const Caps caps = caps_of(text);
    GstPadTemplate* made = gst_pad_template_new(name, direction, GST_PAD_ALWAYS, caps.get());
    auto out = Ref<GstPad>::adopt(
        static_cast<GstPad*>(gst_object_ref_sink(gst_pad_new_from_template(made, name))));
    gst_object_unref(made);
    gst_pad_set_active(out.get(), TRUE);
    return out;
  }
  Ref<GstPad> source_, sink_;
};

TEST(TensorCaps, ChosenForOneTensorPreferOtherTensor) {
  const FrameSpec one = static_spec("3:4", "uint8");
  EXPECT_SAYS(Link(WEIR_CAPS_TENSOR "; " WEIR_CAPS_TENSORS("static")).chosen(one),
              "other/tensor, ");
  EXPECT_SAYS(Link(WEIR_CAPS_TENSORS("static")).chosen(one),
              "other/tensors, format=(string)static");
  EXPECT_SAYS(Link(WEIR_CAPS_TENSOR).chosen(static_spec("\"3,4\"", "\"int8,int8\"")),
              "other/tensors, format=(string)static, num_tensors=(int)2");
}

TEST(TensorCaps, ChosenForAPeerThatPrefersFlexibleAreFlexible) {
  const Link link(WEIR_CAPS_TENSORS("flexible"));
  EXPECT_TRUE(PeerCaps(link.source()).flexible);
  EXPECT_SAYS(link.chosen(static_spec("3:4", "uint8")), "format=(string)flexible");
  EXPECT_FALSE(PeerCaps(Link(WEIR_CAPS_TENSOR).source()).flexible);
}

TEST(TensorCaps, ChosenUseThePeersSpellingOfADimension) {
  const std::string peer =
      "other/tensor,dimension=(string)3:4:1:1:1,type=(string)uint8,framerate=30/1";
  EXPECT_SAYS(Link(peer.c_str()).chosen(static_spec("3:4", "uint8")),
              "dimension=(string)3:4:1:1:1");
}

TEST(TensorCaps, AMismatchNamesBothSides) {
  const Caps peer = caps_of("other/tensor,type=(string)int8");
  const Error error = downstream_mismatch("one", peer.get(), "1 tensor: uint8 3", "a fix");
  EXPECT_EQ(error.code, Code::SPEC_MISMATCH);
  EXPECT_EQ(error.what, "the element downstream of one does not accept its output");
  EXPECT_EQ(error.offered, "1 tensor: uint8 3");
  EXPECT_SAYS(error.needed, "type=(string)int8");
}

}  // namespace tensor_caps_test
}  // namespace weir::gst
