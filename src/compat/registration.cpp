// SPDX-License-Identifier: LGPL-2.1-or-later
#include "compat/registration.hpp"

#include <algorithm>
#include <iterator>
#include <vector>

#include "weir/join.hpp"

namespace weir::compat {

using subplugin::Kind;

namespace {

// Returns an error unless name and parts are complete.
Status complete(Kind kind, const char* name, std::initializer_list<Needed> parts) {
  std::vector<Needed> missing;
  std::copy_if(parts.begin(), parts.end(), std::back_inserter(missing),
               [](const Needed& part) { return !part.there; });
  if (missing.empty()) return ok();
  const auto name_of_part = [](const Needed& part) { return part.name; };
  return Error{.code = Code::MODULE_REFUSED,
               .what = std::string("the ") + to_string(kind) + " " +
                       (name ? name : "without a name") + " lacks required members",
               .offered = "without " + join(missing, ", ", name_of_part),
               .needed = join(parts, ", ", name_of_part)};
}

}  // namespace

int register_descriptor(const char* function, Kind kind, const char* name, const void* descriptor,
                        std::initializer_list<Needed> parts) noexcept {
  return or_else(function, 0, [&] {
    if (auto status = complete(kind, name, parts); !status) {
      subplugin::table().refuse(kind, status.error());
      warn(function, status.error());
      return 0;
    }
    const auto status = subplugin::table().add(kind, name ? name : "", descriptor);
    if (!status) warn(function, status.error());
    return status ? 1 : 0;
  });
}

void unregister_descriptor(const char* function, Kind kind, const char* name) noexcept {
  if (!given(function, {name})) return;
  attempt(function, [&] {
    if (!subplugin::table().remove(kind, name))
      warn(function,
           std::string("no ") + to_string(kind) + " is registered under the name " + name);
  });
}

void describe(const char* function, Kind kind, const char* name, const char* key,
              va_list texts) noexcept {
  if (!given(function, {name, key})) return;
  attempt(function, [&] {
    for (const char* each = key; each; each = va_arg(texts, const char*)) {
      const char* text = va_arg(texts, const char*);
      if (!text) return warn(function, "the property " + std::string(each) + " has no description");
      subplugin::table().describe(kind, name, each, text);
    }
  });
}

int to_errno(const char* function, int code, weir_error* error) {
  if (error) {
    warn(function, weir_error_message(error));
    weir_error_free(error);
  }
  return code == WEIR_OK ? 0 : code == -WEIR_OUT_OF_MEMORY ? -ENOMEM : -EINVAL;
}

int register_function(const char* function, subplugin::Functions& functions, const char* name,
                      subplugin::AnyFunction callback, void* data) noexcept {
  if (!given(function, {name, reinterpret_cast<const void*>(callback)})) return -EINVAL;
  return register_name(function, "function", name,
                       [&] { return functions.add(name, callback, data); });
}

int unregister_function(const char* function, subplugin::Functions& functions,
                        const char* name) noexcept {
  if (!given(function, {name})) return -EINVAL;
  return to_errno(function, functions.remove(name, WEIR_CALLBACK_UNKNOWN));
}

}  // namespace weir::compat
