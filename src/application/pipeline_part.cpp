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
      .what = std::string(name) + " is not an element that this call is for",
      .offered = kind.empty() ? "an element that the pipeline description does not name" : kind,
      .needed = kinds};
}

}  // namespace weir::application
