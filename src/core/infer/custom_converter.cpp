// The register of functions, and a converter that calls one.
#include "weir/custom_converter.h"

#include <map>
#include <mutex>
#include <new>
#include <optional>

#include "core/infer/custom_converter.hpp"

namespace weir::infer {
namespace {

struct Function {
  weir_convert_function convert;
  void* data;
};

struct Register {
  std::mutex mutex;  // guards the rest; never held while a function is called
  std::map<std::string, Function, std::less<>> functions;
};
Register& functions() {
  static Register all;
  return all;
}

Result<Function> find(const std::string& name) {
  Register& all = functions();
  std::lock_guard lock(all.mutex);
  const auto found = all.functions.find(name);
  if (found != all.functions.end()) return found->second;
  std::string names;
  for (const auto& [known, function] : all.functions) names += (names.empty() ? "" : ", ") + known;
  return Error{Code::CONVERTER_UNKNOWN,
               "no function is registered under this name",
               "mode=custom-code:" + name,
               "one of: " + (names.empty() ? "none" : names),
               "",
               "weir_converter_register(\"" + name + "\", function, data) before the first frame"};
}

class CustomConverter final : public Converter {
 public:
  explicit CustomConverter(std::string name) : name_(std::move(name)) {}

  Result<std::vector<TensorSpec>> configure(const std::string& caps) override {
    caps_ = caps;
    function_.reset();
    return std::vector<TensorSpec>{};
  }
  Result<ConvertedFrame> convert(const weir_frame& in) override {
    if (!function_) {
      const auto found = find(name_);
      if (!found) return found.error();
      function_ = *found;
    }
    weir_error error;
    const int result =
        function_->convert(&host(), caps_.c_str(), &in, room_.prepare(in), function_->data, &error);
    return room_.take(result, &error);
  }

 private:
  std::string name_, caps_;
  std::optional<Function> function_;
  ConverterRoom room_;
};

}  // namespace

std::unique_ptr<Converter> custom_converter(std::string name) {
  return std::make_unique<CustomConverter>(std::move(name));
}

bool is_custom_converter(std::string_view name) {
  Register& all = functions();
  std::lock_guard lock(all.mutex);
  return all.functions.find(name) != all.functions.end();
}

}  // namespace weir::infer

extern "C" int weir_converter_register(const char* name, weir_convert_function convert,
                                       void* data) {
  if (!name || !*name || !convert) return -WEIR_OPTION_VALUE;
  try {
    auto& all = weir::infer::functions();
    std::lock_guard lock(all.mutex);
    const bool added = all.functions.try_emplace(name, weir::infer::Function{convert, data}).second;
    return added ? WEIR_OK : -WEIR_OPTION_VALUE;
  } catch (const std::bad_alloc&) {
    return -WEIR_OUT_OF_MEMORY;
  }
}

extern "C" int weir_converter_unregister(const char* name) {
  if (!name) return -WEIR_CONVERTER_UNKNOWN;
  auto& all = weir::infer::functions();
  std::lock_guard lock(all.mutex);
  const auto found = all.functions.find(std::string_view(name));
  if (found == all.functions.end()) return -WEIR_CONVERTER_UNKNOWN;
  all.functions.erase(found);
  return WEIR_OK;
}
