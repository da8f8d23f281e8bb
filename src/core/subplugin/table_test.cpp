// Tests which descriptors can be registered, and the errors for others.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/subplugin/table.hpp"

#include <gtest/gtest.h>

#include <thread>

#include "says.hpp"

namespace weir::subplugin {
namespace table_test {

TEST(SubPluginTable, KeepsDescriptorsByKindAndName) {
  Table table;
  const int filter = 1, decoder = 2;
  EXPECT_TRUE(table.add(Kind::Filter, "same", &filter));
  EXPECT_TRUE(table.add(Kind::Decoder, "same", &decoder)) << "each kind has names of its own";
  EXPECT_EQ(table.find(Kind::Filter, "same"), &filter);
  EXPECT_EQ(table.find(Kind::Decoder, "same"), &decoder);
  EXPECT_EQ(table.find(Kind::Trainer, "same"), nullptr);
  EXPECT_EQ(table.find(Kind::Filter, "Same"), nullptr) << "case counts";
  EXPECT_TRUE(table.add(Kind::Filter, "before", &filter));
  EXPECT_EQ(table.names(Kind::Filter), (std::vector<std::string>{"before", "same"}));
  EXPECT_TRUE(table.remove(Kind::Filter, "same"));
  EXPECT_FALSE(table.remove(Kind::Filter, "same"));
  EXPECT_EQ(table.find(Kind::Filter, "same"), nullptr);
  EXPECT_TRUE(table.add(Kind::Filter, "same", &decoder)) << "the name is free again";
}

TEST(SubPluginTable, RejectsNamesThatAreEmptyReservedOrTaken) {
  Table table;
  const int any = 1;
  for (const char* name : {"any", "ANY", "auto", "Auto"}) {
    const auto status = table.add(Kind::Converter, name, &any);
    ASSERT_FALSE(status);
    EXPECT_EQ(status.error().code, Code::OPTION_VALUE);
    EXPECT_SAYS(status.error().message(), "this name is reserved\n  offered: " + std::string(name));
  }
  EXPECT_SAYS(table.add(Kind::Decoder, "", &any).error().message(), "a sub-plugin has no name");
  EXPECT_TRUE(table.add(Kind::Decoder, "automatic", &any));
  EXPECT_SAYS(table.add(Kind::Decoder, "automatic", &any).error().message(),
              "another decoder already has this name\n  offered: automatic");
}

TEST(SubPluginTable, RecordsWhatAThreadRegisters) {
  Table table;
  const int any = 1;
  EXPECT_TRUE(table.add(Kind::Filter, "earlier", &any));
  {
    const Table::Recording recording(table);
    EXPECT_EQ(recording.to_string(), "it registered nothing");
    std::thread([&] { EXPECT_TRUE(table.add(Kind::Filter, "elsewhere", &any)); }).join();
    EXPECT_TRUE(table.add(Kind::Filter, "mine", &any));
    EXPECT_FALSE(table.add(Kind::Decoder, "auto", &any));
    {
      const Table::Recording inner(table);
      EXPECT_TRUE(table.add(Kind::Filter, "inner", &any));
      EXPECT_EQ(inner.to_string(), "it registered the filter inner");
    }
    table.refuse(
        Kind::Trainer,
        {.code = Code::MODULE_REFUSED, .what = "no function start", .offered = "it is NULL"});
    EXPECT_EQ(
        recording.to_string(),
        "it registered the filter mine; a decoder was rejected: this name is reserved (auto); "
        "a trainer was rejected: no function start (it is NULL)");
  }
  EXPECT_TRUE(table.add(Kind::Filter, "later", &any));
}

TEST(SubPluginTable, KeepsDescriptionsAsLongAsTheName) {
  Table table;
  const int any = 1;
  EXPECT_TRUE(table.add(Kind::Decoder, "d", &any));
  table.describe(Kind::Decoder, "d", "option1", "a file");
  table.describe(Kind::Decoder, "d", "option2", "a size");
  table.describe(Kind::Decoder, "d", "option1", "a label file");
  EXPECT_EQ(table.descriptions(Kind::Decoder, "d"),
            (Table::Descriptions{{"option1", "a label file"}, {"option2", "a size"}}));
  EXPECT_TRUE(table.descriptions(Kind::Filter, "d").empty());
  table.remove(Kind::Decoder, "d");
  EXPECT_TRUE(table.descriptions(Kind::Decoder, "d").empty());
}

}  // namespace table_test
}  // namespace weir::subplugin
