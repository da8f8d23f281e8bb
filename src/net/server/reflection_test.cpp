// What reflection answers, from a description that is written here.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "net/server/reflection.hpp"

#include <gtest/gtest.h>

#include "says.hpp"

namespace weir::net {
namespace reflection_test {

std::string field(uint32_t number, const std::string& bytes) {
  std::string out;
  put_bytes(&out, number, bytes);
  return out;
}

// A FileDescriptorProto: package p, type T with the inner type U and the enum E, service S.M.
const std::string kFile =
    field(1, "f.proto") + field(2, "p") +
    field(4, field(1, "T") + field(3, field(1, "U")) + field(4, field(1, "E"))) +
    field(6, field(1, "S") + field(2, field(1, "M")));
const std::string kSet = field(1, kFile);

std::string respond(const std::string& question) {
  const Reflection reflection(kSet);
  auto out = reflection.respond(Chunks({std::as_bytes(std::span(question))}));
  return out ? (*out)[0].own : out.error().message();
}

TEST(Reflection, FindsFilesByEachSymbol) {
  for (const auto* symbol : {"p.T", "p.T.U", "p.T.E", "p.S", "p.S.M"})
    EXPECT_EQ(respond(field(4, symbol)), field(2, field(4, symbol)) + field(4, field(1, kFile)))
        << symbol;
  EXPECT_EQ(respond(field(3, "f.proto")),
            field(2, field(3, "f.proto")) + field(4, field(1, kFile)));
}

TEST(Reflection, ListsServicesForTheHost) {
  const std::string question = field(1, "host") + field(7, "");
  EXPECT_EQ(respond(question),
            field(1, "host") + field(2, question) + field(6, field(1, field(1, "p.S"))));
}

TEST(Reflection, AnswersWhatIsNotThereWithNotFound) {
  for (const auto* symbol : {"T", "p", "p.S.", "p.S.N", ""})
    EXPECT_EQ(
        respond(field(4, symbol)),
        field(2, field(4, symbol)) +
            field(7, "\x08\x05" + field(2, "there is no symbol " + std::string(symbol) + " here")));
}

TEST(Reflection, RefusesWhatIsNoQuestion) {
  for (const auto& bytes : {std::string(), std::string("\xff"), field(1, "host"),
                            field(4, std::string(1025, 'a')), field(2, std::string(5000, 'a'))})
    EXPECT_SAYS(respond(bytes), "offered: a damaged ServerReflectionRequest");
}

TEST(Reflection, IsEmptyWithoutDescriptions) {
  EXPECT_TRUE(Reflection("").empty());
  EXPECT_FALSE(Reflection(kSet).empty());
}

// Not from peers; but a description that is cut off must not crash.
TEST(Reflection, ReadsWhatThereIsOfACutDescription) {
  for (size_t bytes = 0; bytes < kSet.size(); ++bytes)
    EXPECT_TRUE(Reflection(std::string_view(kSet).substr(0, bytes)).empty());
}

}  // namespace reflection_test
}  // namespace weir::net
