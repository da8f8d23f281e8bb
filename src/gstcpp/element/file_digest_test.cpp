// SHA-256 digests of files, computed and remembered.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/element/file_digest.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

namespace file_digest_test {

using weir::gst::compute_sha256;
using weir::gst::known_sha256;

TEST(FileDigest, IsThatOfTheBytes) {
  const std::string path = testing::TempDir() + "digest.bin";
  std::ofstream(path) << "abc";
  EXPECT_EQ(compute_sha256(path),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

// The file is read again only if its size or its time has changed.
TEST(FileDigest, IsRememberedWhileTheFileStays) {
  const std::string path = testing::TempDir() + "known.bin";
  std::ofstream(path) << "abc";
  const auto time = std::filesystem::last_write_time(path);
  const std::string first = known_sha256(path);
  std::ofstream(path) << "xyz";
  std::filesystem::last_write_time(path, time);
  EXPECT_EQ(known_sha256(path), first);
  std::filesystem::last_write_time(path, time + std::chrono::seconds(1));
  EXPECT_EQ(known_sha256(path), compute_sha256(path));
  EXPECT_NE(known_sha256(path), first);
}

}  // namespace file_digest_test
