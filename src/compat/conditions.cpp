// Custom conditions for tensor_if: adapts functions with C structs to Weir's registry.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cerrno>
#include <map>
#include <mutex>
#include <vector>

#include "compat/registration.hpp"
#include "compat/spec.hpp"
#include "core/infer/module/converted_frame.hpp"
#include "nnstreamer_plugin_api_util.h"
#include "tensor_if.h"
#include "weir/custom_condition.h"

using namespace weir::compat;

namespace {

struct Condition {
  tensor_if_custom function;
  void* data;
};

// One per pair, never freed: a function may unregister itself.
Condition* keep_condition(tensor_if_custom function, void* data) {
  struct Kept {
    std::mutex mutex;  // guards all
    std::map<std::pair<tensor_if_custom, void*>, Condition> all;
  };
  static auto& kept = *new Kept;
  std::lock_guard lock(kept.mutex);
  return &kept.all.try_emplace({function, data}, Condition{function, data}).first->second;
}

class CInfo {
 public:
  explicit CInfo(const weir::FrameSpec& spec) { write(spec, &info_); }
  ~CInfo() { gst_tensors_info_free(&info_); }
  CInfo(const CInfo&) = delete;
  CInfo& operator=(const CInfo&) = delete;
  const GstTensorsInfo* get() const noexcept { return &info_; }

 private:
  GstTensorsInfo info_{};
};

int ask(const weir_host* host, const weir_frame* frame, int* decision, void* data,
        weir_error* error) noexcept {
  const auto& condition = *static_cast<const Condition*>(data);
  return or_else(__func__, -WEIR_INTERNAL, [&] {
    weir::FrameSpec spec{weir::Format::Static, {}, {}};
    std::vector<GstTensorMemory> memories;
    for (uint32_t i = 0; i < frame->n_tensors; ++i) {
      auto tensor = weir::infer::to_spec("tensor_if", frame->tensors[i].info);
      if (!tensor)
        return host->fail(error, WEIR_INTERNAL, tensor.error().what.c_str(), nullptr, nullptr,
                          nullptr, nullptr);
      spec.tensors.push_back(*std::move(tensor));
      memories.push_back({frame->tensors[i].data, frame->tensors[i].bytes});
    }
    const CInfo info(spec);
    bool result = false;
    if (!condition.function(info.get(), memories.data(), condition.data, &result))
      return host->fail(error, WEIR_CALLBACK_FAILED, "it returned false", nullptr,
                        "true, with the answer in *result", nullptr, nullptr);
    *decision = result;
    return static_cast<int>(WEIR_OK);
  });
}

}  // namespace

int nnstreamer_if_custom_register(const char* name, tensor_if_custom func, void* data) {
  if (!given(__func__, {name, reinterpret_cast<const void*>(func)})) return -EINVAL;
  return register_name(__func__, "condition", name, [&] {
    return weir_condition_register(name, ask, keep_condition(func, data));
  });
}

int nnstreamer_if_custom_unregister(const char* name) {
  if (!given(__func__, {name})) return -EINVAL;
  return to_errno(__func__, weir_condition_unregister(name));
}
