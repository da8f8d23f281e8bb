// Sends structs of the ABI without their pointers, followed by their texts.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/isolate/worker_model_info.hpp"

#include <algorithm>

namespace weir::isolate {
namespace {

constexpr size_t kMaxTextBytes = size_t{64} * 1024;

std::string shortened(std::string text) {
  if (text.size() > kMaxTextBytes) text.resize(kMaxTextBytes);
  return text;
}

}  // namespace

void put_infos(std::span<const weir_tensor_info> infos, MessageWriter* message) {
  message->put(static_cast<uint32_t>(infos.size()));
  for (weir_tensor_info info : infos) {
    const char* name = info.name;
    info.name = nullptr;
    message->put(info);
    message->put<uint8_t>(name != nullptr);
    message->text(name ? shortened(name) : "");
  }
}

TensorInfos TensorInfos::take(MessageReader* message) {
  TensorInfos out;
  std::vector<bool> named;
  const uint32_t count = message->count(WEIR_TENSOR_LIMIT);
  for (uint32_t i = 0; i < count; ++i) {
    out.list_.push_back(message->take<weir_tensor_info>());
    named.push_back(message->take<uint8_t>() != 0);
    out.names_.push_back(message->text());
  }
  for (uint32_t i = 0; i < count; ++i)
    out.list_[i].name = named[i] ? out.names_[i].c_str() : nullptr;
  return out;
}

void put_model(const std::string& engine, const AcceleratorChoice& accelerator,
               const weir_model_info& info, MessageWriter* message) {
  message->text(engine);
  message->text(shortened(accelerator.used));
  message->put<uint8_t>(accelerator.warning.has_value());
  if (accelerator.warning) put_error(*accelerator.warning, message);
  weir_model_info plain = info;
  plain.inputs = plain.outputs = nullptr;
  plain.metadata_json = nullptr;
  message->put(plain);
  put_infos({info.inputs, info.n_inputs}, message);
  put_infos({info.outputs, info.n_outputs}, message);
  const std::string metadata = info.metadata_json ? info.metadata_json : "";
  message->text(metadata.size() < kMaxMessageBytes / 2 ? metadata : "");
}

WorkerModelInfo WorkerModelInfo::take(MessageReader* message) {
  WorkerModelInfo out;
  out.engine = message->text();
  out.accelerator.used = message->text();
  if (message->take<uint8_t>() != 0) out.accelerator.warning = take_error(message);
  out.info = message->take<weir_model_info>();
  out.info.inputs = out.info.outputs = nullptr;
  out.info.metadata_json = nullptr;
  out.inputs = TensorInfos::take(message);
  out.outputs = TensorInfos::take(message);
  out.metadata_json = message->text();
  return out;
}

bool same_tensors(const WorkerModelInfo& a, const WorkerModelInfo& b) {
  const auto same = [](const weir_tensor_info& x, const weir_tensor_info& y) {
    const size_t rank = std::min<size_t>(x.rank, WEIR_RANK_LIMIT);
    return x.type == y.type && x.rank == y.rank && std::equal(x.shape, x.shape + rank, y.shape);
  };
  return std::ranges::equal(a.inputs.list(), b.inputs.list(), same) &&
         std::ranges::equal(a.outputs.list(), b.outputs.list(), same);
}

void put_error(const Error& error, MessageWriter* message) {
  message->put(static_cast<int32_t>(error.code));
  for (const auto* part :
       {&error.what, &error.offered, &error.needed, &error.difference, &error.fix})
    message->text(shortened(*part));
}

Error take_error(MessageReader* message) {
  Error error;
  const auto code = message->take<int32_t>();
  constexpr int32_t kFirst = 1000, kLast = 9999;
  error.code = code >= kFirst && code <= kLast ? static_cast<Code>(code) : Code::INTERNAL;
  for (auto* part : {&error.what, &error.offered, &error.needed, &error.difference, &error.fix})
    *part = message->text();
  return error;
}

}  // namespace weir::isolate
