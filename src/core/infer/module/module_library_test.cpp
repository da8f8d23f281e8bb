// Tests finding modules and rejecting unusable ones, with files of tests/support.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/module/module_library.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "says.hpp"

namespace weir::infer {
namespace module_library_test {

namespace fs = std::filesystem;

class ModuleLibraryTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const char* modules = std::getenv("WEIR_TEST_MODULES");
    if (!modules) GTEST_SKIP() << "WEIR_TEST_MODULES is not set: run it with meson test";
    folder_ = fs::path(testing::TempDir()) / "weir-module-library-test";
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    search(folder_.string() + ":" + modules);
  }
  void TearDown() override {
    unsetenv("WEIR_MODULE_PATH");
    fs::remove_all(folder_);
  }
  static void search(const std::string& path) { setenv("WEIR_MODULE_PATH", path.c_str(), 1); }
  void write(const std::string& name, const std::string& text) {
    std::ofstream(folder_ / name) << text;
  }
  // The error text, "" without an error.
  std::string refusal(const std::string& name, Code code) {
    const auto engine = library_.engine(name);
    if (engine) return "";
    EXPECT_EQ(engine.error().code, code) << engine.error().message();
    return engine.error().message();
  }

  fs::path folder_;
  ModuleLibrary library_;
};

TEST_F(ModuleLibraryTest, OpensAnEngineOnce) {
  const auto first = library_.engine("fake"), second = library_.engine("fake");
  ASSERT_TRUE(first && second);
  EXPECT_STREQ((*first)->name, "fake");
  EXPECT_EQ(*first, *second);
}

TEST_F(ModuleLibraryTest, ListsModulesWithoutLoadingThem) {
  write("libweir-engine-zzz.so", "not opened");
  write("libweir-decoder-yyy.so", "not opened");
  write("libweir-engine-no-ending", "");
  const auto engines = library_.engine_names();
  EXPECT_TRUE(std::count(engines.begin(), engines.end(), "fake"));
  EXPECT_TRUE(std::count(engines.begin(), engines.end(), "zzz"));
  EXPECT_FALSE(std::count(engines.begin(), engines.end(), "no-ending"));
  EXPECT_TRUE(std::is_sorted(engines.begin(), engines.end()));
  EXPECT_EQ(library_.decoder_names(), std::vector<std::string>{"yyy"});
}

TEST_F(ModuleLibraryTest, PrefersTheFirstFolderOfThePath) {
  write("libweir-engine-fake.so", "hides the good one");
  EXPECT_SAYS(refusal("fake", Code::MODULE_REFUSED), (folder_ / "libweir-engine-fake.so").string());
}

// The loader's message, with the command that fixes it.
TEST_F(ModuleLibraryTest, NamesALibraryThatTheModuleOfAKnownEngineLacks) {
  std::ifstream in(std::string(std::getenv("WEIR_TEST_MODULES")) + "/libweir-engine-fake.so",
                   std::ios::binary);
  std::string module{std::istreambuf_iterator<char>(in), {}};
  const std::string linked = "libc.so.6";
  const size_t at = module.find(linked);
  ASSERT_NE(at, std::string::npos);
  module[at + linked.size() - 1] = '9';
  write("libweir-engine-pytorch.so", module);
  const auto text = refusal("pytorch", Code::ENGINE_NOT_INSTALLED);
  EXPECT_SAYS(text, "a library of the engine pytorch is not installed");
  EXPECT_SAYS(text, "libc.so.9: cannot open shared object file");
  EXPECT_SAYS(text, "fix: apt-get install libtorch-dev");
  write("libweir-engine-own.so", module);
  EXPECT_SAYS(refusal("own", Code::MODULE_REFUSED), "libc.so.9");
}

TEST_F(ModuleLibraryTest, RejectsFaultyModulesWithTheReason) {
  const std::pair<const char*, const char*> faults[] = {
      {"symbol", "no symbol weir_module_entry"},
      {"nothing", "weir_module_entry returned NULL"},
      {"version", "ABI version 1"},
      {"size", "a table of 8 bytes"},
      {"empty", "it contains no engine"},
      {"engine-size", "an engine with a table of 16 bytes"},
      {"engine-name", "an engine without a name"},
      {"engine-functions", "without all of its functions"},
  };
  for (const auto& [kind, words] : faults) {
    const std::string text = refusal(std::string("bad-") + kind, Code::MODULE_REFUSED);
    EXPECT_SAYS(text, words);
    EXPECT_SAYS(text, std::string("libweir-engine-bad-") + kind + ".so");
    EXPECT_SAYS(text, "fix: ");
  }
}

