// LoweringCache: keeps lowered graphs on disk, named by the digest of their source.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <optional>
#include <span>
#include <string>

namespace weir::engine {

// Files weir/lowered/DIGEST.onnx in $XDG_CACHE_HOME or ~/.cache. Each file contains the digest of
// its content. It is used only if that digest is right and only this user owns and can write the
// file and its folder. Nothing here is an error: without a cache, the graph is lowered again.
class LoweringCache {
 public:
  // `made_of`: everything that determines the graph.
  explicit LoweringCache(std::span<const std::byte> made_of);

  const std::string& path() const noexcept { return path_; }  // "" without a cache
  // Empty when there is no file, or none that can be trusted: `complaint` then gives the reason.
  std::optional<std::string> load(std::string* complaint) const;
  // Atomic: the file appears complete or not at all. False when it cannot be written.
  bool store(const std::string& graph) const;

 private:
  std::string folder_, path_;
};

}  // namespace weir::engine
