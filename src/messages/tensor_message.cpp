// SPDX-License-Identifier: LGPL-2.1-or-later
#include "messages/tensor_message.hpp"

#include <algorithm>

#include "weir/module.hpp"

namespace weir::messages {
namespace {

std::string written_by(const char* format_name) {
  return std::string("check the program that wrote the stream; tensor_decoder mode=") +
         format_name + " writes such messages";
}

std::string format_dimensions(const std::array<uint32_t, WEIR_RANK_LIMIT>& dimensions) {
  std::string out;
  for (const uint32_t d : dimensions) out += (out.empty() ? "" : ":") + std::to_string(d);
  return out;
}

Status check_tensor(const char* format_name, size_t index, uint32_t format,
                    const MessageTensor& tensor) {
  const auto has = [index](const char* what) {
    return "tensor " + std::to_string(index) + " of the message has " + what;
  };
  if (tensor.type >= WEIR_TYPE_END)
    return damaged_message(format_name, has("no known element type"),
                           "type " + std::to_string(tensor.type), "0 (int32) to 10 (float16)");
  const auto known = count_bytes(tensor);
  if (!known)
    return damaged_message(format_name, has("invalid dimensions"),
                           format_dimensions(tensor.dimensions),
                           "1 to 16 dimensions of at least 1, then 0");
  const uint64_t bytes = *known;
  const uint64_t header = format == kFlexible ? kHeaderBytes : 0;
  if (bytes == tensor.data.size() - header && tensor.data.size() >= header) return ok();
  return damaged_message(
      format_name, has("a size that differs from its type and dimensions"),
      std::to_string(tensor.data.size()) + " bytes",
      (bytes > kMessageLimit ? "more than a message can hold" : std::to_string(bytes + header)) +
          std::string(bytes > kMessageLimit ? "" : " bytes") + " for " +
          describe(describe_tensor(tensor)) + (header > 0 ? " with its header" : ""));
}

Status check_format_and_rate(const char* format_name, const TensorMessage& message) {
  if (message.format == kSparse)
    return Error{.code = Code::FORMAT_UNSUPPORTED,
                 .what = std::string("a ") + format_name + " message holds sparse tensors",
                 .offered = "format 2 (sparse)",
                 .needed = "0 (static) or 1 (flexible)",
                 .fix = "tensor_sparse_dec ! tensor_decoder mode=" + std::string(format_name)};
  if (message.format > kSparse)
    return damaged_message(format_name, "the message has an unknown format",
                           "format " + std::to_string(message.format),
                           "0 (static) or 1 (flexible)");
  const bool none = (message.rate_n == 0 && message.rate_d == 0) ||
                    (message.rate_n == -1 && message.rate_d == -1);
  if (message.has_rate() || none) return ok();
  return damaged_message(format_name, "the message has an invalid frame rate",
                         std::to_string(message.rate_n) + "/" + std::to_string(message.rate_d),
                         "0/1 or more");
}

}  // namespace

Error damaged_message(const char* format_name, std::string what, std::string offered,
                      std::string needed) {
  return {.code = Code::HEADER_INVALID,
          .what = std::string("a ") + format_name + " message is damaged: " + std::move(what),
          .offered = std::move(offered),
          .needed = std::move(needed),
          .fix = written_by(format_name)};
}

Error too_many_tensors(const char* format_name, uint64_t count) {
  return {.code = Code::LIMIT_EXCEEDED,
          .what = std::string("a ") + format_name + " message has too many tensors",
          .offered = std::to_string(count),
          .needed = "at most " + std::to_string(WEIR_TENSOR_LIMIT),
          .fix = "send the tensors in several messages"};
}

std::optional<uint64_t> count_bytes(const MessageTensor& tensor) {
  const auto& d = tensor.dimensions;
  uint64_t bytes = element_bytes(tensor.type);
  size_t rank = 0;
  for (; rank < d.size() && d[rank] != 0; ++rank)
    if (__builtin_mul_overflow(bytes, uint64_t{d[rank]}, &bytes)) bytes = UINT64_MAX;
  uint32_t after = 0;
  for (size_t i = rank; i < d.size(); ++i) after |= d[i];
  if (rank == 0 || after != 0) return {};
  return bytes;
}

Status check_size(const char* format_name, uint64_t bytes) {
  if (bytes <= kMessageLimit) return ok();
  return Error{.code = Code::LIMIT_EXCEEDED,
               .what = std::string("a frame is too large for a ") + format_name + " message",
               .offered = std::to_string(bytes) + " bytes",
               .needed = "at most " + std::to_string(kMessageLimit) + " bytes",
               .fix = "tensor_split before tensor_decoder"};
}

Status check_message(const char* format_name, uint64_t declared_count, size_t message_bytes,
                     const TensorMessage& message) {
  const size_t count = message.tensors.size();
  if (std::max<uint64_t>(count, declared_count) > WEIR_TENSOR_LIMIT)
    return too_many_tensors(format_name, std::max<uint64_t>(count, declared_count));
  if (count == 0 || count != declared_count)
    return damaged_message(format_name,
                           "the message does not have the number of tensors that it declares",
                           std::to_string(count) + " tensors",
                           count == 0 ? "at least 1" : std::to_string(declared_count));
  if (auto status = check_format_and_rate(format_name, message); !status) return status;
  uint64_t total = 0;
  for (size_t i = 0; i < count; ++i) {
    const auto& tensor = message.tensors[i];
    if (auto status = check_tensor(format_name, i, message.format, tensor); !status) return status;
    total += tensor.data.size();
  }
  if (total <= message_bytes) return ok();
  return damaged_message(format_name, "tensors of the message overlap",
                         std::to_string(total) + " bytes of tensors",
                         "at most " + std::to_string(message_bytes) + ", the size of the message");
}

void append_tensors(const weir_frame& frame, TensorMessage* message) {
  for (uint32_t i = 0; i < frame.n_tensors; ++i) {
    const weir_tensor& from = frame.tensors[i];
    MessageTensor to;
    to.type = from.info.type;
    for (uint32_t d = 0; d < from.info.rank && d < WEIR_RANK_LIMIT; ++d)
      to.dimensions[d] = static_cast<uint32_t>(dimension(from.info, d));
    to.data = {static_cast<const std::byte*>(from.data), static_cast<size_t>(from.bytes)};
    message->tensors.push_back(to);
  }
}

weir_tensor_info describe_tensor(const MessageTensor& tensor) noexcept {
  weir_tensor_info info{};
  info.type = tensor.type;
  while (info.rank < WEIR_RANK_LIMIT && tensor.dimensions[info.rank] != 0) ++info.rank;
  for (uint32_t i = 0; i < info.rank; ++i) info.shape[info.rank - 1 - i] = tensor.dimensions[i];
  info.batch_axis = WEIR_NO_BATCH_AXIS;
  return info;
}

}  // namespace weir::messages
