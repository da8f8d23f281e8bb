// What GStreamer's parser of caps may be given, and what would end the process.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/text/caps_syntax.hpp"

#include <gtest/gtest.h>

#include "core/text/caps_type.hpp"
#include "says.hpp"

namespace weir {
namespace caps_syntax_test {

bool is_flags(const std::string& name) {
  return name == "GstVideoMultiviewFlagsSet";
}
Status check(const std::string& text) {
  return check_caps_text(text, is_flags);
}
std::string repeated(const std::string& text, size_t count) {
  std::string out;
  for (size_t i = 0; i < count; ++i) out += text;
  return out;
}

TEST(CapsSyntax, AcceptsTheCapsOfStreams) {
  for (const char* text : {
           "",
           "ANY",
           "EMPTY",
           "other/tensors, format=(string){ static, flexible }, framerate=(fraction)[ 0/1, "
           "2147483647/1 ]",
           "other/tensors,format=static,num_tensors=2,dimensions=\"3:4:2,5\",types=\"uint8,int8\"",
           "video/x-raw(memory:DMABuf, meta:GstVideoOverlayComposition), width=(int)[ 2, 8, 2 ]; "
           "audio/x-raw, rate=(int)[ 1, max ], channel-mask=(bitmask)0x0000000000000003;",
           "video/x-raw(ANY),multiview-flags=(GstVideoMultiviewFlagsSet)0:ffffffff:/right-view",
           "audio/x-opus, streamheader=(buffer)< 4f70, 00 >, codec_data=(buffer)01ff",
           "a,b=(int)< < (int)1, (int)2 >, < (int)3 > >,c=(string){  }",
           "a,b=(GstCaps)\"video/x-raw\\,\\ a\\=\\(int\\)\\{\\ 1\\,\\ 2\\ \\}\"",
           "a,b=(structure){ \"c\\,\\ d\\=\\(int\\)1\\;\", \"e\" }",
           "a,b=\"Gr\\303\\274\\303\\237e \\\"{[<\\\"\",c=[ -1.5, 2e3 ]",
           "a,b=(structure)[ c, d=(int)[ 1, 2 ], e=(structure)[f] ],g=(GstCaps)[h(i:j),k=1; l]",
           " a , b = 1 ;\n c",
       })
    EXPECT_TRUE(check(text)) << text;
}

TEST(CapsSyntax, TensorsOfThePeersOfTheLargestKindAreWithinTheLimits) {
  EXPECT_TRUE(
      check("other/tensors,format=(string)static,num_tensors=(int)256,dimensions=(string)\"" +
            repeated(repeated("4294967295:", 15) + "4294967295\\,", 256) + "\",types=(string)\"" +
            repeated("float64\\,", 256) + "\""));
}

TEST(CapsSyntax, RefusesWhatTheParserWouldRecurseInto) {
  const size_t max = kMaxCapsDepth;
  for (const auto& [open, close] : {std::pair{"{", "}"}, {"<", ">"}}) {
    const std::string begin = "a,b=";
    EXPECT_TRUE(check(begin + repeated(open, max) + "1" + repeated(close, max)));
    EXPECT_REFUSED(check(begin + repeated(open, max + 1) + "1" + repeated(close, max + 1)),
                   LIMIT_EXCEEDED, "at most 16 lists or structures in each other");
    EXPECT_REFUSED(check(begin + repeated(open, 60000)), LIMIT_EXCEEDED, "60004 bytes");
  }
  // Structures inside strings, whose text may have brackets as numbers.
  EXPECT_REFUSED(check("a,b=(structure)\"c,d=" + repeated("{", 30000) + "\""), LIMIT_EXCEEDED,
                 "at byte 15");
  EXPECT_REFUSED(check("a,b=(structure)\"c,d=" + repeated("\\173", 10000) + "\""), OPTION_SYNTAX,
                 "a structure without \\NNN");
  EXPECT_REFUSED(check("a,b=" + repeated("(structure)[c,d=", 8000)), LIMIT_EXCEEDED, "at most 16");
  EXPECT_REFUSED(check("a,b=(structure)[c,d=\"]{{{{{\"]{{{"), OPTION_SYNTAX, "a comma");
  EXPECT_REFUSED(check("a,b=(list)\"{{{{\""), OPTION_SYNTAX, "without quotation marks");
}

// Brackets in quotes, which close nothing, do not hide the depth.
TEST(CapsSyntax, QuotesAndWrongBracketsDoNotHideTheDepth) {
  EXPECT_REFUSED(check("a,b=" + repeated("{ \"}\", ", 100)), LIMIT_EXCEEDED, "at most 16");
  EXPECT_REFUSED(check("a,b=" + repeated("{ \"\\\"}\", ", 100)), LIMIT_EXCEEDED, "at most 16");
  EXPECT_REFUSED(check("a,b={ >"), OPTION_SYNTAX, "a value");
  EXPECT_TRUE(check("a,b=\"" + repeated("{", 1000) + "\"")) << "a string may have any text";
}

TEST(CapsSyntax, CountsStructuresFieldsFeaturesAndBytes) {
  EXPECT_TRUE(check(repeated("a;", kMaxCapsStructures)));
  EXPECT_REFUSED(check(repeated("a;", kMaxCapsStructures + 1)), LIMIT_EXCEEDED,
                 "at most 1024 structures");
  EXPECT_TRUE(check("a" + repeated(",b=1", kMaxCapsFields)));
  EXPECT_REFUSED(check("a" + repeated(",b=1", kMaxCapsFields + 1)), LIMIT_EXCEEDED,
                 "at most 4096 fields");
  EXPECT_REFUSED(check("a(" + repeated("b:c,", kMaxCapsFeatures) + "b:c)"), LIMIT_EXCEEDED,
                 "at most 256 caps features");
  const std::string longest = "a,b=\"" + repeated("x", kMaxCapsBytes - 6) + "\"";
  EXPECT_TRUE(check(longest));
  EXPECT_REFUSED(check(longest + " "), LIMIT_EXCEEDED, "at most 131072 bytes");
}

TEST(CapsSyntax, RefusesWhatFailsAnAssertion) {
  for (const auto& [text, needed] : {
           std::pair{"1video/x-raw", "a media type, which begins with a letter"},
           {"-", "a media type"},
           {"a,b=(buffer)abc", "bytes in hexadecimal"},
           {"a,b=(buffer)xy", "bytes in hexadecimal"},
           {"a,b=(GstTagList)x", "the name of a type that caps have"},
           {"a,b=(GObject)x", "the name of a type that caps have"},
           {"a,b=()x", "the name of a type that caps have"},
           {"a,b=(void)x", "the name of a type that caps have"},
           {"a,b=(structure)\"1c\"", "a media type, which begins with a letter"},
           {"a,b=(structure)1c", "a media type, which begins with a letter"},
           {"a,b=(structure)\"c;d\"", "the end after one structure"},
           {"a,b=(GstIntRange)1", "the name of a type that caps have"},
           {"a,b=[2,1]", "a range of two numbers"},
           {"a,b=(string)[1,2]", "a range of two numbers"},
           {"a,b=(structure)[1c]", "a media type, which begins with a letter"},
           {"a,b=(structure)[c", "] after a structure"},
           {"a,b=1]", "a comma, a semicolon or the end"},
           {"a,b=(structure)[c;d]", "] after a structure"},
           {"a(b)", "a caps feature such as memory:DMABuf"},
           {"a(\x1b:b)", "a caps feature such as memory:DMABuf"},
           {"a,b=\"c", "a quotation mark at the end"},
           {"a,b=\"c\\", "a quotation mark at the end"},
           {"a,b", "= after the name of a field"},
           {"a,b=1,", "the name of a field"},
           {"a,b=1 c", "a comma, a semicolon or the end"},
           {"a,b=\xff", "text in UTF-8"},
       })
    EXPECT_REFUSED(check(text), OPTION_SYNTAX, needed);
  EXPECT_REFUSED(check(std::string("a\0b", 3)), OPTION_SYNTAX, "text in UTF-8");
}

// GStreamer leaks what it has read of such a list.
TEST(CapsSyntax, RefusesListsWithAValueThatCannotBeRead) {
  EXPECT_TRUE(check("a,b=(int)x")) << "left to GStreamer";
  for (const char* text :
       {"a,b={(int)1,(int)x}", "a,b=(int){ 1, 2147483648 }", "a,b=(uint)<-1>", "a,b=(float){1e300}",
        "a,b=(fraction){1/0}", "a,b=(boolean){maybe}", "a,b=(bitmask){0xg}", "a,b={(flagset)0}",
        "a,b=(string){\"\\377\"}", "a,b=(int){\"1\"}", "a,b={(structure)[c,d=(int)x]}",
        "a,b={(structure)\"c,d=(int)x\"}"})
    EXPECT_REFUSED(check(text), OPTION_SYNTAX, "values of the type of their list");
  EXPECT_REFUSED(check("a,b={[1,2.5]}"), OPTION_SYNTAX, "a range of two numbers");
  for (const char* text :
       {"a,b=(uint){ 0, 4294967295 }", "a,b=(uint64)<18446744073709551615>", "a,b=(float){-1e3}",
        "a,b=(fraction){ 30/1, 0 }", "a,b=(boolean){ true, false }", "a,b=(bitmask){0x3}",
        "a,b=(string){ x, \"Gr\\303\\274\" }", "a,b=(int64){ -1, [1,2] }",
        "a,b={ x, 1, 1/2, \"y\" }"})
    EXPECT_TRUE(check(text)) << text;
}

TEST(CapsSyntax, AStructureIsOneWithoutFeatures) {
  EXPECT_TRUE(check_structure_text("a,b=1;", is_flags));
  EXPECT_TRUE(check_structure_text("a", is_flags));
  EXPECT_REFUSED(check_structure_text("a;b", is_flags), OPTION_SYNTAX, "the end after one");
  EXPECT_REFUSED(check_structure_text("", is_flags), OPTION_SYNTAX, "begins with a letter");
  EXPECT_REFUSED(check_structure_text("a(b:c)", is_flags), OPTION_SYNTAX, "a comma");
}

TEST(CapsSyntax, AnErrorHasThePlaceAndEscapesTheText) {
  EXPECT_EQ(check("a,b=\x1b[2J").error().message(),
            "WEIR-1001: the text of caps cannot be used\n"
            "  offered: \"a,b=\\x1b[2J\", 8 bytes\n"
            "  needed: a value\n"
            "  first difference: at byte 4\n"
            "  fix: write caps as gst_caps_to_string() does");
}

TEST(CapsRange, IsOfTwoNumbersInOrder) {
  using enum RangeType;
  EXPECT_TRUE(is_range(Int, "-2147483648", "2147483647", ""));
  EXPECT_TRUE(is_range(Int, "min", "MAX", ""));
  EXPECT_FALSE(is_range(Int, "1", "2147483648", ""));
  EXPECT_FALSE(is_range(Int, "1", "1", ""));
  EXPECT_FALSE(is_range(Int, "", "", ""));
  EXPECT_TRUE(is_range(Int, "2", "6", "2"));
  EXPECT_FALSE(is_range(Int, "2", "7", "2"));
  EXPECT_FALSE(is_range(Int, "2", "6", "0"));
  EXPECT_FALSE(is_range(Int, "2", "6", "-2"));
  EXPECT_TRUE(is_range(Int64, "1", "9223372036854775807", ""));
  EXPECT_FALSE(is_range(Int64, "1", "9223372036854775808", ""));
  EXPECT_TRUE(is_range(Double, "0.5", "1e3", ""));
  EXPECT_FALSE(is_range(Double, "1", "nan", ""));
  EXPECT_FALSE(is_range(Double, "0", "4", "2"));
  EXPECT_TRUE(is_range(Fraction, "0", "2147483647/1", ""));
  EXPECT_FALSE(is_range(Fraction, "1/2", "2/4", ""));
  EXPECT_FALSE(is_range(Fraction, "0/1", "1/0", ""));
  EXPECT_FALSE(is_range(Fraction, "-2147483648/1", "0/1", ""));
  EXPECT_TRUE(is_range(Guessed, "1/3", "1/2", ""));
  EXPECT_FALSE(is_range(Guessed, "a", "b", ""));
}

}  // namespace caps_syntax_test
}  // namespace weir
