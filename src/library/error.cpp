// Implements weir/error.h.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "weir/error.h"

#include <memory>

#include "core/infer/module/host.hpp"

namespace {

const char* part(const weir_error* error, std::string weir::Error::*member) {
  return error ? (error->error.*member).c_str() : "";
}

}  // namespace

weir_error* weir_error_new(int code, const char* what, const char* offered, const char* needed,
                           const char* difference, const char* fix) {
  const auto text = [](const char* given) { return std::string(given ? given : ""); };
  try {
    weir::Error error{.code = static_cast<weir::Code>(code > 0 ? code : WEIR_INTERNAL),
                      .what = text(what),
                      .offered = text(offered),
                      .needed = text(needed),
                      .difference = text(difference),
                      .fix = text(fix)};
    return std::make_unique<weir_error>(weir_error{std::move(error), true}).release();
  } catch (const std::bad_alloc&) {
    return nullptr;
  }
}

int weir_error_code(const weir_error* error) {
  return error ? static_cast<int>(error->error.code) : 0;
}

const char* weir_error_message(weir_error* error) {
  if (!error) return "";
  try {
    if (error->text.empty()) error->text = error->error.message();
  } catch (const std::bad_alloc&) {
    return weir_error_what(error);
  }
  return error->text.c_str();
}

const char* weir_error_what(const weir_error* error) {
  return part(error, &weir::Error::what);
}

const char* weir_error_offered(const weir_error* error) {
  return part(error, &weir::Error::offered);
}

const char* weir_error_needed(const weir_error* error) {
  return part(error, &weir::Error::needed);
}

const char* weir_error_difference(const weir_error* error) {
  return part(error, &weir::Error::difference);
}

const char* weir_error_fix(const weir_error* error) {
  return part(error, &weir::Error::fix);
}

void weir_error_free(weir_error* error) {
  delete error;
}
