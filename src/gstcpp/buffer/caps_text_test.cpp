// Caps and structures that others wrote. The tests run with G_DEBUG=fatal-criticals.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/buffer/caps_text.hpp"

#include <gtest/gtest.h>

#include "gstcpp/element/error.hpp"
#include "says.hpp"

namespace weir::gst {
namespace caps_text_test {

// Whether the text of caps gives the caps.
void expect_same(const GstCaps* caps) {
  const UniqueText text{gst_caps_to_string(caps)};
  const auto read = caps_from_text(text.get());
  ASSERT_TRUE(read) << text.get() << "\n" << read.error().message();
  EXPECT_TRUE(gst_caps_is_strictly_equal(read->get(), caps)) << text.get();
}

TEST(CapsText, TheTemplatesOfAllElementsAreRead) {
  GList* const all = gst_registry_get_feature_list(gst_registry_get(), GST_TYPE_ELEMENT_FACTORY);
  int count = 0;
  for (GList* at = all; at; at = at->next) {
    const GList* pads = gst_element_factory_get_static_pad_templates(GST_ELEMENT_FACTORY(at->data));
    for (; pads; pads = pads->next, ++count)
      expect_same(Ref<GstCaps>::adopt(gst_static_pad_template_get_caps(
                                          static_cast<GstStaticPadTemplate*>(pads->data)))
                      .get());
  }
  gst_plugin_feature_list_free(all);
  EXPECT_GT(count, 50);
}

TEST(CapsText, EveryTypeThatCapsHaveIsRead) {
  const auto header = Ref<GstBuffer>::adopt(gst_buffer_new_memdup("\x01\xff", 2));
  const auto inner =
      Ref<GstCaps>::adopt(gst_caps_new_simple("video/x-raw", "width", GST_TYPE_INT_RANGE, 1, 9,
                                              "text", G_TYPE_STRING, "a \"{\" b", nullptr));
  const Unique<GstStructure, gst_structure_free> part(gst_structure_new("part", "name",
                                                                        G_TYPE_STRING,
                                                                        "Gr\xC3\xBC\xC3\x9F"
                                                                        "e;",
                                                                        nullptr));
  const auto caps = Ref<GstCaps>::adopt(gst_caps_new_simple(
      "application/x-all", "int", G_TYPE_INT, G_MININT, "uint", G_TYPE_UINT, G_MAXUINT, "int64",
      G_TYPE_INT64, G_MININT64, "uint64", G_TYPE_UINT64, G_MAXUINT64, "double", G_TYPE_DOUBLE, -1.5,
      "float", G_TYPE_FLOAT, 0.5, "text", G_TYPE_STRING,
      "Gr\xC3\xBC\xC3\x9F"
      "e {[<\"\\",
      "truth", G_TYPE_BOOLEAN, TRUE, "fraction", GST_TYPE_FRACTION, 30, 1, "mask", GST_TYPE_BITMASK,
      guint64{3}, "flags", GST_TYPE_FLAG_SET, 1u, 3u, "state", GST_TYPE_STATE, GST_STATE_READY,
      "buffer", GST_TYPE_BUFFER, header.get(), "caps", GST_TYPE_CAPS, inner.get(), "part",
      GST_TYPE_STRUCTURE, part.get(), "range", GST_TYPE_DOUBLE_RANGE, 0.5, 1.5, nullptr));
  const UniqueText text{gst_caps_to_string(caps.get())};
  const auto read = caps_from_text(text.get());
  ASSERT_TRUE(read) << read.error().message();
  const UniqueText again{gst_caps_to_string(read->get())};
  EXPECT_STREQ(again.get(), text.get());
}

// Each of these fails an assertion, warns or overflows the stack in gst_caps_from_string().
TEST(CapsText, WhatGStreamerCannotParseSafelyIsRefused) {
  for (const std::string& text :
       {"video/x-raw,a=" + std::string(60000, '{'), "video/x-raw,a=" + std::string(60000, '<'),
        std::string("-[1,10,3]"), std::string("video/x-raw,a=[ 1.0, 0.5 ]"),
        std::string("video/x-raw,a=[2,1]"), std::string("video/x-raw,a=(gint64)[1,5,2]"),
        std::string("video/x-raw,a=(buffer)2020-01-01"), std::string("video/x-raw,a=(void)x"),
        std::string("video/x-raw,a=(fraction)[1,1]"), std::string("nan(list)"),
        std::string("video/x-raw,a=(GstTagList)1e999"), std::string("video/x-raw,a=(GstElement)x")})
    EXPECT_FALSE(caps_from_text(text)) << text.substr(0, 60);
}

TEST(CapsText, ValuesThatDoNotFitTheirTypeAreAnError) {
  EXPECT_REFUSED(caps_from_text("video/x-raw,width=(int)wide"), OPTION_SYNTAX,
                 "values of the types that the text names");
  EXPECT_REFUSED(structure_from_text("a,b=(fraction)1/0"), OPTION_SYNTAX,
                 "values of the types that the text names");
}

TEST(CapsText, OneStructureIsRead) {
  const auto read = structure_from_text("pose, score=(double)0.5;");
  ASSERT_TRUE(read);
  EXPECT_TRUE(gst_structure_has_name(read->get(), "pose"));
  EXPECT_REFUSED(structure_from_text("pose,a=" + std::string(30000, '{')), LIMIT_EXCEEDED,
                 "at most 16 lists");
}

// Text of peers is in GstMessages, which must be UTF-8, and on terminals.
TEST(PostedError, HasNoControlCharacters) {
  const auto element =
      Ref<GstElement>::adopt(GST_ELEMENT(gst_object_ref_sink(gst_bin_new("escaped"))));
  const auto bus = Ref<GstBus>::adopt(gst_bus_new());
  gst_element_set_bus(element.get(), bus.get());
  post_error(element.get(), Error{.code = Code::PEER_MESSAGE_INVALID,
                                  .what = "a message\x1b[2J",
                                  .offered = "\xff\x07",
                                  .needed = "caf\xC3\xA9"});
  const auto message = Ref<GstMessage>::adopt(gst_bus_pop_filtered(bus.get(), GST_MESSAGE_ERROR));
  ASSERT_TRUE(message);
  GError* raw = nullptr;
  gst_message_parse_error(message.get(), &raw, nullptr);
  const Unique<GError, g_error_free> error(raw);
  EXPECT_STREQ(error->message,
               "WEIR-6004: a message\\x1b[2J\n  offered: \\xff\\x07\n  needed: caf\xC3\xA9");
  const GstStructure* details = nullptr;
  gst_message_parse_error_details(message.get(), &details);
  EXPECT_STREQ(gst_structure_get_string(details, "what"), "a message\\x1b[2J");
  EXPECT_STREQ(gst_structure_get_string(details, "offered"), "\\xff\\x07");
  EXPECT_STREQ(gst_structure_get_string(details, "needed"), "caf\xC3\xA9");
  gst_element_set_bus(element.get(), nullptr);
}

}  // namespace caps_text_test
}  // namespace weir::gst
