// SPDX-License-Identifier: LGPL-2.1-or-later
#include "weir/custom_converter.h"

#include <optional>

#include "core/infer/module/custom_converter.hpp"
#include "core/infer/module/guarded_call.hpp"
#include "core/infer/module/named_functions.hpp"
#include "core/process/process_object.hpp"

namespace weir::infer {
namespace {

using Functions = NamedFunctions<weir_convert_function>;
Functions& functions() {
  static auto& all = process::object<Functions>("converter-functions");
  return all;
}

Error unknown_converter(const std::string& name) {
  return Error{
      .code = Code::CONVERTER_UNKNOWN,
      .what = "no function is registered under this name",
      .offered = "mode=custom-code:" + name,
      .needed = functions().one_of(),
      .fix = "weir_converter_register(\"" + name + "\", function, data) before the first frame"};
}

class CustomConverter final : public Converter {
 public:
  explicit CustomConverter(std::string name)
      : name_(std::move(name)), who_("the function " + name_), room_(who_) {}

  Result<std::vector<TensorSpec>> configure(const std::string& caps) override {
    caps_ = caps;
    function_.reset();
    return std::vector<TensorSpec>{};
  }
  Result<ConvertedFrame> convert(const weir_frame& in) override {
    if (!function_ || function_->gate->is_closed()) {
      function_ = functions().find(name_);
      if (!function_) return unknown_converter(name_);
    }
    weir_error error;
    weir_frame* out = room_.prepare(in);
    const auto result = call_guarded(*function_->gate, who_, "return host->fail(...)", [&] {
      return function_->function(&host(), caps_.c_str(), &in, out, function_->data, &error);
    });
    if (!result) return room_.discard(result.error());
    auto frame = room_.take(*result, &error);
    if (frame || !error.set) return frame;
    Error failure = frame.error();
    failure.what = who_ + " failed: " + failure.what;
    return failure;
  }

 private:
  const std::string name_, who_;
  std::string caps_;
  std::optional<Functions::Entry> function_;
  ConverterRoom room_;
};

}  // namespace

std::unique_ptr<Converter> custom_converter(std::string name) {
  return std::make_unique<CustomConverter>(std::move(name));
}

bool is_custom_converter(std::string_view name) {
  return functions().find(name).has_value();
}

}  // namespace weir::infer

extern "C" int weir_converter_register(const char* name, weir_convert_function convert,
                                       void* data) {
  return weir::infer::functions().add(name, convert, data);
}

extern "C" int weir_converter_unregister(const char* name) {
  return weir::infer::functions().remove(name, WEIR_CONVERTER_UNKNOWN);
}
