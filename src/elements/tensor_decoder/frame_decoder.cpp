// Finds the decoder of a mode: module, sub-plugin or registered function.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_decoder/frame_decoder.hpp"

#include <algorithm>

#include "core/infer/module/decoder.hpp"
#include "core/infer/module/module_library.hpp"
#include "core/subplugin/loader.hpp"
#include "core/text/text.hpp"
#include "elements/tensor_decoder/module_decoder.hpp"
#include "elements/tensor_decoder/sub_plugin_decoder.hpp"
#include "weir/join.hpp"

namespace weir {
namespace {

std::string list(const std::vector<std::string>& names) {
  return names.empty() ? "none" : join(names, ", ");
}

Result<OpenDecoder> of_module(const weir_decoder_type& type, const std::string& mode,
                              DecoderOptions options) {
  const auto declared = infer::option_names(type);
  if (auto status = check_custom(mode, declared, options); !status) return status.error();
  auto warnings = remove_undeclared(mode, declared, &options);
  auto decoder = ModuleDecoder::open(type, options);
  if (!decoder) return decoder.error();
  auto probe = ModuleDecoder::open(type, options);
  if (!probe) return probe.error();
  return OpenDecoder{*std::move(decoder), *std::move(probe), std::move(warnings)};
}

Result<OpenDecoder> with_warnings(Result<OpenDecoder> opened, std::vector<Error> warnings) {
  if (opened)
    for (auto& warning : warnings) opened->warnings.push_back(std::move(warning));
  return opened;
}

const std::vector<std::string> kFirstOption{"option1"};
const std::vector<std::string> kNumberedOptions{"option1", "option2", "option3",
                                                "option4", "option5", "option6",
                                                "option7", "option8", "option9"};

// The error of the module library, extended by the other names.
Error unknown(Error error, const std::string& mode) {
  const auto names = decoder_names();
  error.needed = "one of: " + list(names);
  if (const auto close = nearest(mode, names); !close.empty()) {
    error.difference = "did you mean " + close + "?";
    error.fix = "mode=" + close;
  }
  return error;
}

}  // namespace

Result<OpenDecoder> open_decoder(const std::string& mode, DecoderOptions options) {
  if (mode.empty())
    return Error{.code = Code::DECODER_UNKNOWN,
                 .what = "no mode is set",
                 .offered = "mode=\"\"",
                 .needed = "one of: " + list(decoder_names()),
                 .fix = "tensor_decoder mode=octet_stream"};
  if (equal_ignoring_case(mode, "custom-code"))
    return with_warnings(CustomCodeDecoder::open(options.numbered[0].value_or("")),
                         remove_undeclared(mode, kFirstOption, &options));
  const auto type = infer::ModuleLibrary::instance().decoder(mode);
  if (type) return of_module(**type, mode, std::move(options));
  if (type.error().code != Code::DECODER_UNKNOWN) return type.error();
  const auto descriptor = subplugin::open(subplugin::Kind::Decoder, mode);
  if (!descriptor) return descriptor.error();
  if (!*descriptor) return unknown(type.error(), mode);
  auto warnings = remove_undeclared(mode, kNumberedOptions, &options);
  return with_warnings(
      SubPluginDecoder::open(*static_cast<const GstTensorDecoderDef*>(*descriptor), options),
      std::move(warnings));
}

std::vector<std::string> decoder_names() {
  auto out = infer::ModuleLibrary::instance().decoder_names();
  for (auto& name : subplugin::available(subplugin::Kind::Decoder)) out.push_back(std::move(name));
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

}  // namespace weir
