// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/element/file_digest.hpp"

#include <glib.h>

#include <filesystem>
#include <fstream>
#include <future>
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
  static std::map<Key, std::shared_future<std::string>> known;
  std::error_code error;
  const auto size = std::filesystem::file_size(path, error);
  if (error) return compute_sha256(path);
  const Key key{path, size, std::filesystem::last_write_time(path, error)};
  std::promise<std::string> digest;
  std::unique_lock lock(mutex);
  if (const auto at = known.find(key); at != known.end()) {
    const auto found = at->second;
    lock.unlock();
    return found.get();  // waits for a thread that reads this file
  }
  if (known.size() >= kMaxKnown) known.clear();
  known[key] = digest.get_future().share();
  lock.unlock();
  std::string computed = compute_sha256(path);
  digest.set_value(computed);
  return computed;
}

}  // namespace weir::gst
