// Checks a descriptor's version and functions before calling any of them.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "compat/framework_check.hpp"

#include <cstdio>

#include "compat/properties.hpp"

namespace weir::compat {
namespace {

Error refused_framework(const std::string& name, std::string offered, std::string needed,
                        std::string fix) {
  return Error{
      .code = Code::MODULE_REFUSED,
      .what = "the filter sub-plugin " + (name.empty() ? "" : name + " ") + "cannot be used",
      .offered = std::move(offered),
      .needed = std::move(needed),
      .fix = std::move(fix)};
}

std::string hexadecimal(uint64_t number) {
  char text[19];
  std::snprintf(text, sizeof text, "0x%016llx", static_cast<unsigned long long>(number));
  return text;
}

Result<FrameworkFacts> facts_of_v0(const GstTensorFilterFramework& f) {
  const std::string name = f.name ? f.name : "";
  if (name.empty())
    return refused_framework("", "no name", "the name for framework=", ".name = \"NAME\"");
  if (!f.invoke_NN)
    return refused_framework(name, "no invoke_NN", "invoke_NN, which processes a frame",
                             ".invoke_NN = ...");
  const bool gets = f.getInputDimension && f.getOutputDimension;
  if (!gets && !f.setInputDimension)
    return refused_framework(name,
                             f.getInputDimension || f.getOutputDimension
                                 ? "only one of getInputDimension and getOutputDimension"
                                 : "no function that declares the tensors",
                             "getInputDimension and getOutputDimension, or setInputDimension",
                             ".setInputDimension = ...");
  return FrameworkFacts{0, name, f.run_without_model != 0, f.verify_model_path != 0};
}

Result<FrameworkFacts> facts_of_v1(const GstTensorFilterFramework& f) {
  const std::pair<const char*, bool> functions[] = {{"invoke", f.invoke != nullptr},
                                                    {"getFrameworkInfo", f.getFrameworkInfo},
                                                    {"getModelInfo", f.getModelInfo},
                                                    {"eventHandler", f.eventHandler}};
  for (const auto& [function, there] : functions)
    if (!there)
      return refused_framework("", std::string("no ") + function,
                               "invoke, getFrameworkInfo, getModelInfo and eventHandler",
                               "." + std::string(function) + " = ...");
  const OpenRequest nothing{{}, Options(nullptr, 0), "", 0};
  Properties properties("", "", nothing);
  GstTensorFilterFrameworkInfo info{};
  const int result = f.getFrameworkInfo(&f, properties.get(), nullptr, &info);
  if (result < 0)
    return refused_framework("", "getFrameworkInfo returned " + std::to_string(result),
                             "0 or above", "let getFrameworkInfo succeed when no model is open");
  const std::string name = info.name ? info.name : "";
  if (name.empty())
    return refused_framework("", "getFrameworkInfo returned no name",
                             "the name for framework=", "info->name = \"NAME\"");
  return FrameworkFacts{1, name, info.run_without_model != 0, info.verify_model_path != 0};
}

}  // namespace

Result<FrameworkFacts> read_facts(const GstTensorFilterFramework& framework) {
  const uint64_t version = framework.version;
  const auto api = static_cast<unsigned>(version >> 16 & 0xFFFF);
  if (version >> 32 != 0xDEAFDEAD || api > 1)
    return refused_framework("", "version " + hexadecimal(version),
                             "0xdeafdead0000.... (version 0) or 0xdeafdead0001.... (version 1)",
                             ".version = GST_TENSOR_FILTER_FRAMEWORK_V1");
  return api == 0 ? facts_of_v0(framework) : facts_of_v1(framework);
}

}  // namespace weir::compat
