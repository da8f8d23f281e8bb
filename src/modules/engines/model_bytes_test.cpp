// Reading the model that a weir_open names.
#include "model_bytes.hpp"

#include <gtest/gtest.h>

#include "engine_test_host.hpp"

namespace weir::engine {
namespace {

Result<ModelBytes> read(const std::vector<std::string>& paths) {
  std::vector<const char*> pointers;
  for (const auto& path : paths) pointers.push_back(path.c_str());
  weir_open request{};
  request.n_models = static_cast<uint32_t>(pointers.size());
  request.paths = pointers.data();
  return read_model(request);
}

Code code_of(const Result<ModelBytes>& result) {
  return result ? Code::INTERNAL : result.error().code;
}

TEST(ModelBytes, AreTheFilesBytes) {
  const engine_test::TemporaryFolder folder;
  const std::vector<std::byte> bytes{std::byte{1}, std::byte{0}, std::byte{255}};
  const auto read_back = read({folder.write("model", bytes)});
  ASSERT_TRUE(read_back) << read_back.error().message();
  EXPECT_EQ(std::vector<std::byte>(read_back->bytes.begin(), read_back->bytes.end()), bytes);
  EXPECT_EQ(read_back->name(), folder.path("model"));
}

TEST(ModelBytes, MayBeTheCallersOwn) {
  const char bytes[] = "model";
  weir_open request{};
  request.bytes = bytes;
  request.n_bytes = 5;
  const auto result = read_model(request);
  ASSERT_TRUE(result);
  EXPECT_EQ(static_cast<const void*>(result->bytes.data()), bytes);
  EXPECT_EQ(result->bytes.size(), 5u);
}

TEST(ModelBytes, AMissingFileAFolderAndADeviceAreRefused) {
  EXPECT_EQ(code_of(read({"/no/such/file"})), Code::MODEL_NOT_FOUND);
  EXPECT_EQ(code_of(read({"/tmp"})), Code::MODEL_NOT_FOUND);
  EXPECT_EQ(code_of(read({"/dev/zero"})), Code::MODEL_NOT_FOUND);
}

TEST(ModelBytes, AnEmptyFileIsRefused) {
  const engine_test::TemporaryFolder folder;
  EXPECT_EQ(code_of(read({folder.write("empty", {})})), Code::MODEL_INVALID);
}

TEST(ModelBytes, ExactlyOneModelIsNeeded) {
  EXPECT_EQ(code_of(read({})), Code::SPEC_MISMATCH);
  EXPECT_EQ(code_of(read({"a", "b"})), Code::SPEC_MISMATCH);
}

}  // namespace
}  // namespace weir::engine
