// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/element/file_digest.hpp"

#include <glib.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <mutex>
#include <tuple>
#include <vector>

#include "gstcpp/element/ref.hpp"

namespace weir::gst {

std::string compute_sha256(const std::string& path) {
  const Unique<GChecksum, g_checksum_free> sum(g_checksum_new(G_CHECKSUM_SHA256));
  std::ifstream file(path, std::ios::binary);
  std::vector<char> block(1 << 16);
  while (file.read(block.data(), static_cast<std::streamsize>(block.size())) || file.gcount() > 0)
    g_checksum_update(sum.get(), reinterpret_cast<const guchar*>(block.data()), file.gcount());
  return g_checksum_get_string(sum.get());
}

std::string known_sha256(const std::string& path) {
  using Key = std::tuple<std::string, uintmax_t, std::filesystem::file_time_type>;
  static constexpr size_t kMaxKnown = 64;
  static std::mutex mutex;  // guards `known`
  static std::map<Key, std::string> known;
  std::error_code ignored;
  const Key key{path, std::filesystem::file_size(path, ignored),
                std::filesystem::last_write_time(path, ignored)};
  const std::lock_guard lock(mutex);  // others wait, rather than compute the same
  if (const auto at = known.find(key); at != known.end()) return at->second;
  if (known.size() >= kMaxKnown) known.clear();
  return known[key] = compute_sha256(path);
}

}  // namespace weir::gst