TEST_F(ModuleLibraryTest, RejectsFilesThatAreNotSharedObjects) {
  write("libweir-engine-text.so", "hello");
  write("libweir-engine-nil.so", "");
  write("libweir-engine-header.so", std::string("\x7f"
                                                "ELF\2\1\1\0",
                                                8) +
                                        std::string(100, '\0'));
  for (const char* name : {"text", "nil", "header"})
    EXPECT_SAYS(refusal(name, Code::MODULE_REFUSED), "a shared object for this machine");
}

TEST_F(ModuleLibraryTest, SkipsFoldersAndDanglingLinks) {
  fs::create_directory(folder_ / "libweir-engine-fake.so");
  EXPECT_TRUE(library_.engine("fake")) << "the usable one is in a later folder";
  fs::create_symlink("/nowhere", folder_ / "libweir-engine-gone.so");
  EXPECT_SAYS(refusal("gone", Code::ENGINE_UNKNOWN), "no engine has this name");
}

TEST_F(ModuleLibraryTest, ReportsTheCommandThatInstallsAKnownEngine) {
  search(folder_.string());
  for (const char* word : {"onnxruntime", "onnx"})
    EXPECT_SAYS(refusal(word, Code::ENGINE_NOT_INSTALLED), "tools/setup --engine onnxruntime");
  for (const char* word : {"tensorflow-lite", "tensorflow2-lite", "tflite"})
    EXPECT_SAYS(refusal(word, Code::ENGINE_NOT_INSTALLED), "tools/setup --engine tensorflow-lite");
}

TEST_F(ModuleLibraryTest, NamesEnginesOfNnstreamerThatWeirLacksAndWhatRunsInstead) {
  const auto lacks = [this](const char* word, const char* name, const char* instead) {
    const auto text = refusal(word, Code::ENGINE_NOT_INSTALLED);
    EXPECT_SAYS(text, std::string("Weir has no engine ") + name);
    EXPECT_SAYS(text, std::string("offered: framework=") + word);
    EXPECT_SAYS(text, std::string("needed: ") + instead + "NNStreamer's sub-plugin " +
                          "libnnstreamer_filter_" + name + ".so");
    EXPECT_EQ(text.find("fix:"), std::string::npos) << text;
  };
  lacks("openvino", "openvino", "the model as .onnx, with framework=onnxruntime, or ");
  lacks("ncnn", "ncnn", "the model as .onnx, with framework=onnxruntime, or ");
  lacks("srnpu", "trix-engine", "the .onnx or .tflite file that the model was compiled from, or ");
  lacks("edgetpu", "edgetpu", "the model as .tflite, with framework=tensorflow-lite, or ");
  lacks("executorch", "executorch", "the model as TorchScript, with framework=pytorch, or ");
  lacks("llamacpp", "llamacpp", "");
}

TEST_F(ModuleLibraryTest, SuggestsTheNearestName) {
  EXPECT_SAYS(refusal("onnxruntme", Code::ENGINE_UNKNOWN), "did you mean onnxruntime?");
  EXPECT_SAYS(refusal("half", Code::ENGINE_UNKNOWN),
              "the file libweir-engine-half.so in a folder that WEIR_MODULE_PATH lists\n")
      << "sub-plugins of NNStreamer are not enabled";
  EXPECT_SAYS(refusal("fke", Code::ENGINE_UNKNOWN), "framework=fake");
}

// Also a correct name is unknown where its module is in a folder that is not searched.
TEST_F(ModuleLibraryTest, NamesTheFileOfAModuleAndTheVariableForItsFolder) {
  const std::string text = refusal("brighten", Code::ENGINE_UNKNOWN);
  EXPECT_SAYS(text, "; or the file libweir-engine-brighten.so in a folder that WEIR_MODULE_PATH");
  EXPECT_SAYS(text, "fix: export WEIR_MODULE_PATH=/folder/of/the/module");
  EXPECT_SAYS(refusal("fke", Code::ENGINE_UNKNOWN), "libweir-engine-fke.so");
  const std::string path = refusal("/a/libb.so", Code::ENGINE_UNKNOWN);
  EXPECT_EQ(path.find("WEIR_MODULE_PATH"), std::string::npos) << path;
  EXPECT_EQ(path.find("fix:"), std::string::npos) << path;
}

TEST_F(ModuleLibraryTest, NeverLeavesItsFolders) {
  for (const char* name : {"../fake", "/etc/passwd", "", "a/b"})
    EXPECT_NE(refusal(name, Code::ENGINE_UNKNOWN), "") << name;
}

