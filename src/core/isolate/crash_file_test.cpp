// Tests saved frames by reading them with the parser of flexible streams.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/isolate/crash_file.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <vector>

#include "core/tensor/tensor_header.hpp"
#include "says.hpp"

namespace weir::isolate {
namespace crash_file_test {

namespace fs = std::filesystem;

class CrashFileTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = testing::TempDir() + "weir-crash-file-" + std::to_string(getpid());
    fs::create_directories(folder_);
    std::iota(first_.begin(), first_.end(), uint8_t{1});
    add(first_.data(), WEIR_UINT8, {2, 3});
    add(second_.data(), WEIR_FLOAT32, {2});
    frame_.n_tensors = 2;
    frame_.tensors = tensors_.data();
  }
  void TearDown() override { fs::remove_all(folder_); }
  void add(void* data, uint32_t type, const std::vector<int64_t>& shape) {
    weir_tensor tensor{};
    tensor.data = data;
    tensor.info.type = type;
    tensor.info.rank = static_cast<uint32_t>(shape.size());
    std::copy(shape.begin(), shape.end(), tensor.info.shape);
    tensor.bytes = type == WEIR_UINT8 ? 6 : 8;
    tensors_.push_back(tensor);
  }
  static std::vector<std::byte> content(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    std::vector<char> bytes(std::istreambuf_iterator<char>(file), {});
    const auto all = std::as_bytes(std::span(bytes));
    return {all.begin(), all.end()};
  }

  std::string folder_;
  std::vector<uint8_t> first_ = std::vector<uint8_t>(6);
  std::vector<float> second_{1.5F, -2.0F};
  std::vector<weir_tensor> tensors_;
  weir_frame frame_{};
};

TEST_F(CrashFileTest, HoldsEveryTensorAfterItsHeader) {
  const auto file = save_frame(folder_, frame_);
  ASSERT_TRUE(file);
  const auto bytes = content(file->path);
  ASSERT_EQ(bytes.size(), 2 * kTensorHeaderBytes + 6 + 8);
  EXPECT_EQ(file->bytes, bytes.size());
  const auto first = read_tensor_chunk(bytes);
  ASSERT_TRUE(first);
  EXPECT_EQ(first->spec.to_string(), "uint8 3:2");
  EXPECT_EQ(std::memcmp(bytes.data() + kTensorHeaderBytes, first_.data(), 6), 0);
  const auto rest = std::span(bytes).subspan(kTensorHeaderBytes + 6);
  const auto second = read_tensor_chunk(rest);
  ASSERT_TRUE(second);
  EXPECT_EQ(second->spec.to_string(), "float32 2");
  EXPECT_EQ(std::memcmp(rest.data() + kTensorHeaderBytes, second_.data(), 8), 0);
  struct stat facts {};
  ASSERT_EQ(stat(file->path.c_str(), &facts), 0);
  EXPECT_EQ(facts.st_mode & 0777, 0600u) << "frames may be private";
}

TEST_F(CrashFileTest, NeverOverwritesAFile) {
  const auto a = save_frame(folder_, frame_), b = save_frame(folder_, frame_);
  ASSERT_TRUE(a && b);
  EXPECT_NE(a->path, b->path);
}

TEST_F(CrashFileTest, DescribesHowToRepeatTheCrash) {
  const auto file = save_frame(folder_, frame_);
  ASSERT_TRUE(file);
  EXPECT_EQ(file->line("tensor_filter model=m.onnx"),
            "gst-launch-1.0 filesrc location=" + file->path +
                " blocksize=270 ! other/tensors,format=flexible,framerate=0/1 ! "
                "tensor_filter model=m.onnx ! fakesink");
}

TEST_F(CrashFileTest, QuotesTheFolderForAShell) {
  CrashFile file;
  file.path = "/media/my frames/it's.tensors";
  file.bytes = 132;
  EXPECT_EQ(file.line("tensor_filter"),
            "gst-launch-1.0 filesrc location='\"/media/my frames/it'\\''s.tensors\"' "
            "blocksize=132 ! other/tensors,format=flexible,framerate=0/1 ! tensor_filter ! "
            "fakesink");
}

TEST_F(CrashFileTest, ReportsWhyItIsNotWritten) {
  const auto file = save_frame(folder_ + "/not-there", frame_);
  ASSERT_FALSE(file);
  EXPECT_EQ(file.error().code, Code::FILE_NOT_WRITTEN);
  EXPECT_SAYS(file.error().message(), "No such file or directory");
  tensors_[1].info.shape[0] = -1;
  const auto open = save_frame(folder_, frame_);
  ASSERT_FALSE(open);
  EXPECT_SAYS(open.error().message(), "tensor 1 has an open shape");
  EXPECT_TRUE(fs::is_empty(folder_)) << "no half file stays";
}

}  // namespace crash_file_test
}  // namespace weir::isolate
