// Tests the engines custom and cpp: files and classes that are found or rejected.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "core/custom/process_bound.hpp"
#include "core/infer/model/model.hpp"
#include "core/infer/module/host.hpp"
#include "core/infer/module/module_library.hpp"
#include "says.hpp"
#include "weir/custom_filter.h"
#include "weir/engine.hpp"

namespace weir::custom {
namespace custom_engines_test {

namespace fs = std::filesystem;

Result<std::shared_ptr<infer::Model>> opened(const std::string& framework,
                                             std::vector<std::string> paths) {
  const auto engine = infer::ModuleLibrary::instance().engine(framework);
  if (!engine) return engine.error();
  infer::OpenOptions options;
  options.paths = std::move(paths);
  options.options = {{"factor", "3"}};
  return infer::Model::open(**engine, options);
}
std::string refusal(const std::string& framework, std::vector<std::string> paths) {
  const auto model = opened(framework, std::move(paths));
  return model ? "it was opened" : model.error().message();
}

class CustomEngines : public ::testing::Test {
 protected:
  void SetUp() override {
    const char* modules = std::getenv("WEIR_TEST_MODULES");
    if (!modules) GTEST_SKIP() << "WEIR_TEST_MODULES is not set: run it with meson test";
    modules_ = modules;
    folder_ = fs::path(testing::TempDir()) / "weir-custom-engines-test";
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  std::string module(const std::string& name) const {
    return modules_ + "/libweir-engine-" + name + ".so";
  }
  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return (folder_ / name).string();
  }

  std::string modules_;
  fs::path folder_;
};

// 3 * x of one frame.
float scaled(const std::shared_ptr<infer::Model>& model, float x) {
  auto session = infer::Session::create(model);
  EXPECT_TRUE(session);
  float y = 0;
  weir_tensor in{}, out{};
  in.data = &x;
  out.data = &y;
  in.bytes = in.capacity = out.bytes = out.capacity = sizeof x;
  in.info = out.info = tensor_info("x", WEIR_FLOAT32, {1});
  weir_frame in_frame{}, out_frame{};
  in_frame.struct_size = out_frame.struct_size = sizeof in_frame;
  in_frame.n_tensors = out_frame.n_tensors = 1;
  in_frame.tensors = &in;
  out_frame.tensors = &out;
  const auto kept = (*session)->invoke(in_frame, out_frame);
  EXPECT_TRUE(kept && *kept);
  return y;
}

class Scaled {
 public:
  explicit Scaled(const OpenRequest& request) : paths_(request.paths.size()) {
    factor_ = std::stof(std::string(request.options.get("factor").value_or("1")));
  }
  std::span<const weir_tensor_info> inputs() const { return {&info_, 1}; }
  std::span<const weir_tensor_info> outputs() const { return {&info_, 1}; }
  bool invoke(std::span<const weir_tensor> in, std::span<weir_tensor> out) {
    elements<float>(out[0])[0] = factor_ * elements<const float>(in[0])[0];
    return true;
  }
  static constexpr uint64_t kFlags = WEIR_ENGINE_NEEDS_NO_MODEL;