// docs/compatibility/filter.md 4.2; if no module is installed the error names the chosen engine.
TEST_F(ModuleLibraryTest, ChoosesTheEngineByTheModelsName) {
  search(folder_.string());
  const auto chosen = [&](std::vector<std::string> paths) {
    const auto engine = library_.engine_for_model(paths);
    return engine ? std::string() : engine.error().message();
  };
  EXPECT_SAYS(chosen({"a.onnx"}), "the engine onnxruntime is not installed");
  EXPECT_SAYS(chosen({"dir.x/A.TFLITE"}), "the engine tensorflow-lite is not installed");
  EXPECT_SAYS(chosen({"a.pt"}), "the engine pytorch is not installed");
  EXPECT_SAYS(chosen({"a.so", "b.nb"}), "Weir has no engine vivante");
  EXPECT_SAYS(chosen({"a.prototxt", "b.caffemodel"}), "the engine caffe is not installed");
  EXPECT_SAYS(chosen({"a.caffemodel"}), "the engine caffe is not installed");
  EXPECT_SAYS(chosen({"a.cfg", "a.weights"}), "the engine darknet is not installed");
  EXPECT_SAYS(chosen({"a.weights"}), "fix: apt-get install libopencv-dnn-dev && make build");
  EXPECT_SAYS(chosen({"a.pb"}), "the engine tensorflow is not installed");
  EXPECT_SAYS(chosen({"a.pb", "b.pb"}), "Weir has no engine caffe2");
  for (const char* name : {"model", "model.", "a.jpg"}) {
    const auto path = (folder_ / name).string();
    std::ofstream(path) << "x";
    EXPECT_SAYS(chosen({path}), "no engine can be selected for this model");
  }
  for (const auto& paths :
       std::vector<std::vector<std::string>>{{}, {"a.onnx", "b.onnx"}, {"a.so", "b.nb", "c.nb"}})
    EXPECT_SAYS(chosen(paths), "no engine can be selected for this model");
}

TEST_F(ModuleLibraryTest, SaysThatTheModelIsAFolderOrIsNotThere) {
  search(folder_.string());
  const auto refused = [&](const fs::path& path) {
    const auto engine = library_.engine_for_model(std::vector<std::string>{path.string()});
    return engine ? std::string() : engine.error().message();
  };
  EXPECT_SAYS(refused(folder_), "WEIR-3003: the model is a folder\n  offered: " + folder_.string());
  EXPECT_SAYS(refused(folder_ / "none"), "WEIR-3003: the model file does not exist");
  EXPECT_SAYS(refused(folder_ / "none.jpg"), "WEIR-3003: the model file does not exist");
}

TEST_F(ModuleLibraryTest, SuggestsFilesAndNoFolders) {
  search(folder_.string());
  fs::create_directory(folder_ / "models");
  const auto refused = [&] {
    return library_.engine_for_model(std::vector<std::string>{(folder_ / "model").string()})
        .error()
        .message();
  };
  EXPECT_EQ(refused().find("did you mean"), std::string::npos) << refused();
  EXPECT_EQ(refused().find("fix:"), std::string::npos) << refused();
  std::ofstream(folder_ / "model1") << "x";
  EXPECT_SAYS(refused(), "did you mean model1?");
  std::ofstream(folder_ / "libnnstreamer_customfilter_scaler.so") << "x";
  const auto missing = library_.engine_for_model(
      std::vector<std::string>{(folder_ / "libnnstreamer_customfilter_passthrough.so").string()});
  EXPECT_EQ(missing.error().message().find("did you mean"), std::string::npos)
      << "a common prefix is no likeness: " << missing.error().message();
  EXPECT_SAYS(refused(), "fix: model=" + (folder_ / "model1").string());
}

TEST_F(ModuleLibraryTest, ListsTheDecoders) {
  search(folder_.string());
  write("libweir-decoder-image_labeling.so", "");
  const auto decoder = library_.decoder("image_labelling");
  ASSERT_FALSE(decoder);
  EXPECT_EQ(decoder.error().code, Code::DECODER_UNKNOWN);
  EXPECT_SAYS(decoder.error().message(), "mode=image_labeling");
}

TEST_F(ModuleLibraryTest, DecodersAndConvertersThatAreMissingComeWithTheirInstallCommand) {
  search(folder_.string());
  EXPECT_SAYS(library_.decoder("protobuf").error().message(),
              "fix: apt-get install libprotobuf-dev && make build");
  EXPECT_SAYS(library_.decoder("flexbuf").error().message(),
              "fix: apt-get install libflatbuffers-dev");
  EXPECT_SAYS(library_.converter("python3").error().message(),
              "fix: apt-get install libpython3-dev");
  EXPECT_SAYS(library_.converter("onnxruntime").error().message(),
              "fix: gst-inspect-1.0 tensor_converter");
}

}  // namespace module_library_test
}  // namespace weir::infer
