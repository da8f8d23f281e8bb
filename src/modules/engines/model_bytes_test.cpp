// Tests of reading the model that a weir_open names.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "model_bytes.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <span>

#include "engine_host_test_support.hpp"
#include "model_source.hpp"
#include "says.hpp"

namespace weir::engine {
namespace model_bytes_test {

Result<ModelBytes> read(const std::vector<std::string>& paths) {
  std::vector<const char*> pointers;
  for (const auto& path : paths) pointers.push_back(path.c_str());
  weir_open request{};
  request.n_models = static_cast<uint32_t>(pointers.size());
  request.paths = pointers.data();
  return read_model(request);
}

Code get_code(const Result<ModelBytes>& result) {
  return result ? Code::INTERNAL : result.error().code;
}

TEST(ModelBytes, EqualTheFile) {
  const engine_test::TemporaryFolder folder;
  const std::vector<std::byte> bytes{std::byte{1}, std::byte{0}, std::byte{255}};
  const auto read_back = read({folder.write("model", bytes)});
  ASSERT_TRUE(read_back) << read_back.error().message();
  EXPECT_EQ(std::vector<std::byte>(read_back->bytes.begin(), read_back->bytes.end()), bytes);
  EXPECT_EQ(read_back->name(), folder.path("model"));
}

TEST(ModelBytes, CanBelongToTheCaller) {
  const char bytes[] = "model";
  weir_open request{};
  request.bytes = bytes;
  request.n_bytes = 5;
  const auto result = read_model(request);
  ASSERT_TRUE(result);
  EXPECT_EQ(static_cast<const void*>(result->bytes.data()), bytes);
  EXPECT_EQ(result->bytes.size(), 5u);
}

TEST(ModelBytes, AMissingFileAFolderAndADeviceAreRejected) {
  EXPECT_EQ(get_code(read({"/no/such/file"})), Code::MODEL_NOT_FOUND);
  EXPECT_EQ(get_code(read({"/tmp"})), Code::MODEL_NOT_FOUND);
  EXPECT_EQ(get_code(read({"/dev/zero"})), Code::MODEL_NOT_FOUND);
}

TEST(ModelBytes, AnEmptyFileIsRejected) {
  const engine_test::TemporaryFolder folder;
  EXPECT_EQ(get_code(read({folder.write("empty", {})})), Code::MODEL_INVALID);
}

TEST(ModelBytes, ExactlyOneModelIsNeeded) {
  EXPECT_EQ(get_code(read({})), Code::SPEC_MISMATCH);
  EXPECT_EQ(get_code(read({"a", "b"})), Code::SPEC_MISMATCH);
}

// A sparse file of `size` bytes: it uses no disk space and reads as zeros.
std::string sparse_file(const engine_test::TemporaryFolder& folder, uint64_t size) {
  const auto path = folder.write("sparse", {std::byte{0}});
  std::filesystem::resize_file(path, size);
  return path;
}

TEST(ModelBytes, AFileAboveTheLimitIsRejectedWithoutReadingIt) {
  const engine_test::TemporaryFolder folder;
  const char* paths[] = {nullptr};
  weir_open request{};
  request.n_models = 1;
  request.paths = paths;
  const auto path = sparse_file(folder, uint64_t{1} << 40);
  paths[0] = path.c_str();
  const auto result = read_model(request);
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, Code::MODEL_UNSUPPORTED);
  EXPECT_SAYS(result.error().message(), "the model file is larger than its format or engine");
  EXPECT_SAYS(result.error().message(), "sparse: 1099511627776 bytes");
  EXPECT_SAYS(result.error().message(), "at most 2147483647 bytes");
}

TEST(ModelBytes, AFileWithADifferentHeaderIsRejectedWithoutReadingIt) {
  const engine_test::TemporaryFolder folder;
  const auto path = sparse_file(folder, (uint64_t{1} << 31) - 1);
  const char* paths[] = {path.c_str()};
  weir_open request{};
  request.n_models = 1;
  request.paths = paths;
  const uint64_t before = engine_test::peak_resident_bytes();
  const auto result = read_model(
      request, {.check_head = [](std::span<const std::byte> head) {
        return head.size() == kModelHead && head[0] == std::byte{0}
                   ? Status(
                         Error{.code = Code::MODEL_INVALID, .what = "no model", .offered = "zeros"})
                   : ok();
      }});
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().offered, path + ": zeros");
  EXPECT_LT(engine_test::peak_resident_bytes(), before + (uint64_t{1} << 28));
}

