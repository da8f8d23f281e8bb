// OipClient: frames of one kind through the engine oip, without a pipeline.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/infer/model/model.hpp"
#include "core/infer/module/held_frame.hpp"
#include "core/infer/module/module_library.hpp"
#include "server_process.hpp"

namespace weir::bench {

using Options = std::vector<std::pair<std::string, std::string>>;

// `paths` for an engine of this name.
inline std::unique_ptr<infer::Session> open_session(const char* engine,
                                                    std::vector<std::string> paths,
                                                    Options options) {
  infer::OpenOptions open;
  open.paths = std::move(paths);
  open.options = std::move(options);
  const auto* found = value(infer::ModuleLibrary::instance().engine(engine));
  return value(infer::Session::create(value(infer::Model::open(*found, open))));
}

// The tensor of a frame, which has one: its description, and its bytes.
inline weir_tensor make_tensor(const weir_tensor_info& info, void* data, size_t bytes) {
  weir_tensor out{};
  out.data = data;
  out.bytes = out.capacity = bytes;
  out.info = info;
  return out;
}

// Whether the engine answered. With an `owner`, the engine may use the input's memory later.
inline bool invoke(infer::Session& session, weir_tensor in, weir_tensor out,
                   infer::FrameOwner* owner = nullptr) {
  weir_frame in_frame{}, out_frame{};
  in_frame.struct_size = out_frame.struct_size = sizeof in_frame;
  in_frame.n_tensors = out_frame.n_tensors = 1;
  in_frame.tensors = &in, out_frame.tensors = &out;
  const infer::FrameOwnerScope scope(in_frame, owner);
  return value(session.invoke(in_frame, out_frame));
}

class OipClient {
 public:
  // Of models whose input and output are alike.
  OipClient(const std::vector<std::string>& addresses, const weir_tensor_info& info, size_t bytes,
            Options options = {{"in-flight", "64"}, {"probe-ms", "100"}})
      : info_(info), input_(bytes), session_(open_session("oip", addresses, std::move(options))) {}
  // Any thread; `output` has the bytes of the model's. Whether it was answered.
  bool call(void* output) {
    Owner owner;
    return invoke(*session_, make_tensor(info_, input_.data(), input_.size()),
                  make_tensor(info_, output, input_.size()), &owner);
  }

 private:
  // The input is memory that stays.
  struct Owner final : infer::FrameOwner {
    std::shared_ptr<const void> hold() override { return std::make_shared<int>(); }
  };

  const weir_tensor_info info_;
  std::vector<char> input_;
  std::unique_ptr<infer::Session> session_;
};

}  // namespace weir::bench
