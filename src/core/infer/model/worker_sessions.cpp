// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/model/worker_sessions.hpp"

#include <string>

namespace weir::infer {
namespace {

Error keeps_state(size_t workers) {
  return Error{
      .code = Code::OPTION_VALUE,
      .what = "the model keeps state from frame to frame, so frames cannot run in parallel",
      .offered = "workers=" + std::to_string(workers),
      .needed = "workers=1",
      .fix = "tensor_filter workers=1"};
}

}  // namespace

Result<std::vector<std::shared_ptr<Session>>> worker_sessions(Model& model, size_t workers) {
  std::vector<std::shared_ptr<Session>> out;
  if (workers == 0) return out;
  const weir_model_info& info = model.info();
  if (workers > 1 && (info.flags & WEIR_MODEL_STATEFUL)) return keeps_state(workers);
  auto first = model.shared_session();
  if (!first) return first.error();
  out.push_back(*std::move(first));
  if (info.flags & WEIR_MODEL_THREAD_SAFE) out.resize(workers, out.front());
  std::shared_ptr<Model> another;
  while (out.size() < workers) {
    auto session = (another ? *another : model).own_session();
    if (!session) return session.error();
    if (*session) {
      out.push_back(*std::move(session));
      continue;
    }
    auto opened = model.open_again();
    if (!opened) return opened.error();
    another = *std::move(opened);
  }
  return out;
}

}  // namespace weir::infer
