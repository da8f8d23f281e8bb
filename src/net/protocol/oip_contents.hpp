// Tensors in messages of the Open Inference Protocol: their descriptions, and their elements as raw
// or typed contents.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <optional>
#include <span>
#include <string>

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
// Writes the elements of a tensor to `to`: from `raw`, or from its typed contents without it.
// PEER_MESSAGE_INVALID when there are more or fewer.
Status read_elements(const Chunks& chunks, const InferTensor& tensor, std::optional<Range> raw,
                     std::span<std::byte> to, Sender sender);
// The only element of a tensor of type BYTES, as a range of the message. PEER_MESSAGE_INVALID when
// there are more or fewer.
Result<Range> only_element(const Chunks& chunks, const InferTensor& tensor,
                           std::optional<Range> raw, Sender sender);

}  // namespace weir::net
