// Compares the modes and options that model cards may name with the decoders that Weir has.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/card/decoder_modes.hpp"
#include "core/infer/module/decoder.hpp"
#include "core/infer/module/module_library.hpp"

namespace weir::testing_tensor_decoder {
namespace card_modes_test {

using Names = std::vector<std::string>;

Names sorted(Names names) {
  std::sort(names.begin(), names.end());
  return names;
}
Names get_options(const card::DecoderMode& mode) {
  Names out;
  for (const auto& option : mode.options) out.emplace_back(option.name);
  return sorted(std::move(out));
}

TEST(CardModes, HaveTheOptionsOfTheirDecoders) {
  auto& library = infer::ModuleLibrary::instance();
  size_t compared = 0;
  for (const card::DecoderMode& mode : card::decoder_modes()) {
    const auto type = library.decoder(mode.name);
    // The modules of messages are built where their compilers are.
    const bool is_optional = mode.name == "protobuf" || mode.name.starts_with("fl");
    if (!type && is_optional) continue;
    ASSERT_TRUE(type) << mode.name << ": " << type.error().message();
    EXPECT_EQ(get_options(mode), sorted(infer::option_names(**type))) << mode.name;
    ++compared;
  }
  EXPECT_GE(compared, 18u);
}

TEST(CardModes, AreAllDecodersThatRunNoCode) {
  const Names others{"erring", "python3"};  // a module of the tests, and scripts
  for (const std::string& name : infer::ModuleLibrary::instance().decoder_names())
    EXPECT_EQ(card::find_decoder_mode(name) == nullptr,
              std::find(others.begin(), others.end(), name) != others.end())
        << name;
  EXPECT_EQ(card::find_decoder_mode("custom-code"), nullptr);
}

// The type that a decoder declares for an option decides whether a card may name a file there.
TEST(CardModes, KnowTheOptionsThatAreFiles) {
  for (const card::DecoderMode& mode : card::decoder_modes()) {
    const auto type = infer::ModuleLibrary::instance().decoder(mode.name);
    if (!type || !(*type)->options_json) continue;
    for (const auto& declared : nlohmann::json::parse((*type)->options_json)) {
      const auto name = declared["name"].get<std::string>();
      const auto help = declared["help"].get<std::string>();
      const auto* option = mode.option(name);
      ASSERT_TRUE(option) << mode.name << " " << name;
      const bool is_file = declared["type"] == "file" || help.find("ile ") != std::string::npos ||
                           help.find("ile;") != std::string::npos || name == "priors";
      EXPECT_EQ(option->value == card::Value::File || option->value == card::Value::Files ||
                    option->value == card::Value::FileFirst,
                is_file)
          << mode.name << " " << name << ": " << help;
    }
  }
}

}  // namespace card_modes_test
}  // namespace weir::testing_tensor_decoder
