// The engine custom-easy: each model is a filter of the application.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/custom/custom_easy.hpp"

#include <cstring>

#include "core/custom/named_filter.hpp"
#include "core/infer/module/host.hpp"
#include "weir/engine.hpp"
#include "weir/join.hpp"

namespace weir::custom {
namespace {

constexpr char kName[] = "custom-easy";

std::string name_in(std::span<const char* const> paths) {
  if (paths.size() == 1) return paths[0];
  const std::string list = join(paths, ",");
  throw Failure({.code = Code::OPTION_VALUE,
                 .what = "framework=custom-easy needs exactly one filter name",
                 .offered = "model=" + list,
                 .needed = "the name under which it was registered",
                 .fix = "framework=custom-easy model=NAME"});
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
  return Error{.code = Code::OPTION_VALUE,
               .what = dynamic ? "the filter " + model + " decides its sizes with each frame"
                               : "the filter " + model + " has outputs of fixed sizes",
               .offered = dynamic ? "invoke-dynamic=false" : "invoke-dynamic=true",
               .needed = dynamic ? "invoke-dynamic=true" : "invoke-dynamic=false",
               .fix = line + (dynamic ? " invoke-dynamic=true" : "")};
}

}  // namespace weir::custom
