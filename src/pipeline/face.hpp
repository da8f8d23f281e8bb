// What the functions of the C face have in common: pointers are checked, errors become objects.
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

inline int answer(const Status& status, weir_error** error) {
  return status ? static_cast<int>(WEIR_OK) : library::keep(error, status.error());
}

// Runs `body` with the pipeline, when it and the other pointers are there. It returns a Status.
template <class Body, class... Pointers>
int with(weir_pipeline* pipeline, weir_error** error, Body&& body, const Pointers*... pointers) {
  return library::guarded(error, [&] {
    if (!pipeline || (... || !pointers))
      return library::keep(error, library::null_pointer("an argument"));
    return answer(body(*pipeline->pipeline), error);
  });
}

// The same with one of its elements.
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
