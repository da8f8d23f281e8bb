// Tests the chosen engine, the reason and the alternatives.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/module/engine_choice.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <map>

#include "says.hpp"

namespace weir::infer {
namespace engine_choice_test {

using Names = std::vector<std::string>;

// A configuration with one setting, from an environment variable.
config::Configuration configured(const std::string& key = "", const std::string& value = "") {
  return config::Configuration([=](const char* name) -> const char* {
    static thread_local std::string kept;
    if (std::string(name) == "WEIR_CONFIG") return "";
    if (key.empty() || config::variable_name("filter", key) != name) return nullptr;
    kept = value;
    return kept.c_str();
  });
}
EngineChoice chosen(const Names& paths, const Names& installed,
                    const config::Configuration& configuration = configured()) {
  const auto choice = choose_engine(paths, installed, configuration);
  return choice ? *choice : EngineChoice{"", choice.error().message(), {}};
}

const Names kBoth{"onnxruntime", "tensorflow-lite"};

TEST(EngineChoice, FollowsTheExtensionOfTheFile) {
  const auto choice = chosen({"dir.x/A.TFLITE"}, kBoth);
  EXPECT_EQ(choice.engine, "tensorflow-lite");
  EXPECT_EQ(choice.reason, "the file has the extension .tflite");
  EXPECT_EQ(choice.others, Names{});
  EXPECT_EQ(chosen({"a.onnx"}, {}).engine, "onnxruntime") << "installed or not";
  EXPECT_EQ(chosen({"a.so"}, {}).engine, "custom");
}

TEST(EngineChoice, TakesTheFirstInstalledOneOfWeirsList) {
  const auto choice = chosen({"a.tflite"}, {"armnn", "edgetpu"});
  EXPECT_EQ(choice.engine, "armnn");
  EXPECT_EQ(choice.others, Names{"edgetpu"});
}

TEST(EngineChoice, FollowsThePriorityOfTheUser) {
  const auto choice = chosen({"a.tflite"}, kBoth,
                             configured("priority_tflite", "nnfw; onnxruntime,tensorflow2-lite"));
  EXPECT_EQ(choice.engine, "onnxruntime");
  EXPECT_EQ(choice.reason,
            "the file has the extension .tflite; first installed engine of priority_tflite "
            "(WEIR_FILTER_PRIORITY_TFLITE)");
  EXPECT_EQ(choice.others, Names{"tensorflow-lite"}) << "an alias means its engine";
}

// A configuration with one line in nnstreamer.ini.
config::NnstreamerConfiguration nnstreamer(const std::string& line) {
  const std::string path = testing::TempDir() + "weir-engine-choice-nnstreamer.ini";
  std::ofstream(path) << "[filter]\n" << line << "\n";
  return config::NnstreamerConfiguration([&](const char* name) -> const char* {
    if (std::string_view(name) == "WEIR_CONFIG") return "";
    return std::string_view(name) == "NNSTREAMER_CONF" ? path.c_str() : nullptr;
  });
}

TEST(EngineChoice, FallsBackToThePriorityOfNnstreamer) {
  const auto theirs = nnstreamer("framework_priority_tflite = armnn,onnxruntime");
  const auto choice = choose_engine(Names{"a.tflite"}, kBoth, configured(), &theirs);
  ASSERT_TRUE(choice);
  EXPECT_EQ(choice->engine, "onnxruntime");
  EXPECT_EQ(choice->reason,
            "the file has the extension .tflite; first installed engine of "
            "framework_priority_tflite (" +
                theirs.path() + ":2)");
  const auto both = choose_engine(Names{"a.tflite"}, kBoth,
                                  configured("priority_tflite", "tensorflow-lite"), &theirs);
  EXPECT_EQ(both->engine, "tensorflow-lite") << "Weir's own wins";
  const auto none =
      choose_engine(Names{"a.tflite"}, kBoth, configured("priority_tflite", "nnfw"), &theirs);
  EXPECT_EQ(none->engine, "onnxruntime") << "where Weir's list has nothing that is installed";
  EXPECT_EQ(
      none->reason,
      "the file has the extension .tflite; first installed engine of framework_priority_tflite "
      "(" +
          theirs.path() + ":2)");
  const auto empty = nnstreamer("framework_priority_tflite =");
  EXPECT_EQ(choose_engine(Names{"a.tflite"}, kBoth, configured(), &empty)->engine,
            "tensorflow-lite");
}

TEST(EngineChoice, FallsBackIfNoneOfTheListIsInstalled) {
  const auto choice = chosen({"a.tflite"}, kBoth, configured("priority_tflite", "armnn"));
  EXPECT_EQ(choice.engine, "tensorflow-lite");
  EXPECT_EQ(choice.reason,
            "the file has the extension .tflite; none of priority_tflite "
            "(WEIR_FILTER_PRIORITY_TFLITE) is installed");
}

TEST(EngineChoice, CoversFilesThatWeirDoesNotKnow) {
  EXPECT_EQ(chosen({"a.abc"}, {"mine"}, configured("priority_abc", "mine")).engine, "mine");
  EXPECT_EQ(chosen({"a.abc"}, kBoth, configured("priority_abc", "mine")).engine, "mine")
      << "the error says how to install it";
  EXPECT_EQ(chosen({"a.abc"}, kBoth, configured("priority_abc", " , ")).engine, "");
}

TEST(EngineChoice, FollowsTheNamesOfTwoFiles) {
  EXPECT_EQ(chosen({"a.so", "b.nb"}, {}).engine, "vivante");
  EXPECT_EQ(chosen({"a.prototxt", "b.caffemodel"}, {}).reason, "by the names of the model's files");
  EXPECT_EQ(chosen({"a.pb", "b.pb"}, {}).engine, "caffe2");
}

TEST(EngineChoice, FailsIfNoEngineClaimsTheFile) {
  for (const auto& paths :
       std::vector<Names>{{}, {"/etc/passwd"}, {"a.onnx", "b.onnx"}, {"a.pb", "a.pb"}}) {
    const auto choice = chosen(paths, kBoth);
    EXPECT_EQ(choice.engine, "");
    EXPECT_SAYS(choice.reason, "WEIR-3001: no engine can be selected for this model");
  }
}

TEST(EngineChoice, SaysThatTheFileIsNotThereOrIsAFolder) {
  for (const char* path : {"model", "model.", "/nowhere/a.jpg"})
    EXPECT_SAYS(chosen({path}, kBoth).reason, "WEIR-3003: the model file does not exist");
  EXPECT_SAYS(chosen({"/"}, kBoth).reason, "WEIR-3003: the model is a folder\n  offered: /");
  EXPECT_EQ(chosen({"/"}, {"nnfw"}).engine, "nnfw") << "its models are folders";
  EXPECT_SAYS(chosen({"grpc://host:1/m"}, kBoth).reason, "fix: framework=oip");
}

}  // namespace engine_choice_test
}  // namespace weir::infer
