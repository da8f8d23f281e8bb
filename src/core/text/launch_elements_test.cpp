// Compares the elements of a description with those that gst_parse_launch 1.22 creates.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/text/launch_elements.hpp"

#include <gtest/gtest.h>

namespace weir {
namespace launch_elements_test {

using Names = std::vector<std::string>;

Names factories(std::string_view text) {
  return launch_elements(text).factories;
}

TEST(LaunchElements, AreTheNamesBetweenLinks) {
  EXPECT_EQ(factories("fakesrc ! identity ! fakesink"), (Names{"fakesrc", "identity", "fakesink"}));
  EXPECT_EQ(factories("fakesrc!identity!fakesink"), (Names{"fakesrc", "identity", "fakesink"}));
  EXPECT_EQ(factories("a : b"), (Names{"a", "b"}));
  EXPECT_EQ(factories("a b"), (Names{"a", "b"}));
  EXPECT_EQ(factories(""), Names());
}

TEST(LaunchElements, AreNotCaps) {
  for (const char* caps :
       {"video/x-raw", "video/x-raw,format=RGB,width=8", "video/x-raw, format=RGB , width = 8",
        "video/x-raw;audio/x-raw", "video/x-raw(memory:DMABuf),format=(string){ RGB, BGR }",
        "other/tensors,dimensions=3:2"}) {
    EXPECT_EQ(factories(std::string("a ! ") + caps + " ! b"), (Names{"a", "b"})) << caps;
    EXPECT_EQ(factories(std::string("a !") + caps + "! b"), (Names{"a", "b"})) << caps;
  }
}

TEST(LaunchElements, AreNotPropertiesOrPads) {
  EXPECT_EQ(factories("a name=x key = y other=\"u v\" more='w ! filesink' ! b"), (Names{"a", "b"}));
  EXPECT_EQ(factories("a name=x x. ! b x.src_0 ! c x.src_1,src_2 ! d .p , q"),
            (Names{"a", "b", "c", "d"}));
  EXPECT_EQ(factories("a name=escaped\\ blank ! b"), (Names{"a", "b"}));
  EXPECT_EQ(factories("a key=b=c"), (Names{"a"}));
}

TEST(LaunchElements, AreInBins) {
  EXPECT_EQ(factories("( a ! b )"), (Names{"a", "b"}));
  EXPECT_EQ(factories("(name=x a ! b )"), (Names{"a", "b"}));
  EXPECT_EQ(factories("myfactory.( a ! b )"), (Names{"myfactory", "a", "b"}));
  EXPECT_EQ(factories("myfactory . ( a )"), (Names{"myfactory", "a"}));
}

// Each of these creates an identity although it looks like part of something else.
TEST(LaunchElements, AreFoundInPropertiesThatCreateElements) {
  for (const char* text :
       {"fakesrc name=\"a b\"identity ! fakesink", "fakesrc name='a b'identity ! fakesink",
        "fakesrc name=\"a\\\" identity ! fakesink", "fakesrc name=x\"y identity\" ! fakesink",
        "fakesrc ! video/x-raw ; identity ! fakesink", "fakesrc : identity : fakesink",
        "fakesrc name=a, identity", "\"identity\"", "fakesrc ! video/x-raw, format=RGB identity",
        "fakesrc ,identity ! fakesink", "fakesrc; identity", "fakesrc # identity",
        "( fakesrc name=x ) ( identity name=x )", "fakesrc @identity", "{ identity }"}) {
    const auto found = factories(text);
    EXPECT_NE(std::find(found.begin(), found.end(), "identity"), found.end()) << text;
  }
}

TEST(LaunchElements, AreCreatedFromUris) {
  const auto found = launch_elements("file:///etc/passwd ! a ! rtsp+x.y://host/b");
  EXPECT_EQ(found.uri_schemes, (Names{"file", "rtsp+x.y"}));
  EXPECT_EQ(found.factories, (Names{"a"}));
}

TEST(LaunchElements, AreOutsideBinsWithoutParentheses) {
  const auto outside = [](std::string_view text) { return launch_elements(text).outside_bins; };
  EXPECT_EQ(outside("a ! ( b ! ( c ) ! d ) ! e"), (Names{"a", "e"}));
  EXPECT_EQ(outside("bin.( a ! b ) c"), (Names{"bin", "c"}));
  EXPECT_EQ(outside(") a ( b"), (Names{"a"}));
}

TEST(LaunchElements, HaveProperties) {
  const auto found = launch_elements(R"(playbin uri=file:///x video-sink="a ! b location=\"c\"")");
  EXPECT_EQ(found.factories, (Names{"playbin"}));
  EXPECT_TRUE(found.uri_schemes.empty());
  ASSERT_EQ(found.properties.size(), 2u);
  EXPECT_EQ(found.properties[1].factory, "playbin");
  EXPECT_EQ(found.properties[1].name, "video-sink");
  EXPECT_EQ(found.properties[1].value, "a ! b location=\"c\"");
}

}  // namespace launch_elements_test
}  // namespace weir
