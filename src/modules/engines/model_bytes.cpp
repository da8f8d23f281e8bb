// SPDX-License-Identifier: LGPL-2.1-or-later
#include "model_bytes.hpp"

#include <algorithm>

#include "model_source.hpp"

namespace weir::engine {
namespace {

constexpr size_t kPieceBytes = size_t{16} << 20;

Error too_large(const ModelSource& source, uint64_t max) {
  return Error{.code = Code::MODEL_UNSUPPORTED,
               .what = "the model file is larger than its format or engine can hold",
               .offered = source.name() + ": " + std::to_string(source.size()) + " bytes",
               .needed = "at most " + std::to_string(max) + " bytes",
               .difference = {},
               .fix =
                   "export the model with its weights in a separate file, if the format "
                   "supports it"};
}

Error cut_meanwhile(const ModelSource& source) {
  return Error{.code = Code::MODEL_INVALID,
               .what = "the model file was truncated while it was read",
               .offered = source.name(),
               .needed = std::to_string(source.size()) + " bytes",
               .difference = {},
               .fix = "open the model after it is completely written"};
}

Status check_head(const ModelSource& source, const ModelLimits& limits) {
  if (!limits.check_head) return ok();
  std::vector<std::byte> head(std::min<uint64_t>(source.size(), kModelHead));
  if (!source.read(0, head)) return cut_meanwhile(source);
  auto status = limits.check_head(head);
  if (status) return ok();
  Error error = status.error();
  error.offered = source.name() + (error.offered.empty() ? "" : ": " + error.offered);
  return error;
}

}  // namespace

Result<ModelBytes> read_model(const weir_open& request, const ModelLimits& limits) {
  auto source = ModelSource::open(request);
  if (!source) return source.error();
  if (source->size() > limits.max) return too_large(*source, limits.max);
  if (auto status = check_head(*source, limits); !status) return status.error();
  ModelBytes out;
  out.path = source->path();
  out.bytes = source->memory();
  if (out.path.empty()) return out;
  out.owned.reserve(source->size());
  while (out.owned.size() < source->size()) {
    const size_t at = out.owned.size();
    const auto piece = std::min<uint64_t>(kPieceBytes, source->size() - at);
    out.owned.resize(at + piece);
    if (!source->read(at, std::span(out.owned).subspan(at))) return cut_meanwhile(*source);
  }
  out.bytes = out.owned;
  return out;
}

}  // namespace weir::engine
