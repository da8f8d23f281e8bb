// Helpers of the C API: check pointers and convert errors to objects.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>

#include "library/guard.hpp"
#include "pipeline/pipeline.hpp"
#include "weir/pipeline.h"

struct weir_pipeline {
  std::unique_ptr<weir::pipeline::Pipeline> pipeline;
};
struct weir_pulled {
  std::shared_ptr<const weir::pipeline::PulledFrame> frame;
};

namespace weir::pipeline {

inline int to_return_code(const Status& status, weir_error** error) {
  return status ? static_cast<int>(WEIR_OK) : library::keep(error, status.error());
}

// Runs `body`, which returns a Status, with the pipeline after checking all pointers.
template <class Body, class... Pointers>
int with(weir_pipeline* pipeline, weir_error** error, Body&& body, const Pointers*... pointers) {
  return library::guarded(error, [&] {
    if (!pipeline || (... || !pointers))
      return library::keep(error, library::null_pointer("an argument"));
    if (const auto status = check_process(); !status) return library::keep(error, status.error());
    return to_return_code(body(*pipeline->pipeline), error);
  });
}

// The same with one element of the pipeline.
template <class Body, class... Pointers>
int with_element(weir_pipeline* pipeline, const char* name, weir_error** error, Body&& body,
                 const Pointers*... pointers) {
  const auto on = [&](Pipeline& p) -> Status {
    const auto element = p.element(name);
    return element ? body(element->get()) : Status(element.error());
  };
  return with(pipeline, error, on, name, pointers...);
}

}  // namespace weir::pipeline
