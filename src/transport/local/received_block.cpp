// Checks of a memfd.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "transport/local/received_block.hpp"

#include <fcntl.h>
#include <sys/stat.h>

#include "transport/local/peer_error.hpp"

namespace weir::local {

Result<isolate::Mapping> map_block(const Descriptor& block, uint64_t bytes) {
  if (!block) return bad_writer("a block without a descriptor");
  const int seals = fcntl(block.get(), F_GET_SEALS);
  if (seals < 0) return bad_writer("a block that is not a memfd");
  if (!(seals & F_SEAL_SHRINK)) return bad_writer("a block that is not sealed against shrinking");
  struct stat found {};
  if (fstat(block.get(), &found) != 0 || found.st_size < 0)
    return bad_writer("a block of unknown size");
  const auto size = static_cast<uint64_t>(found.st_size);
  if (bytes == 0 || bytes > size)
    return bad_writer("a block of " + std::to_string(size) + " bytes as one of " +
                      std::to_string(bytes));
  isolate::Mapping out(block.get(), bytes, false);
  if (!out)
    return Error{.code = Code::OUT_OF_MEMORY,
                 .what = "a block of a local stream cannot be mapped",
                 .offered = std::to_string(bytes) + " bytes"};
  return out;
}

}  // namespace weir::local
