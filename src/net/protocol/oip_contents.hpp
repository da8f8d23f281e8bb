// Tensors in messages of the Open Inference Protocol: their descriptions, and their elements as raw
// or typed contents.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "net/protocol/oip_messages.hpp"

namespace weir::net {

// Who sent a message: what its errors are about.
enum class Sender { Server, Client };

// PEER_MESSAGE_INVALID.
Error bad_message(Sender sender, std::string offered, std::string needed);
Error damaged_message(Sender sender, const char* message);
// "x FP32 [1,4]".
std::string describe(const TensorText& tensor);

inline constexpr size_t kMaxNameBytes = 1024;

// Reads the description of a tensor, and where its typed contents are if `contents` is not null.
// False: the message is damaged, or beyond the limits of oip_messages.hpp.
bool read_tensor(const Chunks& chunks, Range range, TensorText* out, std::vector<Range>* contents);
// Reads a field of a request or a response if it has a tensor, or raw contents by the number
// `raw_field`. False: the message is damaged, or beyond the limits.
bool read_tensor_field(const Chunks& chunks, const Field& field, uint32_t raw_field,
                       std::vector<InferTensor>* tensors, std::vector<Range>* raw);
// Gives the tensors their raw contents. PEER_MESSAGE_INVALID unless there are none or one for each.
Status set_raw(const std::vector<Range>& raw, Sender sender, std::vector<InferTensor>* tensors);
// Writes the elements of a tensor to `to`, whose size is that of the expected tensor.
// PEER_MESSAGE_INVALID when there are more or fewer.
Status read_elements(const Chunks& chunks, const InferTensor& tensor, std::span<std::byte> to,
                     Sender sender);
// Returns the only element of a tensor of type BYTES, as a range of the message.
// PEER_MESSAGE_INVALID when there are more or fewer.
Result<Range> only_element(const Chunks& chunks, const InferTensor& tensor, Sender sender);

// Encodes name, type and shape of a tensor.
std::string encode_description(std::string_view name, std::string_view datatype,
                               std::span<const int64_t> shape);
// Appends the raw contents of the tensors as fields, from where they are.
void put_raw_contents(Pieces* to, uint32_t field, std::span<const RequestTensor> tensors);

}  // namespace weir::net
