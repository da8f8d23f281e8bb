// PipelinePart: an element of a pipeline, by name; the handles of sources, switches, valves and
// elements refer to it.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <string>
#include <utility>

#include "ml_error.hpp"
#include "pipeline.hpp"
#include "weir/c_error.hpp"

namespace weir::application {

class PipelinePart : public Object {
 public:
  static constexpr const char* kKind = "part of a pipeline";
  PipelinePart(std::weak_ptr<Pipeline> pipeline, std::string name)
      : pipeline_(std::move(pipeline)), name_(std::move(name)) {}
  const std::string& name() const noexcept { return name_; }
  // Called when the handle is released, which destroys this object only if no call uses it.
  virtual void close() {}
  Result<Pipeline::Use> use() const {
    if (const auto pipeline = pipeline_.lock()) return pipeline->use();
    return Error{.code = Code::OPTION_VALUE, .what = "the pipeline of this handle was destroyed"};
  }

 private:
  const std::weak_ptr<Pipeline> pipeline_;
  const std::string name_;
};

// Runs `body`, which calls a function of weir/pipeline.h, with the pipeline and the part's name.
template <class Part, class Body>
int with_part(void* handle, const char* what, Body&& body) {
  return guarded([&] {
    const auto part = Handles::all().find<Part>(handle, what);
    if (!part) return fail(part.error());
    auto pipeline = (*part)->use();
    if (!pipeline) return fail(pipeline.error());
    CError error;
    const int result = body(pipeline->get(), (*part)->name().c_str(), error.place());
    return result < 0 ? fail(error.take(result)) : static_cast<int>(ML_ERROR_NONE);
  });
}

template <class Part>
int get_part(void* pipe, const char* name, const char* kinds, void** handle) {
  return guarded([&] {
    if (!handle || !name) return fail(null_pointer("the handle or the name"));
    const auto pipeline = use_pipeline(pipe);
    if (!pipeline) return fail(pipeline.error());
    if (auto status = check_kind(*pipeline, name, kinds); !status) return fail(status.error());
    *handle = (*pipeline)->add_part(std::make_shared<Part>((**pipeline).weak_from_this(), name));
    return static_cast<int>(ML_ERROR_NONE);
  });
}

template <class Part>
int release_part(void* handle, const char* what) {
  return guarded([&] {
    const auto taken = Handles::all().take<Part>(handle, what);
    if (!taken) return fail(taken.error());
    if (const auto pipeline = (*taken)->use()) (*pipeline)->remove_part(handle);
    (*taken)->close();
    return static_cast<int>(ML_ERROR_NONE);
  });
}

}  // namespace weir::application
