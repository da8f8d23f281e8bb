// The engine custom-easy: a model is a filter of the process.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/custom/custom_easy.hpp"

#include <cstring>

#include "core/custom/named_filter.hpp"
#include "core/infer/host.hpp"
#include "weir/engine.hpp"

namespace weir::custom {
namespace {

constexpr char kName[] = "custom-easy";

std::string name_in(std::span<const char* const> paths) {
  if (paths.size() == 1) return paths[0];
  std::string list;
  for (const char* path : paths) list += (list.empty() ? "" : ",") + std::string(path);
  throw Failure({Code::OPTION_VALUE, "a filter of the process has one name", "model=" + list,
                 "the name that it was registered under", "", "framework=custom-easy model=NAME"});
}

class CustomEasy {
 public:
  static constexpr uint64_t kFlags = WEIR_ENGINE_MODEL_IS_NO_FILE;

  explicit CustomEasy(const OpenRequest& request)
      : filter_(value_or_throw(find_filter(name_in(request.paths)))) {}

  std::span<const weir_tensor_info> inputs() const { return filter_->inputs(); }
  std::span<const weir_tensor_info> outputs() const { return filter_->outputs(); }
  void describe(weir_model_info& info) const {
    const uint32_t flags = filter_->flags();
    if (flags & WEIR_FILTER_DYNAMIC)
      info.flags |= WEIR_MODEL_DYNAMIC_OUTPUT | WEIR_MODEL_ALLOCATES_OUTPUT;
    if (flags & WEIR_FILTER_THREAD_SAFE) info.flags |= WEIR_MODEL_THREAD_SAFE;
    if (flags & WEIR_FILTER_STATEFUL) info.flags |= WEIR_MODEL_STATEFUL;
  }
  void resolve(std::span<const weir_tensor_info> in, std::span<weir_tensor_info> out) {
    value_or_throw(filter_->resolve(in, out));
  }
  bool invoke(const weir_frame& in, weir_frame& out) {
    return value_or_throw(filter_->invoke(in, out));
  }

 private:
  std::shared_ptr<NamedFilter> filter_;
};

}  // namespace

const weir_engine& custom_easy_engine() {
  static const weir_engine kTable = [] {
    accept_host(&infer::host());
    return engine_table<CustomEasy>(kName, "1", "", "");
  }();
  return kTable;
}

Status check_invocation(const weir_engine& engine, const weir_model_info& info,
                        const std::string& model, bool invoke_dynamic) {
  if (std::strcmp(engine.name, kName) != 0) return ok();
  const bool dynamic = (info.flags & WEIR_MODEL_DYNAMIC_OUTPUT) != 0;
  if (dynamic == invoke_dynamic) return ok();
  const std::string line = "tensor_filter framework=custom-easy model=" + model;
  return Error{Code::OPTION_VALUE,
               dynamic ? "the filter " + model + " decides its sizes with each frame"
                       : "the filter " + model + " has outputs of fixed sizes",
               dynamic ? "invoke-dynamic=false" : "invoke-dynamic=true",
               dynamic ? "invoke-dynamic=true" : "invoke-dynamic=false",
               "",
               line + (dynamic ? " invoke-dynamic=true" : "")};
}

}  // namespace weir::custom
