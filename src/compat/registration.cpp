// Into the table, with words for what is refused.
#include "compat/registration.hpp"

#include <cerrno>

namespace weir::compat {

using subplugin::Kind;

namespace {

// Nothing to refuse: no error.
Status complete(Kind kind, const char* name, std::initializer_list<Needed> parts) {
  std::string missing, needed;
  for (const auto& part : parts) {
    needed += (needed.empty() ? "" : ", ") + std::string(part.name);
    if (!part.there) missing += (missing.empty() ? "" : ", ") + std::string(part.name);
  }
  if (missing.empty()) return ok();
  return Error{Code::MODULE_REFUSED,
               std::string("the ") + name_of(kind) + " " + (name ? name : "without a name") +
                   " lacks what it must have",
               "without " + missing,
               needed,
               "",
               ""};
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
      warn(function, std::string("there is no ") + name_of(kind) + " " + name);
  });
}

const void* find_descriptor(const char* function, Kind kind, const char* name) noexcept {
  if (!given(function, {name})) return nullptr;
  return or_else<const void*>(function, nullptr, [&]() -> const void* {
    const auto found = subplugin::open(kind, name);
    if (found) return *found;
    warn(function, found.error());
    return nullptr;
  });
}

void describe(const char* function, Kind kind, const char* name, const char* key,
              va_list texts) noexcept {
  if (!given(function, {name, key})) return;
  attempt(function, [&] {
    for (const char* each = key; each; each = va_arg(texts, const char*)) {
      const char* text = va_arg(texts, const char*);
      if (!text) return warn(function, std::string(each) + " has no description");
      subplugin::table().describe(kind, name, each, text);
    }
  });
}

int register_function(const char* function, subplugin::Functions& functions, const char* name,
                      subplugin::AnyFunction callback, void* data) noexcept {
  if (!given(function, {name, reinterpret_cast<const void*>(callback)})) return -EINVAL;
  return or_else(function, -ENOMEM, [&] {
    if (auto status = subplugin::check_name(name); !status) {
      warn(function, status.error());
      return -EINVAL;
    }
    const int result = functions.add(name, callback, data);
    if (result == WEIR_OK) return 0;
    if (result == -WEIR_OUT_OF_MEMORY) return -ENOMEM;
    warn(function, "another function has the name " + std::string(name) + " already");
    return -EINVAL;
  });
}

int unregister_function(const char* function, subplugin::Functions& functions,
                        const char* name) noexcept {
  if (!given(function, {name})) return -EINVAL;
  return functions.remove(name, WEIR_CALLBACK_UNKNOWN) == WEIR_OK ? 0 : -EINVAL;
}

}  // namespace weir::compat
