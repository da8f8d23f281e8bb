// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/isolate/calls.hpp"

namespace weir::isolate {

void OpenCall::put(MessageWriter* message) const {
  message->text(engine);
  message->put(static_cast<uint32_t>(paths.size()));
  for (const auto& path : paths) message->text(path);
  for (const auto* pairs : {&options, &declared}) {
    message->put(static_cast<uint32_t>(pairs->size()));
    for (const auto& [key, value] : *pairs) {
      message->text(key);
      message->text(value);
    }
  }
  message->text(accelerator);
  message->put(threads);
}

OpenCall OpenCall::take(MessageReader* message) {
  constexpr uint32_t kMax = 1 << 16;
  OpenCall out;
  out.engine = message->text();
  for (uint32_t n = message->count(kMax); n > 0; --n) out.paths.push_back(message->text());
  for (auto* pairs : {&out.options, &out.declared})
    for (uint32_t n = message->count(kMax); n > 0; --n) {
      auto key = message->text();
      pairs->emplace_back(std::move(key), message->text());
    }
  out.accelerator = message->text();
  out.threads = message->take<int32_t>();
  return out;
}

weir_tensor without_pointers(const weir_tensor& tensor) {
  weir_tensor out = tensor;
  out.data = nullptr;
  out.release = nullptr;
  out.owner = nullptr;
  out.info.name = nullptr;
  return out;
}

bool has_legal_rank(const weir_tensor_info& info) noexcept {
  return info.rank <= WEIR_RANK_LIMIT || info.rank == WEIR_RANK_UNKNOWN;
}

std::optional<uint64_t> place(uint64_t bytes, uint64_t* end) {
  constexpr uint64_t kMax = uint64_t{1} << 62;
  if (bytes > kMax || *end > kMax) return std::nullopt;
  const uint64_t at = (*end + kPlacement - 1) / kPlacement * kPlacement;
  *end = at + bytes;
  return at;
}

}  // namespace weir::isolate