 private:
  size_t paths_;
  float factor_;
  weir_tensor_info info_ = tensor_info("x", WEIR_FLOAT32, {1});
};
const weir_module* scaled_entry(const weir_host* host) {
  if (!accept_host(host)) return nullptr;
  static const weir_engine table = engine_table<Scaled>("scaled", "1", "", "");
  static const weir_engine* const tables[] = {&table, nullptr};
  static const weir_module module{sizeof(weir_module),
                                  WEIR_ABI_MAJOR,
                                  WEIR_ABI_MINOR,
                                  tables,
                                  nullptr,
                                  nullptr,
                                  nullptr,
                                  nullptr};
  return &module;
}

TEST_F(CustomEngines, ClassOfTheProgramOpensAModelForEachUser) {
  ASSERT_EQ(weir_filter_class_register("Scaled", scaled_entry, nullptr), WEIR_OK);
  const auto first = opened("cpp", {"Scaled"}), second = opened("cpp", {"Scaled"});
  ASSERT_TRUE(first && second) << first.error().message();
  EXPECT_NE((*first)->handle(), (*second)->handle());
  EXPECT_EQ(weir_filter_class_unregister("Scaled"), WEIR_OK);
  EXPECT_EQ(scaled(*first, 5), 15) << "what is open goes on";
  EXPECT_EQ(weir_filter_class_unregister("Scaled"), -WEIR_CALLBACK_UNKNOWN);
}

TEST_F(CustomEngines, ClassOfALibraryIsFoundByItsName) {
  const auto model = opened("cpp", {"scaling", module("scaling")});
  ASSERT_TRUE(model) << model.error().message();
  EXPECT_EQ(scaled(*model, 2), 6);
}

TEST_F(CustomEngines, UnknownClassIsReported) {
  ASSERT_EQ(weir_filter_class_register("Scaled", scaled_entry, nullptr), WEIR_OK);
  const auto near = refusal("cpp", {"Scale"});
  EXPECT_SAYS(near, "WEIR-5002: no filter class has this name");
  EXPECT_SAYS(near, "offered: framework=cpp model=Scale");
  EXPECT_SAYS(near, "needed: one of: Scaled");
  EXPECT_SAYS(near, "did you mean Scaled?");
  EXPECT_SAYS(near, "fix: framework=cpp model=Scaled");
  EXPECT_SAYS(refusal("cpp", {"other", module("scaling")}), "or an engine of this name in");
  EXPECT_EQ(weir_filter_class_unregister("Scaled"), WEIR_OK);
  EXPECT_SAYS(refusal("cpp", {"Far"}), "fix: framework=cpp model=Far,/path/to/lib.so");
  EXPECT_SAYS(refusal("cpp", {}), "offered: 0 parts in model=");
  EXPECT_SAYS(refusal("cpp", {"a", "b", "c"}), "needed: model=NAME or model=NAME,lib.so");
  EXPECT_SAYS(refusal("cpp", {"a", "/nowhere/lib.so"}), "WEIR-3003");
}

TEST_F(CustomEngines, InvalidClassIsRejected) {
  const auto refused = [](const char* name, auto entry) {
    weir_error* error = nullptr;
    EXPECT_LT(weir_filter_class_register(name, entry, &error), 0);
    const std::unique_ptr<weir_error> owned(error);
    return owned ? owned->error.message() : "";
  };
  using Entry = const weir_module* (*)(const weir_host*);
  EXPECT_SAYS(refused("", scaled_entry), "its name");
  EXPECT_SAYS(refused("a,b", scaled_entry), "a name without a comma");
  EXPECT_SAYS(refused("any", scaled_entry), "that is not auto or any");
  EXPECT_SAYS(refused(nullptr, scaled_entry), "its name");
  EXPECT_SAYS(refused("x", Entry{}), "offered: no entry");
  EXPECT_SAYS(refused("x", Entry{[](const weir_host*) -> const weir_module* { return nullptr; }}),
              "weir_module_entry returned NULL");
  ASSERT_EQ(weir_filter_class_register("x", scaled_entry, nullptr), WEIR_OK);
  EXPECT_SAYS(refused("x", scaled_entry), "another class has this name");
  EXPECT_EQ(weir_filter_class_unregister("x"), WEIR_OK);
}

TEST_F(CustomEngines, FileOfWeirsOwnInterfaceIsTheFilter) {
  const auto any = write("any.model", "x");
  const auto model = opened("custom", {module("scaling"), any});
  ASSERT_TRUE(model) << model.error().message();
  EXPECT_EQ(scaled(*model, 2), 6);
  EXPECT_TRUE(opened("custom", {module("scaling"), any})) << "a second time";
  EXPECT_EQ(infer::ModuleLibrary::instance().choose_engine(std::vector{module("scaling")})->engine,
            "custom")
      << "found by its ending";
}

TEST_F(CustomEngines, EngineReportsThatItNeedsAModel) {
  const auto text = refusal("custom", {module("scaling")});
  EXPECT_SAYS(text, "WEIR-3003: the engine in this file needs a model file");
  EXPECT_SAYS(text, "scaling.so,/path/to/the/model");
}

TEST_F(CustomEngines, FileWithoutFilterIsRejectedWithoutLoadingIt) {
  EXPECT_SAYS(refusal("custom", {}), "WEIR-3003: no file is named");
  EXPECT_SAYS(refusal("custom", {(folder_ / "none.so").string()}), "the model file does not exist");
  EXPECT_SAYS(refusal("custom", {folder_.string()}), "the model is a folder");
  EXPECT_SAYS(refusal("custom", {write("text.so", "hello")}), "no symbol weir_module_entry");
  EXPECT_SAYS(refusal("custom", {write("plain.so",
                                       "\x7f"
                                       "ELF")}),
              "and no NNStreamer_custom");
  EXPECT_SAYS(refusal("custom", {write("sub.so",
                                       "\x7f"
                                       "ELF nnstreamer_filter_probe")}),
              "fix: framework=NAME, if the sub-plugin");
  EXPECT_SAYS(refusal("custom", {write("empty.so", "")}), "no symbol weir_module_entry");
  EXPECT_SAYS(refusal("custom", {module("bad-symbol")}), "no symbol weir_module_entry");
  const auto lying = refusal("custom", {write("lying.so",
                                              "\x7f"
                                              "ELF weir_module_entry")});
  EXPECT_SAYS(lying, "WEIR-3007");
  EXPECT_SAYS(lying, "needed: a shared object for this machine");
}

TEST_F(CustomEngines, SymbolNameAcrossAReadBoundaryIsFound) {
  const std::string far(size_t{1 << 20} - 5, 'x');
  EXPECT_SAYS(refusal("custom", {write("far.so", far + "weir_module_entry")}),
              "needed: a shared object for this machine");
}

TEST_F(CustomEngines, FilterOfNNStreamerNeedsTheLibraryForIt) {
  setenv("WEIR_NNSTREAMER_LIBRARY", (folder_ / "none.so").c_str(), 1);
  const auto theirs = write("theirs.so",
                            "\x7f"
                            "ELF...NNStreamer_custom...");
  const auto text = refusal("custom", {theirs});
  EXPECT_SAYS(text, "WEIR-3007: the library with the functions that sub-plugins for NNStreamer");
  EXPECT_SAYS(text, "none.so");
  EXPECT_SAYS(refusal("cpp", {"Name", theirs}), "framework=custom model=" + theirs);
  unsetenv("WEIR_NNSTREAMER_LIBRARY");
}

TEST_F(CustomEngines, SymbolicLinkIsRejectedWithItsTarget) {
  fs::create_symlink(module("scaling"), folder_ / "link.so");
  const auto text = refusal("custom", {(folder_ / "link.so").string()});
  EXPECT_SAYS(text, "WEIR-3007: a filter's file must not be a symbolic link");
  EXPECT_SAYS(text, "fix: model=" + fs::canonical(module("scaling")).string());
}

TEST_F(CustomEngines, SymbolicLinkIsAcceptedIfTheConfigurationAllowsIt) {
  fs::create_symlink(module("scaling"), folder_ / "link.so");
  setenv("WEIR_FILTER_ENABLE_SYMLINK", "true", 1);
  const auto model = opened("custom", {(folder_ / "link.so").string(), write("any.model", "x")});
  unsetenv("WEIR_FILTER_ENABLE_SYMLINK");
  ASSERT_TRUE(model) << model.error().message();
  EXPECT_EQ(scaled(*model, 2), 6);
}

// The library exists but does not register a filter of its name.
TEST_F(CustomEngines, NameIsLookedForInTheFoldersOfFilters) {
  fs::copy_file(module("scaling"), folder_ / "named.so");
  write("broken.so", "no library");
  setenv("WEIR_FILTER_PATH", folder_.c_str(), 1);
  const auto found = refusal("custom-easy", {"named"}), broken = refusal("custom-easy", {"broken"});
  const std::vector<std::string> named{"named"}, other{"other"};
  const bool bound = bound_to_this_process("custom-easy", named).has_value();
  const bool other_bound = bound_to_this_process("custom-easy", other).has_value();
  unsetenv("WEIR_FILTER_PATH");
  EXPECT_SAYS(found, "no filter is registered under this name");
  EXPECT_SAYS(broken, "broken.so contains no filter");
  EXPECT_FALSE(bound) << "a worker process finds it too";
  EXPECT_TRUE(other_bound);
}

TEST_F(CustomEngines, FaultyModulesAreRejectedLikeOthers) {
  for (const auto& [kind, words] : std::vector<std::pair<std::string, std::string>>{
           {"nothing", "weir_module_entry returned NULL"},
           {"version", "offered: ABI version 2"},
           {"engine-functions", "without all of its functions"},
           {"empty", "the file has no engine of its own"}})
    EXPECT_SAYS(refusal("custom", {module("bad-" + kind)}), words);
}

TEST(OtherProcess, RunsFiltersOfALibrary) {
  const std::vector<std::string> name{"x"}, library{"x", "lib.so"};
  EXPECT_FALSE(bound_to_this_process("custom", library));
  EXPECT_FALSE(bound_to_this_process("onnxruntime", name));
  EXPECT_FALSE(bound_to_this_process("cpp", library));
  const auto function = bound_to_this_process("custom-easy", name);
  ASSERT_TRUE(function);
  EXPECT_SAYS(function->message(), "a function of this program cannot run in another process");
  EXPECT_SAYS(function->message(), "fix: tensor_filter framework=custom-easy model=x isolate=none");
  const auto bound = bound_to_this_process("cpp", name);
  ASSERT_TRUE(bound);
  EXPECT_SAYS(bound->message(), "fix: tensor_filter framework=cpp model=x,/path/to/lib.so");
}

}  // namespace custom_engines_test
}  // namespace weir::custom
