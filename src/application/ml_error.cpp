// SPDX-License-Identifier: LGPL-2.1-or-later
#include "ml_error.hpp"

namespace weir::application {
namespace {

struct LastError {
  std::string text;
  int number = 0;
};
thread_local LastError last_error;

ml_error_e to_ml_code(Code code) noexcept {
  switch (code) {
    case Code::OUT_OF_MEMORY:
      return ML_ERROR_OUT_OF_MEMORY;
    case Code::WORKER_TIMEOUT:
      return ML_ERROR_TIMED_OUT;
    case Code::CANCELLED:
      return ML_ERROR_TRY_AGAIN;
    case Code::FILE_NOT_FOUND:
    case Code::FILE_NOT_WRITTEN:
      return ML_ERROR_IO_ERROR;
    case Code::ENGINE_UNKNOWN:
    case Code::ENGINE_NOT_INSTALLED:
    case Code::FORMAT_UNSUPPORTED:
      return ML_ERROR_NOT_SUPPORTED;
    case Code::INVOKE_FAILED:
    case Code::CALLBACK_FAILED:
    case Code::NOT_NEGOTIATED:
    case Code::WORKER_ENDED:
      return ML_ERROR_STREAMS_PIPE;
    case Code::INTERNAL:
      return ML_ERROR_UNKNOWN;
    default:
      return ML_ERROR_INVALID_PARAMETER;
  }
}

}  // namespace

int fail(const Error& error) noexcept {
  return fail(refusal(error));
}

Refusal refusal(const Error& error) {
  return Refusal{to_ml_code(error.code), error};
}

int fail(const Refusal& refusal) noexcept {
  last_error.number = static_cast<int>(refusal.error.code);
  try {
    last_error.text = refusal.error.message();
  } catch (...) {
    last_error.text.clear();
  }
  return refusal.number;
}

Error null_pointer(const char* what) {
  return Error{.code = Code::OPTION_VALUE, .what = std::string(what) + " is a null pointer"};
}

}  // namespace weir::application

const char* ml_error() {
  return weir::application::last_error.text.c_str();
}

int ml_error_number() {
  return weir::application::last_error.number;
}
