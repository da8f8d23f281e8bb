// Lowered graphs kept on disk, by the digest of what they were made of.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <optional>
#include <span>
#include <string>

namespace weir::engine {

// Files weir/lowered/DIGEST.onnx in $XDG_CACHE_HOME, or in ~/.cache. Each holds the digest of its
// own content, and is used only where that fits and where folder and file belong to this user and
// nobody else may write them. Nothing here is ever an error: without a cache a graph is made anew.
class LoweringCache {
 public:
  // `made_of`: all that the graph depends on.
  explicit LoweringCache(std::span<const std::byte> made_of);

  const std::string& path() const noexcept { return path_; }  // "" where there is no cache
  // Nothing where there is no file, or none to be trusted: `complaint` says why then.
  std::optional<std::string> load(std::string* complaint) const;
  // Appears whole or not at all. False when it could not be written.
  bool store(const std::string& graph) const;

 private:
  std::string folder_, path_;
};

}  // namespace weir::engine
