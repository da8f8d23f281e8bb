// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/element/file_digest.hpp"

#include <glib.h>

#include <fstream>
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

}  // namespace weir::gst
