// Tests of the lowering cache: what is kept, what is not trusted, and that its failures do no harm.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "lowering/lowering_cache.hpp"

#include <sys/stat.h>

#include <filesystem>
#include <fstream>

#include "lowering/lowering_test_support.hpp"
#include "says.hpp"

namespace weir::engine_test {
namespace lowering_cache_test {

namespace fs = std::filesystem;
using engine::LoweringCache;

class LoweringCacheFiles : public ::testing::Test {
 protected:
  void SetUp() override { setenv("XDG_CACHE_HOME", folder_.path("cache").c_str(), 1); }
  static LoweringCache cache_of(const std::string& text) {
    return LoweringCache(std::as_bytes(std::span(text)));
  }
  // The complaint of a load that returns nothing; "it was loaded" otherwise.
  static std::string complaint(const LoweringCache& cache) {
    std::string out;
    return cache.load(&out) ? "it was loaded" : out;
  }
  TemporaryFolder folder_;
};

TEST_F(LoweringCacheFiles, KeysAGraphByItsInputs) {
  std::string none;
  EXPECT_FALSE(cache_of("a").load(&none));
  EXPECT_EQ(none, "") << "what is not there is no complaint";
  ASSERT_TRUE(cache_of("a").store("graph a"));
  EXPECT_EQ(cache_of("a").load(&none), "graph a");
  EXPECT_FALSE(cache_of("b").load(&none));
  ASSERT_TRUE(cache_of("a").store("graph a again"));
  EXPECT_EQ(cache_of("a").load(&none), "graph a again");
  // The file name is the digest, and no other file stays in the folder.
  EXPECT_EQ(fs::path(cache_of("abc").path()).filename(),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad.onnx");
  const fs::directory_iterator files(fs::path(cache_of("a").path()).parent_path());
  EXPECT_EQ(std::distance(begin(files), end(files)), 1);
  EXPECT_EQ(fs::status(cache_of("a").path()).permissions(),
            fs::perms::owner_read | fs::perms::owner_write);
}

TEST_F(LoweringCacheFiles, EveryChangeAndTruncationIsDetected) {
  const auto cache = cache_of("a");
  ASSERT_TRUE(cache.store("graph"));
  const auto whole = read_bytes(cache.path());
  ASSERT_EQ(whole.size(), 8 + 32 + 5u);
  for (size_t at = 0; at < whole.size(); ++at) {
    auto changed = whole;
    changed[at] ^= std::byte{1};
    const auto put = [&](const std::vector<std::byte>& bytes) {
      std::ofstream(cache.path(), std::ios::binary)
          .write(reinterpret_cast<const char*>(bytes.data()),
                 static_cast<std::streamsize>(bytes.size()));
    };
    put(changed);
    EXPECT_EQ(complaint(cache), cache.path() + " was truncated or changed") << at;
    changed.assign(whole.begin(), whole.begin() + static_cast<int64_t>(at));
    put(changed);
    EXPECT_EQ(complaint(cache), cache.path() + " was truncated or changed") << at;
  }
}

TEST_F(LoweringCacheFiles, FilesWritableByOthersAreNotUsed) {
  const auto cache = cache_of("a");
  ASSERT_TRUE(cache.store("graph"));
  const std::string folder = fs::path(cache.path()).parent_path();
  ASSERT_EQ(chmod(cache.path().c_str(), 0620), 0);
  EXPECT_EQ(complaint(cache), cache.path() + " is accessible to other users");
  ASSERT_EQ(chmod(cache.path().c_str(), 0600), 0);
  EXPECT_EQ(complaint(cache), "it was loaded");
  ASSERT_EQ(chmod(folder.c_str(), 0777), 0);
  EXPECT_EQ(complaint(cache), folder + " is accessible to other users");
  EXPECT_FALSE(cache.store("graph")) << "nor is anything put there";
}

TEST_F(LoweringCacheFiles, LinksAndFoldersAreNotFollowed) {
  const auto cache = cache_of("a");
  ASSERT_TRUE(cache.store("graph"));
  fs::rename(cache.path(), folder_.path("elsewhere"));
  fs::create_symlink(folder_.path("elsewhere"), cache.path());
  EXPECT_SAYS(complaint(cache), cache.path());
  fs::remove(cache.path());
  fs::create_directory(cache.path());
  EXPECT_EQ(complaint(cache), cache.path() + " is accessible to other users");
  EXPECT_FALSE(cache.store("graph"));
}

TEST_F(LoweringCacheFiles, WithoutAFolderThereIsNone) {
  setenv("XDG_CACHE_HOME", "relative", 1);
  const std::string home = std::getenv("HOME") ? std::getenv("HOME") : "";
  setenv("HOME", folder_.path("home").c_str(), 1);
  EXPECT_TRUE(cache_of("a").path().starts_with(folder_.path("home") + "/.cache/weir/lowered/"));
  unsetenv("HOME");
  EXPECT_EQ(cache_of("a").path(), "");
  EXPECT_FALSE(cache_of("a").store("graph"));
  EXPECT_EQ(complaint(cache_of("a")), "");
  setenv("HOME", home.c_str(), 1);
}

class LoweringCacheOfModels : public LoweringTest {
 protected:
  static std::vector<std::byte> model() {
    return TfliteBuilder()
        .input("x", kTfUint8, {1, 4})
        .quantized({{0.5f}, {10}})
        .constant<int32_t>("shape", kTfInt32, {2}, {2, 2})
        .output("y", kTfUint8, {2, 2})
        .quantized({{0.5f}, {10}})
        .node(kOpReshape, {"x", "shape"}, {"y"})
        .bytes();
  }
  // The path of the only cached file; "" when there is none.
  std::string kept() const {
    std::error_code missing;
    for (const auto& entry : fs::directory_iterator(folder_.path("cache/weir/lowered"), missing))
      return entry.path();
    return "";
  }
  void expect_runs(const Options& options, const std::string& words) {
    take_log();
    auto opened = open(model(), options);
    ASSERT_TRUE(opened) << opened.error().message();
    const std::string text = logged();
    EXPECT_SAYS(text, words);
    const auto y = (*opened)->invoke({make_tensor<uint8_t>(WEIR_UINT8, {1, 4}, {1, 2, 3, 4})});
    ASSERT_TRUE(y) << y.error().message();
    EXPECT_EQ((*y)[0].values<uint8_t>(), (std::vector<uint8_t>{1, 2, 3, 4}));
  }
};

TEST_F(LoweringCacheOfModels, TheSecondOpenReadsTheGraphFromDisk) {
  expect_runs(kLowered, "ONNX Runtime runs " + folder_.path("model.bin") + "\n");
  ASSERT_NE(kept(), "");
  expect_runs(kLowered, "lowered before");
}

TEST_F(LoweringCacheOfModels, AChangedGraphIsReportedAndGeneratedAgain) {
  expect_runs(kLowered, "ONNX Runtime runs");
  auto bytes = read_bytes(kept());
  bytes[bytes.size() / 2] ^= std::byte{4};
  std::ofstream(kept(), std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
  expect_runs(kLowered, "was truncated or changed; the graph is generated again");
  expect_runs(kLowered, "lowered before");
}

TEST_F(LoweringCacheOfModels, NothingIsWrittenWhereItIsTurnedOff) {
  expect_runs({{"Lowering", "onnxruntime"}, {"LoweringCache", "false"}}, "ONNX Runtime runs");
  EXPECT_EQ(kept(), "");
  const auto error = error_of(model(), {{"Lowering", "onnxruntime"}, {"LoweringCache", "often"}});
  EXPECT_EQ(error.code, Code::OPTION_VALUE);
  EXPECT_EQ(error.offered, "LoweringCache:often");
}

TEST_F(LoweringCacheOfModels, AFolderThatCannotBeCreatedIsIgnored) {
  folder_.write("cache", {std::byte{'x'}});
  expect_runs(kLowered, "could not be stored");
}

}  // namespace lowering_cache_test
}  // namespace weir::engine_test