TEST(ModelBytes, AFileTruncatedDuringReadingIsRejected) {
  const engine_test::TemporaryFolder folder;
  static std::string path;
  path = folder.write("cut", std::vector<std::byte>(100000));
  const char* paths[] = {path.c_str()};
  weir_open request{};
  request.n_models = 1;
  request.paths = paths;
  const auto result = read_model(request, {.check_head = [](std::span<const std::byte>) -> Status {
                                   std::filesystem::resize_file(path, 5000);
                                   return ok();
                                 }});
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, Code::MODEL_INVALID);
  EXPECT_SAYS(result.error().message(), "the model file was truncated while it was read");
  EXPECT_SAYS(result.error().message(), "100000 bytes");
}

TEST(ModelBytes, AFifoWithoutAWriterIsRejectedAtOnce) {
  const engine_test::TemporaryFolder folder;
  ASSERT_EQ(mkfifo(folder.path("fifo").c_str(), 0600), 0);
  EXPECT_EQ(get_code(read({folder.path("fifo")})), Code::MODEL_NOT_FOUND);
}

TEST(ModelSource, ReturnsTheBytesOfASmallFileThatItKeptAfterTheFileHasChanged) {
  const engine_test::TemporaryFolder folder;
  const std::vector<std::byte> before(3, std::byte{1}), after(3, std::byte{2});
  const std::string path = folder.write("model", before);
  const char* paths[] = {path.c_str()};
  weir_open request{};
  request.n_models = 1;
  request.paths = paths;
  auto read_twice = ModelSource::open(request), kept = ModelSource::open(request);
  ASSERT_TRUE(read_twice && kept);
  ASSERT_TRUE(kept->keep_small());
  folder.write("model", after);
  std::vector<std::byte> bytes(3);
  ASSERT_TRUE(kept->read(0, bytes));
  EXPECT_EQ(bytes, before);
  EXPECT_EQ(kept->name(), path);
  const ModelSource moved(*std::move(kept));
  ASSERT_TRUE(moved.read(1, std::span(bytes).first(2)));
  EXPECT_EQ(bytes, before);
  ASSERT_TRUE(read_twice->read(0, bytes));
  EXPECT_EQ(bytes, after);
}

TEST(ModelSource, ReportsThatASmallFileWasTruncatedBeforeItWasKept) {
  const engine_test::TemporaryFolder folder;
  const std::string path = folder.write("model", std::vector<std::byte>(3));
  const char* paths[] = {path.c_str()};
  weir_open request{};
  request.n_models = 1;
  request.paths = paths;
  auto source = ModelSource::open(request);
  ASSERT_TRUE(source);
  folder.write("model", std::vector<std::byte>(2));
  EXPECT_FALSE(source->keep_small());
}

TEST(ModelSource, DoesNotKeepALargeFile) {
  const engine_test::TemporaryFolder folder;
  const std::string path = folder.write("model", std::vector<std::byte>(1));
  std::filesystem::resize_file(path, ModelSource::kKeptBytes + 1);
  const char* paths[] = {path.c_str()};
  weir_open request{};
  request.n_models = 1;
  request.paths = paths;
  auto source = ModelSource::open(request);
  ASSERT_TRUE(source);
  EXPECT_TRUE(source->keep_small());
  EXPECT_TRUE(source->memory().empty());
}

TEST(ModelSource, ReadsOnlyWithinTheFile) {
  const engine_test::TemporaryFolder folder;
  const auto path = folder.write("ten", std::vector<std::byte>(10, std::byte{7}));
  const char* paths[] = {path.c_str()};
  weir_open request{};
  request.n_models = 1;
  request.paths = paths;
  const auto file = ModelSource::open(request);
  ASSERT_TRUE(file);
  const std::vector<std::byte> bytes(10, std::byte{7});
  const ModelSource memory((std::span<const std::byte>(bytes)));
  for (const ModelSource* source : {&*file, &memory}) {
    EXPECT_EQ(source->size(), 10u);
    std::byte part[4]{};
    EXPECT_TRUE(source->read(6, part));
    EXPECT_EQ(part[3], std::byte{7});
    EXPECT_TRUE(source->read(10, {}));
    EXPECT_FALSE(source->read(7, part));
    EXPECT_FALSE(source->read(UINT64_MAX - 1, part));
  }
}

}  // namespace model_bytes_test
}  // namespace weir::engine
