// SPDX-License-Identifier: LGPL-2.1-or-later
#include "net/protocol/grpc_bytes.hpp"

#include <vector>

namespace weir::net {
namespace {

// Keeps the caller's memory until gRPC has sent it.
grpc::Slice make_slice(std::span<const std::byte> bytes,
                       const std::shared_ptr<const void>& memory) {
  auto* keep = new std::shared_ptr<const void>(memory);
  return grpc::Slice(
      const_cast<std::byte*>(bytes.data()), bytes.size(),
      [](void* user) { delete static_cast<std::shared_ptr<const void>*>(user); }, keep);
}

}  // namespace

grpc::ByteBuffer make_message(const Pieces& pieces, const std::shared_ptr<const void>& memory) {
  std::vector<grpc::Slice> slices;
  slices.reserve(pieces.size());
  for (const auto& piece : pieces) {
    if (!piece.own.empty())
      slices.emplace_back(piece.own);
    else if (!piece.borrowed.empty())
      slices.push_back(make_slice(piece.borrowed, memory));
  }
  return {slices.data(), slices.size()};
}

std::optional<ReceivedMessage> received(const grpc::ByteBuffer& message) {
  auto slices = std::make_shared<std::vector<grpc::Slice>>();
  if (message.Valid() && !message.Dump(slices.get()).ok()) return std::nullopt;
  std::vector<Chunks::Chunk> chunks;
  for (const auto& slice : *slices)
    chunks.push_back({reinterpret_cast<const std::byte*>(slice.begin()), slice.size()});
  return ReceivedMessage{Chunks(std::move(chunks)), std::move(slices)};
}

}  // namespace weir::net
