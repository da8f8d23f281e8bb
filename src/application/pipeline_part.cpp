// Looks names up in the pipeline, whose errors list the existing ones.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "pipeline_part.hpp"

namespace weir::application {

Status check_kind(const Pipeline::Use& pipeline, const char* name, const std::string& kinds) {
  CError error;
  const int result = weir_pipeline_property_type(pipeline.get(), name, "name", error.place());
  if (result < 0) return error.take(result);
  const std::string kind = pipeline->kind_of(name);
  const bool any = kinds.empty() || kinds == kind || kinds.starts_with(kind + " or ") ||
                   kinds.ends_with(" or " + kind);
  if (any && (kinds.empty() || !kind.empty())) return ok();
  return Error{
      .code = Code::OPTION_VALUE,
      .what = "the element " + std::string(name) + " does not support this call",
      .offered = kind.empty() ? "an element inside a bin, not in the pipeline description" : kind,
      .needed = kinds};
}

}  // namespace weir::application
