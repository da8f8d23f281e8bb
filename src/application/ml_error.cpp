// SPDX-License-Identifier: LGPL-2.1-or-later
#include "ml_error.hpp"

#include <cstring>
#include <iterator>
#include <string>
#include <utility>

namespace weir::application {
namespace {

constexpr size_t kMaxText = 4095;  // the buffers of programs for NNStreamer hold one byte more
constexpr unsigned kApiVersion[]{1, 8, 8};

struct LastError {
  std::string text;
  int number = 0;
  bool is_unread = false;
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
  last_error.is_unread = true;
  try {
    last_error.text = refusal.error.message();
    if (last_error.text.size() > kMaxText) last_error.text.resize(kMaxText);
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
  auto& last = weir::application::last_error;
  return std::exchange(last.is_unread, false) ? last.text.c_str() : nullptr;
}

int ml_error_number() {
  return weir::application::last_error.number;
}

const char* ml_strerror(int error_code) {
  constexpr std::pair<int, const char*> kTexts[]{
      {ML_ERROR_INVALID_PARAMETER, "a handle, a name or a value cannot be used"},
      {ML_ERROR_STREAMS_PIPE, "a pipeline or a model has failed"},
      {ML_ERROR_TRY_AGAIN, "this is not possible now; try again later"},
      {ML_ERROR_UNKNOWN, "an internal error"},
      {ML_ERROR_TIMED_OUT, "the time limit has passed"},
      {ML_ERROR_NOT_SUPPORTED, "an engine, an element or a property is not available"},
      {ML_ERROR_PERMISSION_DENIED, "this is not allowed"},
      {ML_ERROR_OUT_OF_MEMORY, "memory ran out"},
      {ML_ERROR_IO_ERROR, "a file cannot be read or written"}};
  for (const auto& [number, text] : kTexts)
    if (error_code == number || error_code == -number) return text;
  return nullptr;
}

void ml_api_get_version(unsigned int* major, unsigned int* minor, unsigned int* micro) {
  unsigned int* const out[]{major, minor, micro};
  for (size_t i = 0; i < std::size(out); ++i)
    if (out[i]) *out[i] = weir::application::kApiVersion[i];
}

char* ml_api_get_version_string() {
  std::string text = "Machine Learning API ";
  for (const unsigned part : weir::application::kApiVersion) text += std::to_string(part) + ".";
  text.pop_back();
  return strdup(text.c_str());
}
