// The host's table as this module sees it, and errors on their way back through the C ABI.
#pragma once
#include <exception>
#include <new>
#include <string>

#include "weir/abi.h"
#include "weir/result.hpp"

namespace weir::engine {

// Set by weir_module_entry, before anything else of the module runs.
inline const weir_host* module_host = nullptr;
inline const char* module_name = "engine";

inline void log(weir_log_level level, const std::string& text) {
  if (module_host && module_host->log) module_host->log(level, module_name, text.c_str());
}

// Fills the caller's weir_error; returns what an ABI function returns. The ABI has no place of its
// own for the first difference: it goes behind what was offered.
inline int fail(weir_error* to, const Error& error) {
  const auto text = [](const std::string& part) { return part.empty() ? nullptr : part.c_str(); };
  std::string offered = error.offered;
  if (!error.difference.empty()) offered += (offered.empty() ? "" : "; ") + error.difference;
  return module_host->fail(to, static_cast<int>(error.code), error.what.c_str(), text(offered),
                           text(error.needed), text(error.fix));
}

// Runs `body`, which gives a Status; what it throws becomes an error: nothing of C++ leaves.
template <class Body>
int guarded(weir_error* to, Body&& body) noexcept {
  try {
    const Status status = body();
    return status ? WEIR_OK : fail(to, status.error());
  } catch (const std::bad_alloc&) {
    return module_host->fail(to, WEIR_OUT_OF_MEMORY, "memory ran out in an engine", nullptr,
                             nullptr, nullptr);
  } catch (const std::exception& e) {
    return module_host->fail(to, WEIR_INTERNAL, e.what(), nullptr, nullptr, nullptr);
  } catch (...) {
    return -WEIR_INTERNAL;
  }
}

}  // namespace weir::engine
